"""Numbers with which host and serial kernel control a launch, and the rows that the host must check."""

from ..columns import raw_places
from ..engine import ti
from ..nodes.rigid_record import rigid_rate
from ..rigid_places import LIMIT
from .raw_rows import row_width

# numbers of `control`: state to start in; rows to do; steps before and after the time level [s]; 1: exact constraint;
# limits of det F and energy [J] for `suspicious`; rows done; 1: first measure of the static solve; 1: a parallel
# measure is needed; 1: the friction layers must take their step; limit of the viscous rate [1/s]; 1: the rows of pairs
# of bodies must be built anew; limit of the number of nodes in contact; 1: the forces of the contact cells are those of
# the present positions; behind these, in scenes with loads, 1: the host must compute them
START, ROWS, BEFORE, AFTER, EXACT, JACOBIAN_LIMIT, ENERGY_LIMIT = 0, 1, 2, 3, 4, 5, 6
ROWS_DONE, FIRST, WANTS_MEASURE, WANTS_LAYERS = 7, 8, 9, 10
RATE_LIMIT, WANTS_ROWS, CONTACT_LIMIT, KNOWN = 11, 12, 13, 14
CONTROL = WANTS_LOADS = 15
# states of the loop, and values of control[START]
PASS, BOUNDARY, PLACE, PRODUCT, MEASURED, KICK = 0, 1, 2, 3, 4, 5
STOP, VISCOUS, LOADS = 6, 7, 8


@ti.func
def suspicious(raw: ti.template(), number, control: ti.template(), contact: ti.template(), viscous: ti.template(),
               plastic: ti.template(), rigid: ti.template()):  # fmt: skip
    """Return 1 if the host must check a row.

    It has a value that is not finite, an inverted cell, too much energy, too much viscosity for the step, too light a
    rigid body for it, or many more nodes in contact.
    """
    place = number * row_width(contact, viscous, plastic)
    places = ti.static(raw_places(viscous or contact.options.viscous, plastic))
    energy = raw[place + places.nodes.kinetic] + raw[place + places.cells.elastic]
    energy += raw[place + places.shared.kinetic]
    calm = energy <= control[ENERGY_LIMIT] and raw[place + places.cells.jacobian_min] > control[JACOBIAN_LIMIT]
    if ti.static(viscous):
        calm = calm and raw[place + places.cells.viscous_rate] <= control[RATE_LIMIT]
    if ti.static(contact.options.model != ""):
        calm = calm and raw[place + places.shared.contact_nodes] <= control[CONTACT_LIMIT]
    if ti.static(rigid.exist):
        calm = calm and rigid_rate(rigid) <= rigid.values[LIMIT]
    return ti.select(calm, 0, 1)
