"""Go on with a run on another number of ranks: values at nodes and cells go to the ranks that now have them.

The numbers of the run itself (history, step, times of looks) are equal on all ranks; what acts beside the cells is on
the first rank, in an order that the number of ranks does not change. What is left are displacements, velocities and
search vectors at the nodes and the state of the points of the cells: they are put together from all checkpoints, in
the numbering of the whole plan, and every rank takes those of its part; a contact that ranks share likewise. The rest
is written in every step before it is read.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..cells.point_state import PointState, has_state, shape_of
from ..device import arrays
from ..device.team import Team
from ..kernels.lanes import WIDTH
from ..planning.domain import Domain
from ..planning.domain_packs import pack_domain
from ..planning.partition.domain_part import DomainPart
from ..planning.partition.shared_contact import is_copied
from ..planning.planning import Plan
from ..schemes.explicit.rank_view import RankView
from .checkpoint import contents, store
from .loop import Run
from .rank_cut import Cut
from .rank_recut_acting import FORMS, of_acting, restore_sensors
from .rank_recut_contact import OF_CONTACT, OF_OBSTACLES, is_shared, of_contact
from .rank_recut_pairs import OF_CELLS, of_pairs
from .rank_recut_viscous import of_viscous_cells, of_viscous_metals

AT_NODES = re.compile(r"domains\.(\d+)\.(?:u|v|start_velocity)$")
OF_RATES = re.compile(r"shape\._rates\.(\d+)\.before$")
OF_SEARCH = re.compile(r"limits\.(\d+)\.bodies\.(\d+)\.(damping\.)?start$")
LIMIT = re.compile(r"limits\.\d+\.bodies\.\d+\.(?:elastic|damped)$")
OF_FIRST = re.compile(
    r"domains\.\d+\.(?:(?:contact|rigid|driven|sensors|timed)\b|loads\.(?:_next$|_failed$|_reason$|_told$|functions\.))"
)
# written in every step before it is read
SCRATCH = re.compile(
    r"domains\.\d+\.(?:_counted|_kick|_before|supports\.speeds|boundary_nodes\.mass|serial\.(?:sums|control)"
    r"|internal_force\.(?:rows|special_force|node_sums|cell_sums|parameters|memory|bulk_viscosity|volumes))$"
    r"|limits\.\d+\.force\.|shape\._rates\.\d+\._arrays\.|team\."
)
OF_PART = ("team.", "parts.", "domains.", "limits.", "shape._rates.")  # what every rank makes of its own part


def other_ranks(before: int, now: int) -> str:
    """Return the warning that the last digits of a run will differ."""
    was, goes_on = ("one process" if count == 1 else f"{count} ranks" for count in (before, now))
    return f"the run was on {was} and goes on with {goes_on}: it agrees to rounding, not bit for bit"


def restore_parts(run: Run, planned: Plan, stored: Sequence[store.Stored], team: Team | None) -> None:
    """Give a new run the state in the checkpoints [ranks] of a run on another number of ranks.

    planned: plan of the whole scene; team: the ranks of the new run, None for one process.
    Raises `InputError` if the parts were not those of the checkpoints.
    """
    contact = stored[0].head.get("contact_ranks")
    cuts = [Cut(domain, planned.scene, len(stored), contact) for domain in planned.domains]
    _check_parts(cuts, stored)
    ranks = 1 if team is None else team.size
    _check_known(stored, ranks)
    leads = team is None or team.leads
    shapes = contents.shapes(run)
    parts: list[DomainPart] | None = getattr(run, "parts", None)
    several = [is_shared(cut, None if parts is None else parts[number]) for number, cut in enumerate(cuts)]
    copied = [is_copied(cut.domain) and state.contact is not None for cut, state in zip(cuts, run.domains, strict=True)]
    found, values = (
        {path: one for path, one in own.items() if _is_taken(path, leads, several, copied)}
        for own in (stored[0].found, stored[0].values)
    )
    if not leads:  # what the first rank alone has
        found, values = (
            {path: one for path, one in own.items() if path.partition("/")[0] in shapes} for own in (found, values)
        )
    made = of_acting(run, cuts, stored[0].found, parts, shapes)
    made |= of_contact(run, cuts, stored, parts) | of_viscous_cells(run, cuts, stored, parts)
    made |= of_viscous_metals(run, cuts, stored, parts)
    for number, cut in enumerate(cuts):
        if copied[number]:
            part = None if parts is None else parts[number]
            of_pairs(run.domains[number], cut, part, f"domains.{number}.contact.pairs", found)
    made |= _of_contact_nodes(run, found, shapes)
    for path, value in found.items():
        if path not in made and shapes.get(path) not in (None, value.shape):
            text = f"as {path} stands in another order there"
            raise InputError("ranks", ranks, f"start {len(stored)} to go on, {text}")
    found |= made
    restore_sensors(run, cuts, stored, parts, found, values)
    for path, now in sorted((path, shape) for path, shape in shapes.items() if shape is not None):
        if any(path in one.found for one in stored):
            mine = _at_nodes(run, path, cuts, stored, parts, team)
            if mine is not None:
                found[path] = mine.reshape(now)
    contents.restore(run, found, values)
    for state in run.domains:
        if state.contact is not None and state.contact.pairs is not None:
            state.rebuilds_before = state.contact.pairs.rebuilds
    for number, cut in enumerate(cuts):
        _hold_pressures(run, number, cut, stored, parts)
    if has_state(planned.scene):
        for number, cut in enumerate(cuts):
            _restore_points(run, number, cut, stored)


def _of_contact_nodes(run: Run, found: Mapping[str, np.ndarray], shapes: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return by path the contact forces where masters that supports hold stand behind those of the contact nodes.

    Every part has other boundary nodes; the next row sets the forces on these.
    """
    result = {}
    for number, state in enumerate(run.domains):
        path = f"domains.{number}.contact.contact_force"
        if state.contact is not None and path in found and shapes.get(path) not in (None, found[path].shape):
            count = state.contact.contact_node_forces().size
            result[path] = np.zeros(shapes[path])
            result[path][:count] = found[path][:count]
    return result


