"""Prepare a run: the plan with what its options ask for, the state that it takes over, the head of its checkpoints."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

from ..device import runtime
from ..friction_layer import LayerState
from ..planning.packing import chunks_for
from ..planning.planning import Plan, plan
from ..results import frame_fields
from ..results.pair_memory import PairMemory
from ..results.report import versions
from ..scene.scene import Scene
from ..schemes.explicit.pair_memory import go_on
from .checkpoint import Checkpoint
from .checkpoint.fingerprint import fingerprint
from .loop import Run
from .precision import set_precision


def finished_plan(scene: Scene, scheme: Any, precision: str, fields: Sequence[str]) -> Plan:
    """Plan a scene for a scheme, a precision and the fields of its frames (none: it has no folder)."""
    planned = plan(scene)
    scheme.check(planned)
    _warn_steep(scene, planned)
    set_precision(planned, precision)
    record_friction(planned, fields)
    return planned


def record_friction(planned: Plan, fields: Sequence[str]) -> None:
    """Let the domains sum up slip and friction work of their contact nodes where frames hold these."""
    for domain in planned.domains:
        domain.records_friction = not frame_fields.FRICTION.keys().isdisjoint(fields)


def _warn_steep(scene: Scene, planned: Plan) -> None:
    """Warn of coefficients above 1: Coulomb friction in the static solve may then have several solutions (METHOD 3)."""
    coefficient = scene.largest_friction
    stays = any(body.contact is not None and body.contact.block > 1 and body.contact.graph for body in planned.bodies)
    if coefficient > 1.0 and stays:
        warnings.warn(
            f"a friction coefficient of {coefficient:g} with full removal may have several solutions; removal='normal'"
            " has one at any coefficient",
            RuntimeWarning,
            stacklevel=3,
        )


def start_terms(
    run: Run, layers: tuple[LayerState | None, ...], pairs: PairMemory | None, goes_on: bool = False
) -> None:
    """Start from the friction layers of another run, one for each body, and from what its pairs of bodies remember.

    goes_on: the run starts from the end of another one, whose friction the nodes are in equilibrium with.
    """
    go_on(run.domains, run.scene, pairs)
    for domain in run.domains if goes_on else ():
        rows = getattr(domain.contact, "rows", None)
        if rows is not None:
            rows.go_on()
    for state, left in zip(run.states, layers, strict=bool(layers)):
        if left is not None:
            state.start_layers(left)


def checkpoint_head(
    scene: Scene,
    scheme: Any,
    options: Checkpoint,
    fields: Sequence[str],
    history: tuple[int, int],
    pressures: bool,
    precision: str,
) -> dict[str, Any]:
    """Return the plain data of the checkpoints of a run; history: rows between two kept ones, and their most."""
    head: dict[str, Any] = {"physics": fingerprint(scene, scheme), "versions": versions()}
    head |= {"history_every": history[0], "pressures": pressures, "fields": list(fields)}
    head |= {"chunks": chunks_for(runtime.threads()), "precision": precision, "arch": runtime.arch()}
    return head | {"history_rows": history[1], "origin": dict(options.origin), "keep": options.keep}
