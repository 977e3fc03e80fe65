"""What acts beside the cells, probes and maxima, for a run that goes on with another number of ranks.

Contact and loads are on the first rank in one order, but refer to boundary nodes whose numbers depend on the cut: the
numbers of the run are taken from the checkpoint, the references from the new run.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..device import arrays
from ..kernels import rigid_places as at
from ..kernels.lanes import GRAVITY
from ..kernels.load_places import ENTRIES, ENTRY, FACE, FACES, FORCE, HEAD, NODE, NODES, STARTED
from ..planning.partition.domain_part import DomainPart
from ..schemes.sensors import moving_nodes
from .checkpoint import store
from .loop import Run
from .rank_cut import Cut


@dataclass(frozen=True)
class Place:
    """A domain of the new run, for what is put into it.

    state: its `DomainState`; cut: the domain as the ranks of the checkpoint had it; part: that of this rank, None on
    one process; gravity [3] [m/s^2]: at the level of the checkpoint.
    """

    state: Any
    cut: Cut
    part: DomainPart | None
    gravity: np.ndarray


def _records(place: Place, data: np.ndarray) -> np.ndarray:
    """Return the places of the obstacles from a checkpoint, and the rest of their records from this run."""
    obstacles = place.state.contact.obstacles
    own = np.array(arrays.get(obstacles.records)).reshape(-1, obstacles.names.RECORD)
    found = data.reshape(own.shape).copy()
    parameters = slice(obstacles.names.PARAMETERS, obstacles.names.VELOCITY)
    found[:, parameters] = own[:, parameters]
    return found.reshape(-1)


def _motion(place: Place, data: np.ndarray) -> np.ndarray:
    """Return the table of the motion of obstacles in a launch, which is made anew, as its length differs."""
    return np.array(arrays.get(place.state.contact.obstacles.motion))


def _rigid(place: Place, data: np.ndarray) -> np.ndarray:
    """Return the records of the rigid bodies from a checkpoint; poses of driven ones are made anew for every launch."""
    own = np.array(arrays.get(place.state.rigid.values))
    end = int(own[at.ARMS_AT])
    for kept in (slice(at.REACH, at.FIRST_STEP + 1), slice(at.HEAD, end)):
        own[kept] = data[kept]
    return own


def _loads(place: Place, data: np.ndarray) -> np.ndarray:
    """Return the loads of the boundary nodes at the level of a checkpoint, and what the next step needs of them."""
    state, domain = place.state, place.state.domain
    own, first = np.array(arrays.get(state.boundary_nodes.load)), 3 * len(domain.boundary)
    if state.loads is None:
        return own
    now = domain.tensors @ place.gravity if domain.pulled else domain.loads.copy()
    now[domain.tied] = 0.0
    mine, stored = own[first:], data[3 * len(place.cut.boundary_of(0)) :]
    count = int(mine[NODES])
    nodes, before = (part[HEAD : HEAD + NODE * count].reshape(-1, NODE) for part in (mine, stored))
    nodes[:, 1:] = before[:, 1:]
    now[nodes[:, 0].astype(int)] += nodes[:, FORCE : FORCE + 3]
    own[:first], mine[STARTED] = now.reshape(-1), stored[STARTED]
    rows = [HEAD + int(NODE * part[NODES] + ENTRY * part[ENTRIES] + FACE * part[FACES]) for part in (mine, stored)]
    width = state.loads.width
    mine[rows[0] : rows[0] + width] = stored[rows[1] : rows[1] + width]
    return own


def _parameters(place: Place, data: np.ndarray) -> np.ndarray:
    """Return the parameters of a step with the gravity of a checkpoint; the rest is set in every step."""
    own = np.array(arrays.get(place.state.internal_force.parameters))
    own[GRAVITY : GRAVITY + 3] = place.gravity
    return own


FORMS: dict[re.Pattern[str], Callable[[Place, np.ndarray], np.ndarray]] = {
    re.compile(rf"domains\.(\d+)\.{path}$"): make
    for path, make in {
        r"contact\.obstacles\.records": _records,
        r"contact\.obstacles\.motion": _motion,
        r"rigid\.values": _rigid,
        r"boundary_nodes\.load": _loads,
        r"internal_force\.parameters": _parameters,
    }.items()
}
OF_FUNCTION = re.compile(r"domains\.(\d+)\.loads\.functions\.(\d+)\.0/(.*)$")


def of_acting(
    run: Run,
    cuts: Sequence[Cut],
    stored: Mapping[str, np.ndarray],
    parts: Sequence[DomainPart] | None,
    shapes: Mapping[str, Any],
) -> dict[str, np.ndarray]:
    """Return by path the arrays of a new run that hold what acts beside the cells at the level of a checkpoint.

    stored: arrays of the first rank of the checkpoint; parts: of this rank, None on one process; shapes: paths that
    the new run has.
    """
    found: dict[str, np.ndarray] = {}
    for path, data in stored.items():
        for form, make in FORMS.items():
            match = form.match(path)
            if match is not None and path in shapes:
                number = int(match[1])
                state = run.domains[number]
                if make is not _parameters or state.domain.pulled:
                    parameters = stored.get(f"domains.{number}.internal_force.parameters", np.zeros(0))
                    part = None if parts is None else parts[number]
                    gravity = parameters[GRAVITY : GRAVITY + 3]
                    found[path] = make(Place(state, cuts[number], part, gravity), data)
    return found | _gravity_calls(run, stored, shapes)


def _gravity_calls(run: Run, stored: Mapping[str, np.ndarray], shapes: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return the recorded calls of a gravity that is a function of time: the last function of the first rank."""
    found: dict[str, np.ndarray] = {}
    known = [(match, data) for path, data in stored.items() if (match := OF_FUNCTION.match(path)) is not None]
    for number, state in enumerate(run.domains):
        if state.loads is not None and state.domain.pulled:
            own = [(match, data) for match, data in known if int(match[1]) == number]
            last = max((int(match[2]) for match, _ in own), default=0)
            path = f"domains.{number}.loads.functions.{len(state.loads.functions) - 1}.0"
            found |= {f"{path}/{match[3]}": data for match, data in own if int(match[2]) == last and path in shapes}
    return found