def _is_taken(path: str, leads: bool, several: Sequence[bool], copied: Sequence[bool]) -> bool:
    """Return whether a rank takes a value of the first rank as it is; several: of domains whose contact ranks share.

    Of these it takes the obstacles, which all ranks with contact have. copied: of domains of which it has a whole
    contact with pairs of bodies.
    """
    match = OF_CONTACT.match(path)
    if match is not None and copied[int(match[1])]:
        return OF_CELLS.match(path) is None
    if match is not None and several[int(match[1])]:
        return OF_OBSTACLES.match(path) is not None
    return _is_kept(path, leads)


def _is_kept(path: str, leads: bool) -> bool:
    """Return whether a rank takes a value as it is: that of the run, on the first rank also what acts there."""
    return not path.startswith(OF_PART) or LIMIT.match(path) is not None or (leads and OF_FIRST.match(path) is not None)


def _check_parts(cuts: Sequence[Cut], stored: Sequence[store.Stored]) -> None:
    """Raise `InputError` if a checkpoint has other nodes than the part of its rank."""
    for number, cut in enumerate(cuts):
        for rank, one in enumerate(stored):
            values = one.found.get(f"domains.{number}.u")
            if values is not None and len(values) != 3 * len(cut.nodes(rank)):
                text = f"start {len(stored)} to go on: its mesh was cut by another version of pymetis"
                raise InputError("ranks", len(stored), text)


def _check_known(stored: Sequence[store.Stored], ranks: int) -> None:
    """Raise `InputError` where a checkpoint holds what only as many ranks can take over."""
    for one in stored:
        for path in one.found:
            known = (AT_NODES, OF_RATES, OF_SEARCH, SCRATCH, OF_FIRST, *FORMS)
            if not _is_kept(path, False) and not any(form.match(path) for form in known):
                raise InputError("ranks", ranks, f"start {len(stored)} to go on, which a run with {path} needs")


def _at_nodes(
    run: Run,
    path: str,
    cuts: Sequence[Cut],
    stored: Sequence[store.Stored],
    parts: Sequence[DomainPart] | None,
    team: Team | None,
) -> np.ndarray | None:
    """Return the values [n, 3] of this rank at its nodes that stand under a path; None for other paths."""
    search = OF_SEARCH.match(path)
    if search is not None:
        number, body = int(search[1]), int(search[2])
        cut, own = cuts[number], None if parts is None else parts[number].bodies[body]
        whole = np.zeros((len(cut.domain.bodies[body].reference), 3))
        _put(whole, path, [cut.nodes_of_body(rank, body) for rank in range(len(stored))], stored)
        if own is None:
            return whole
        mine = whole[own.nodes]
        if search[3]:  # momenta, of which the copies add up
            mine[own.part.owner[own.plan.node_order] != own.part.rank] = 0.0
        return mine
    match = AT_NODES.match(path) or OF_RATES.match(path)
    if match is None:
        return None
    number = int(match[1])
    if path.startswith("shape"):
        assert run.shape is not None
        number = [id(one) for one in run.domains].index(id(run.shape.domains[number]))
    cut, state = cuts[number], run.domains[number]
    if path.startswith("domains"):
        present = np.array(arrays.get(getattr(state, path.rpartition(".")[2]))).reshape(-1, 3)
        whole = present if team is None else state.whole_on_all(present)
    else:
        whole = np.zeros((len(cut.domain.reference), 3))
    _put(whole, path, [cut.nodes(rank) for rank in range(len(stored))], stored)
    return whole if parts is None else whole[parts[number].nodes]


