"""Stop a run in which a body of a pair gets deep into the other one: contact was missed, or has no faces there.

Contact between two bodies keeps the nodes of their contact faces apart. Other faces of the two may meet: a surface node
that stands deeper in the other body than an edge of the finer surface shows it. Bodies that go further in one step than
contact reaches would pass the faces of each other unseen: they are stopped before they meet.
"""

from __future__ import annotations

import numpy as np

from ...contact.pairs.coupling import FAR
from ...mesh.triangle_distance import boxes_of, smallest_distance, winding_number
from ...scene.meeting import FACING
from ..guards import Stop
from ..watched import Run
from .body_meeting import Surface
from .pace import AHEAD, FARTHER, Pace
from .pair_entered import PairEntered
from .slabs import within_slabs

DEEP = 1.0  # depth over the mean edge of the finer surface that contact does not explain
RARELY = 32  # most rows between two looks
SAMPLES = 64  # largest number of nodes whose depth is measured at a look


class PairOverlap:
    """Looks for nodes of a body of a pair that are deep in the other one."""

    ends_launches = True

    def __init__(self, run: Run) -> None:
        self._surfaces = [Surface(body, state) for body, state in zip(run.scene.bodies, run.states, strict=True)]
        self._before = [surface.positions(state) for surface, state in zip(self._surfaces, run.states, strict=True)]
        self.due, self._seen, self._time = 0, -1, 0.0
        self._pace = Pace(run, RARELY)
        self._seen_by_contact = _depths(run)
        self.entered = PairEntered(run, self._surfaces)

    @staticmethod
    def of(run: Run) -> PairOverlap | None:
        """Make the looks of a run; None without pairs of bodies."""
        return PairOverlap(run) if run.scene.body_pairs else None

    def look(self, run: Run, row: int, time: float, step: float) -> Stop | None:
        """Stop where a node of a pair is too deep in the other body."""
        now = [surface.positions(state) for surface, state in zip(self._surfaces, run.states, strict=True)]
        if not all(np.isfinite(there).all() for there in now):
            return None  # the guards stop at the next row
        rows = max(1, row - self._seen)
        wait = min(float(RARELY), FARTHER * rows)
        self._pace.follow(self._before, now, self._time, time + step, step)
        for pair in run.scene.body_pairs:
            deep = DEEP * min(self._surfaces[number].mean_edge for number in (pair.first, pair.second))
            both = [(now[number].min(axis=0), now[number].max(axis=0)) for number in (pair.first, pair.second)]
            apart = max(0.0, float(np.max([both[1][0] - both[0][1], both[0][0] - both[1][1]])))
            both_ways = ((pair.first, pair.second), (pair.second, pair.first)) if apart == 0.0 else ()
            for one, other in both_ways:
                place = _deep_node(now[one], now[other], self._surfaces[other].closed, deep)
                if place is not None:
                    return _overlap(run.scene.label(one), run.scene.label(other), place, time + step)
            moved = [(now[number] - self._before[number]) / rows for number in (pair.first, pair.second)]
            way = moved[0].mean(axis=0) - moved[1].mean(axis=0)  # of one body against the other in a step
            speed = float(np.linalg.norm(way))
            speed += sum(float(np.linalg.norm(part - part.mean(axis=0), axis=1).max()) for part in moved)
            depth = self._seen_by_contact[pair.first, pair.second]
            if speed > depth and apart <= AHEAD * speed:
                parts = []
                for number, own in zip((pair.first, pair.second), moved, strict=True):
                    faces = self._surfaces[number].triangles
                    parts.append((self._before[number][faces], own[faces].mean(axis=1)))
                if _passes(parts[0], parts[1], rows + AHEAD, depth):
                    return _too_fast(run.scene.label(pair.first), run.scene.label(pair.second), depth, time + step)
            for one, other in both_ways if speed <= depth else ():  # faster ones are deep before contact sees them
                self.entered.look(run, one, other, now, time + step)
            wait = min(wait, float(self._pace.rows(np.array(apart + deep), pair.first, pair.second)))
        self.due = row + int(np.clip(wait, 1, RARELY))
        self._before, self._seen, self._time = now, row, time + step
        return None


