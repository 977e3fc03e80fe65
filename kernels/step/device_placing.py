"""The massless nodes of a step on a GPU before the static solve: predicted, and moved out of obstacles (METHOD 2)."""

from ..contact.cell_viscosity import RATE
from ..contact.friction import STEP
from ..contact.obstacle_rows import choose_candidates, fill_rows
from ..engine import ti
from ..lanes import MAXIMUM_SLOTS
from ..language.threads import leader
from ..static.massless_contact import move_out, predict
from ..static.sliding import restart_slip


@ti.func
def rate_of(step):
    """Return the inverse of a step, 0 for none: the factor of the strains of viscous contact cells in it."""
    return ti.select(step > 0.0, 1.0 / ti.max(step, 1e-300), 0.0)


@ti.func
def placed(
    body: ti.template(), obstacles: ti.template(), rows: ti.template(), contact: ti.template(), launch: ti.template(),
    ratio, fall, after, exact: ti.template(),
):  # fmt: skip
    """Predict the massless nodes and move them out of obstacles.

    after [s]: the step that begins, 0 at the start of a run.
    """
    if ti.static(contact.options.viscous):
        if leader(contact) == 1:
            launch.viscous_cells[RATE] = rate_of(after)
    if ti.static(contact.options.static_friction):
        if leader(contact) == 1:
            contact.friction[STEP] = after
        if after == 0.0:
            restart_slip(body, contact)
    if ti.static(contact.options.obstacle_slots == MAXIMUM_SLOTS):
        choose_candidates(obstacles, contact, body.u)
    predict(body, contact, ratio, fall)
    if ti.static(exact):
        fill_rows(obstacles, rows, contact, body.u)
        move_out(body, contact, rows)