def restore_sensors(
    run: Run,
    cuts: Sequence[Cut],
    stored: Sequence[store.Stored],
    parts: Sequence[DomainPart] | None,
    found: dict[str, np.ndarray],
    values: dict[str, Any],
) -> None:
    """Put the largest values so far into the state of the rank that has their cell, and what probes keep of nodes.

    found, values: arrays and other values of the new run by path.
    """
    for number, (state, cut) in enumerate(zip(run.domains, cuts, strict=True)):
        head = f"domains.{number}.sensors/"
        for known in (found, values):
            for path in [path for path in known if f"{path}/".startswith(head)]:
                del known[path]
        if state.sensors is None:
            continue
        part = None if parts is None else parts[number]
        for name in state.sensors.motion.kept():
            found[f"{head}{name}"] = _of_probes(state, cut, stored, f"{head}{name}", part)
        for name in state.scene.maxima:
            path, several = f"{head}maximum.{name}", []
            for rank, one in enumerate(stored):
                if path in one.values:
                    value, time, label, cell = one.values[path]
                    body = [plan.label for plan in cut.domain.bodies].index(label)
                    whole = int(cut.parts[rank].bodies[body].part.cells[cell]) if cut.parts else cell
                    several.append((-value, time, body, whole, label))
            if several:
                value, time, body, cell, label = min(several)
                here = np.array([cell]) if parts is None else _where(parts[number].bodies[body].part.cells, cell)
                if len(here):
                    values[path] = [-value, time, label, int(here[0])]


def _of_probes(state: Any, cut: Cut, stored: Sequence[store.Stored], path: str, part: DomainPart | None) -> np.ndarray:
    """Return what stands under a path for the nodes [k, 3] of a rank whose motion probes measure."""
    whole = np.zeros((len(cut.domain.reference), 3))
    for rank, one in enumerate(stored):
        if path in one.found:
            domain = cut.parts[rank].domain if cut.parts else cut.domain
            whole[cut.nodes(rank)[moving_nodes(domain.bodies, domain.node_start)]] = one.found[path].reshape(-1, 3)
    nodes = moving_nodes(state.domain.bodies, state.domain.node_start)
    return np.asarray(whole[nodes if part is None else part.nodes[nodes]])


def _where(cells: np.ndarray, cell: int) -> np.ndarray:
    return np.flatnonzero(cells == cell)