def _depths(run: Run) -> dict[tuple[int, int], float]:
    """Return for both bodies of every pair how deep [m] contact sees the surface of one in the other."""
    found = {}
    for domain in run.domains:
        pairs = None if domain.contact is None else domain.contact.pairs
        for facing in [] if pairs is None else pairs.facings:
            for number in np.unique(facing.pair[facing.pair >= 0]):
                one = domain.domain.pairs[number]
                found[one.first, one.second] = FAR * facing.reach
    return found


def _passes(
    one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray], steps: float, depth: float
) -> bool:
    """Return whether a face of one body meets one of the other that comes further in a step than `depth` [m].

    one, other: triangles [k, 3, 3] [m] of both, and their ways [k, 3] [m] in each of so many steps from there on.
    """
    (corners, ways), (others, their_ways) = one, other
    normals, theirs = (_unit_normals(triangles) for triangles in (corners, others))
    low, high = boxes_of(others)
    mean = their_ways.mean(axis=0)
    spread = float(np.linalg.norm(their_ways - mean, axis=1).max())
    for number in np.flatnonzero(np.einsum("ki,ki->k", normals, ways - mean) + spread > depth):
        triangle, normal, way = corners[number], normals[number], ways[number] - their_ways
        end = steps * way
        found = (high >= triangle.min(axis=0) + np.minimum(end, 0.0)).all(axis=1)
        found &= (low <= triangle.max(axis=0) + np.maximum(end, 0.0)).all(axis=1)
        found &= (way @ normal > depth) & (theirs @ normal < FACING)
        if found.any() and (((others[found] - triangle.mean(axis=0)) @ normal).max(axis=1) > -depth).any():
            return True
    return False


def _unit_normals(triangles: np.ndarray) -> np.ndarray:
    """Return the unit normals [k, 3] of triangles [k, 3, 3]; 0 for those without an area."""
    found = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    sizes = np.linalg.norm(found, axis=1)[:, None]
    return np.divide(found, sizes, out=np.zeros_like(found), where=sizes > 0.0)


def _too_fast(one: str, other: str, depth: float, time: float) -> Stop:
    text = f"faces of bodies {one} and {other} come more than {depth:.3g} m closer in a step at t = {time:.6g} s,"
    return Stop("missed-contact", f"{text} further than contact sees: give a smaller cfl, or coarser contact faces")


def _deep_node(nodes: np.ndarray, other: np.ndarray, closed: np.ndarray, deep: float) -> np.ndarray | None:
    """Return the position [3] of a node [n, 3] further than `deep` [m] inside the surface of another body, or None.

    other [k, 3]: positions of the surface nodes of that body; closed [m, 3]: its triangles.
    """
    from scipy.spatial import cKDTree

    near = nodes[within_slabs(nodes, other, deep)]
    if not len(near):
        return None
    near = near[:: -(-len(near) // SAMPLES)]
    nearest, _ = cKDTree(other, balanced_tree=False, compact_nodes=False).query(near, distance_upper_bound=deep)
    triangles = other[closed]
    for node in near[~np.isfinite(nearest)]:  # no corner of the surface within that distance
        inside_other = winding_number(node, triangles) > 0.5
        if inside_other and smallest_distance(np.tile(node, (1, 3, 1)), triangles, deep) >= deep:
            return np.asarray(node)
    return None


def _overlap(one: str, other: str, place: np.ndarray, time: float) -> Stop:
    where = ", ".join(f"{part:.4g}" for part in place)
    text = f"a node of body {one} at ({where}) is deep inside body {other} at t = {time:.6g} s: faces outside their"
    text += " contact sets met, or the bodies went too far in a step: add the faces to Body.contact (contact='all': the"
    return Stop("missed-contact", f"{text} whole surface), or give a smaller cfl or a stiffer penalty")