def _put(whole: np.ndarray, path: str, nodes: Sequence[np.ndarray], stored: Sequence[store.Stored]) -> None:
    """Put the values of all ranks at their nodes into `whole`, the lowest rank last."""
    for own, one in reversed(list(zip(nodes, stored, strict=True))):
        if path in one.found:
            whole[own] = one.found[path].reshape(-1, 3)


def _lanes(whole: Domain, part: DomainPart | None) -> tuple[int, list[tuple[int, np.ndarray, np.ndarray]]]:
    """Return the number of lanes of all packs (planning/packing.py) of a part, and the lanes of its cells.

    They are by block: number of its body in the whole domain, lanes [m], numbers [m] of their cells in its mesh.
    """
    domain, there = (whole, range(len(whole.bodies))) if part is None else (part.domain, part.there)
    found, first = [], 0
    for touching in (False, True):
        for block in domain.blocks:
            body = there[[id(one) for one in domain.bodies].index(id(block.body))]
            ordinary = block.count - len(block.contact)
            numbers = block.body.cell_order[block.own.first + block.order]
            cells = numbers[ordinary:] if touching else numbers[:ordinary]
            cells = cells if part is None else part.bodies[body].part.cells[cells]
            found.append((body, first + np.arange(len(cells)), cells))
            first += -(-len(cells) // WIDTH) * WIDTH
    return first, found


def _hold_pressures(
    run: Run, number: int, cut: Cut, stored: Sequence[store.Stored], parts: Sequence[DomainPart] | None
) -> None:
    """Give the cells the pressure of bulk viscosity of the last pass, which stands behind the sums of a pass."""
    force, path = run.domains[number].internal_force, f"domains.{number}.internal_force.cell_sums"
    if not force.viscous:
        return
    whole = [np.zeros(body.body.mesh.cell_count) for body in cut.domain.bodies]
    for rank, one in enumerate(stored):
        count, places = _lanes(cut.domain, cut.parts[rank] if cut.parts else None)
        for body, lanes, cells in places if path in one.found else ():
            whole[body][cells] = one.found[path][len(one.found[path]) - count :][lanes]
    sums = np.array(arrays.get(force.cell_sums))
    count, places = _lanes(cut.domain, None if parts is None else parts[number])
    for body, lanes, cells in places:
        sums[len(sums) - count :][lanes] = whole[body][cells]
    arrays.set_values(force.cell_sums, sums)


def _restore_points(run: Run, number: int, cut: Cut, stored: Sequence[store.Stored]) -> None:
    """Give the points of the cells of a domain the state in the checkpoints."""
    views = run.domains[number].views
    whole = [view.points_on_all() if isinstance(view, RankView) else view.points() for view in views]
    for rank, one in enumerate(stored):
        memory = one.found.get(f"domains.{number}.internal_force.memory")
        if memory is None:
            continue
        part = cut.parts[rank] if cut.parts else None
        domain, there = (cut.domain, range(len(views))) if part is None else (part.domain, part.there)
        kept = {block.kind: int(np.prod(shape_of(block))) for block in domain.blocks}
        packs: Any = SimpleNamespace(memory=memory, packs=pack_domain(domain, one.head["chunks"], kept))
        points = PointState(domain, packs)
        for own, body in enumerate(there):
            blocks = cut.domain.bodies[body].body.blocks
            everyone = np.arange(cut.domain.bodies[body].body.mesh.cell_count)
            names = [(block.kind, block.region) for block in domain.bodies[own].body.blocks]
            states = dict(zip(names, points.blocks_of_body(own), strict=True))
            for block, target in zip(blocks, whole[body], strict=True):
                if (block.kind, block.region) in states:
                    here = (
                        slice(None) if part is None else np.isin(everyone[block.numbers], part.bodies[body].part.cells)
                    )
                    target[here] = states[block.kind, block.region]
    for view, state in zip(views, whole, strict=True):
        view.start_points(state)
