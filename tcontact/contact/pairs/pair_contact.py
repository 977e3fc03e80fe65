"""The rows of all pairs of a domain as the kernels read them, and when they are built anew (kernels/pair_places.py)."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...base.warning_kinds import SlaveWarning
from ...device import arrays
from ...kernels import pair_places as at
from ...planning.body_plan import BodyPlan
from ...planning.domain import Domain
from ...scene.slaves import stiffness
from ..constraint_rows import ConstraintRows
from .coupling import Coupling, came_in_fast, couple, deepest_point, empty, starts
from .node_to_surface import couple_nodes
from .search import apart, close_faces
from .start_overlap import refuse_overlaps
from .surfaces import Facing, facings_of, surfaces_of

SLIP = 0.03  # slip since the rows were built, over the size of a slave face, beyond which they are built anew
TIGHT = 1e-6  # tolerance of the static solve below which that slip is smaller in the same ratio
SEARCHED = 4.0  # room of a search over the way of a node, against the mean one, after which it is repeated
COARSE = 0.05  # overlap of a row over the size of a slave face that a warning tells of where no faces overlap
PHANTOM = 0.01  # what rows press in there over the kinetic energy of the bodies, that it tells of
OVERLAP = 1e-6  # overlap at the start over the size of a slave face that rounding may cause
LEFT = 1e-2  # the same where the bodies start displaced, as another run may have left them in contact
YIELDS = 1.0  # the same with a penalty
SPARE = 1.5  # room of the arrays over what they hold, when they grow


class PairContact:
    """Rows of the pairs of a domain, and the candidates of their search.

    lists (int32), values (float64): as in kernels/pair_places.py; larger ones take their place where rows need it.
    tolerance: of the static solve, None for the default; rebuilds, searches: how often rows were built and faces
    searched.
    """

    def __init__(self, domain: Domain, tolerance: float | None = None) -> None:
        contact = domain.contact
        assert contact is not None
        self._boundary, self._bodies, self._node_start = domain.boundary, domain.bodies, domain.node_start
        self._reference = domain.reference
        self._slot = np.full(len(domain.reference), -1)
        self._slot[domain.boundary] = np.arange(len(domain.boundary))
        self._count = len(contact.nodes)
        gives_way = contact.basis is None  # a penalty on nodes with mass
        self._couple = couple_nodes if gives_way else couple
        self._left = YIELDS if gives_way else LEFT
        self.surfaces = surfaces_of(domain)
        self.facings = facings_of(domain, self.surfaces)
        self.labels = [body.label for body in domain.bodies]
        self._first = [pair.first for pair in domain.pairs]
        self._numbers = domain.numbers
        self._nodes = np.unique(np.concatenate([surface.nodes for surface in self.surfaces]))
        self._normal = None
        if contact.block == 1 and contact.basis is not None:
            self._normal = contact.basis[0, :, 0]
        self._closed = np.zeros(self._count)  # gaps [m] of the contact nodes that count as 0
        self._given = np.zeros(self._count, dtype=bool)  # those of another run
        self._start: np.ndarray | None = None  # displacement of the first rows, if another run built them
        self.built = np.full((len(self._nodes), 3), np.nan)  # displacement at which the rows were built
        self.steps = self._built_at = 0  # steps so far, and those up to that build
        self._fast = np.zeros(len(self.facings), dtype=bool)  # surfaces came in fast, and are in contact since
        self._coefficients = np.array([pair.coefficient for pair in domain.pairs])
        self._rows: ConstraintRows | None = None  # with friction
        self._candidates = [np.zeros((0, 2), dtype=np.int64) for _ in self.facings]
        self._searched = np.full((len(self._nodes), 3), np.nan)
        self._slip = SLIP if tolerance is None else SLIP * min(1.0, tolerance / TIGHT)
        self.margin = self._least_margin
        self.rebuilds = self.searches = 0
        self._acting: tuple[np.ndarray, np.ndarray] | None = None  # rows of the present forces, if others replaced them
        with arrays.standing_in(None):  # larger ones take their place
            self.lists = arrays.put(np.zeros(at.LISTS_HEADER, dtype=np.int32))
            self.values = arrays.put(np.zeros(at.VALUES_HEADER))
        self._store([empty() for _ in self.facings], np.zeros_like(self._reference), stale=1.0)

    def set_friction(self, rows: ConstraintRows) -> None:
        """Take over the constraint rows, to which every rebuild gives their coefficient."""
        self._rows = rows
        self._store([empty() for _ in self.facings], np.zeros_like(self._reference), stale=1.0)

    def rebuild(self, u: np.ndarray) -> None:
        """Build the rows at the displacement u [n, 3] [m]; search faces again if the surfaces have moved too far.

        Where the run has diverged the rows stay as they are: the guards stop it at its next row. The first rows of a
        run that goes on are those of the run before (`go_on`).
        """
        present, ago = u, 0
        if self._start is not None:
            u = np.array(u)
            u[self._nodes] = self._searched
            self.search(self._reference + u)
            u[self._nodes], self._start = self._start, None
            ago, self.steps = self.steps, 0
        if not np.isfinite(u[self._nodes]).all():
            return
        positions = self._reference + u
        moved = u[self._nodes] - self._searched
        moved = moved - moved.mean(axis=0)
        if not (np.linalg.norm(moved, axis=1) <= self.margin).all():  # nan before the first search
            self.search(positions)
            self._searched = u[self._nodes].copy()
        couplings = self._coupled(positions, u[self._nodes] - self.built)
        if self.face_pairs:
            self.margin = min(self._least_margin, 0.5 * min(one.waiting for one in couplings))
        if self.rebuilds == 0:
            self._close(couplings, self._reference + present)
        self.built, self._built_at = u[self._nodes], self.steps - ago
        if self._acting is None:
            self._acting = np.array(arrays.get(self.lists)), np.array(arrays.get(self.values))
        self._store(couplings, positions, stale=0.0)
        self.rebuilds += 1

    def _coupled(self, positions: np.ndarray, moved: np.ndarray) -> list[Coupling]:
        """Return the rows of every slave at positions [n, 3] [m]; moved [k, 3] [m]: way of `nodes` since the last."""
        found = []
        for number, (facing, pairs) in enumerate(zip(self.facings, self._candidates, strict=True)):
            if self._couple is couple:  # a penalty holds nodes as deep, fast or not
                nodes = facing.local[0]
                own = positions[nodes], moved[np.searchsorted(self._nodes, nodes)]
                fast = bool(self._fast[number]) or came_in_fast(facing, *own, self.built_ago, pairs)
                rows = couple(facing, positions, pairs, fast)
                self._fast[number] = fast and len(rows.slaves) > 0
            else:
                rows = self._couple(facing, positions, pairs)
            found.append(self._movable(rows))
        return found

    @property
    def fast(self) -> tuple[int, ...]:
        """Numbers in the scene of the slaves whose masters came in fast and touch them since."""
        return tuple(self._numbers[one.slave.body] for one, fast in zip(self.facings, self._fast, strict=True) if fast)

    @property
    def built_ago(self) -> int:
        """Number of steps since the rows were built."""
        return self.steps - self._built_at

    @property
    def nodes(self) -> np.ndarray:
        """The nodes [k] of the domain on the surfaces of its pairs."""
        return self._nodes

    @property
    def closed_gaps(self) -> np.ndarray:
        """The gaps [k] [m] of these nodes that count as 0; NaN but for slaves whose pairs ask for it."""
        found, slot = np.full(len(self._nodes), np.nan), self._slot[self._nodes]
        asks = self._asks_for_closed(slot)
        found[asks] = self._closed[slot[asks]]
        return found

    def _asks_for_closed(self, slot: np.ndarray) -> np.ndarray:
        """Return which nodes, at these places [k], are contact nodes of a slave whose pair closes gaps of the start."""
        slaves = [facing.slave.nodes for facing in self.facings if facing.closed > 0.0]
        wanted = np.isin(self._nodes, np.concatenate(slaves)) if slaves else np.zeros(len(self._nodes), dtype=bool)
        return wanted & (slot >= 0) & (slot < self._count)

    @property
    def searched(self) -> np.ndarray:
        """The displacement [k, 3] [m] of these nodes at which faces were searched."""
        return self._searched

    def go_on(
        self, closed: np.ndarray, built: np.ndarray, searched: np.ndarray, fast: Sequence[int], steps: int
    ) -> None:
        """Go on with the closed gaps [k] [m] of another run, with the rows and candidates of its displacements.

        built, searched [k, 3] [m]: displacements; fast, steps: see `fast`, `built_ago`. Where that run had other
        surfaces the present displacement serves for both.
        """
        slot = self._slot[self._nodes]
        known = self._asks_for_closed(slot) & np.isfinite(closed)
        self._closed[slot[known]], self._given[slot[known]] = closed[known], True
        if np.isfinite(built).all() and np.isfinite(searched).all():
            self._start, self._searched, self.steps = np.array(built), np.array(searched), steps
            self._fast[:] = [self._numbers[facing.slave.body] in fast for facing in self.facings]

    def begin_step(self) -> None:
        """Take the present rows for those of the forces to come."""
        self._acting = None

    def covered_areas(self) -> np.ndarray:
        """Return the area [s] [m^2] of every boundary node that its forces of the last row act on; 0 without a row.

        The area D of a row belongs to its slave, and P_sm D to its masters: a uniform pressure is uniform on both. The
        contact nodes are the first boundary nodes; of the others supports hold some that are masters (`places_of`).
        """
        lists, values = (arrays.get(self.lists), arrays.get(self.values)) if self._acting is None else self._acting
        rows, entries = int(lists[at.ROWS]), int(lists[lists[at.FIRST_ENTRY] + lists[at.ROWS]])
        slaves, masters, first = (
            lists[lists[section] : lists[section] + count]
            for section, count in ((at.SLAVES, rows), (at.MASTERS, entries), (at.FIRST_ENTRY, rows + 1))
        )
        areas = values[lists[at.NUMBERS] :][: rows * at.ROW_NUMBERS].reshape(-1, at.ROW_NUMBERS)[:, at.AREA]
        shares = values[lists[at.WEIGHTS] :][:entries] * np.repeat(areas, np.diff(first))
        count = len(self._boundary)
        return np.asarray(np.bincount(slaves, areas, count) + np.bincount(masters, shares, count))

    def places_of(self, nodes: np.ndarray) -> np.ndarray:
        """Return the places [k] of nodes [k] of the domain among its boundary nodes."""
        return self._slot[nodes]

    def search(self, positions: np.ndarray) -> None:
        """Find the pairs of faces that may meet at positions [n, 3] [m]."""
        self._candidates = [close_faces(facing, positions) for facing in self.facings]
        self.margin = self._least_margin
        if not self.face_pairs:
            room = min(apart(facing, positions) - facing.reach for facing in self.facings)
            self.margin = max(self.margin, room / SEARCHED)
        self.searches += 1

    @property
    def _least_margin(self) -> float:
        """Way [m] of a node, against the mean one, after which the search is repeated.

        Two faces that are as far apart as the reach may then touch at most when the rows are built anew; it is less
        where a surface waits (`Coupling.waiting`).
        """
        return min(min(facing.margin / SEARCHED, facing.reach / 2.0) for facing in self.facings)

    @property
    def face_pairs(self) -> int:
        """Number of pairs of faces that may meet."""
        return sum(map(len, self._candidates))

    def _movable(self, coupling: Coupling) -> Coupling:
        """Return the rows whose slaves have no mass; the others are held."""
        slot = self._slot[coupling.slaves]
        return coupling.chosen((slot >= 0) & (slot < self._count))

    def _store(self, couplings: list[Coupling], positions: np.ndarray, stale: float) -> None:
        """Write the rows of all slaves, masters of others first, into the arrays of the kernels."""
        centre = self._reference[self._nodes].mean(axis=0)
        slaves = self._slot[np.concatenate([one.slaves for one in couplings])]
        masters = np.concatenate([one.masters for one in couplings])
        rows = len(slaves)
        sides = [self._sides(facing, one.bodies) for facing, one in zip(self.facings, couplings, strict=True)]
        row_of = np.full(self._count, -1)
        row_of[slaves] = np.arange(rows)
        first = starts(np.concatenate([np.diff(one.first) for one in couplings]))
        weights = np.concatenate([one.weights for one in couplings])
        numbers = np.zeros((rows, at.ROW_NUMBERS))
        if rows:
            apart = positions[np.concatenate([one.slaves for one in couplings])] - np.add.reduceat(
                weights[:, None] * positions[masters], first[:-1]
            )
            numbers[:, at.ORIGIN : at.ORIGIN + 3] = apart
            numbers[:, at.CLOSED] = self._closed[slaves]
            numbers[:, at.AREA] = np.concatenate([one.area for one in couplings])
            sizes = np.concatenate([np.full(len(one.slaves), facing.slave.size)
                                    for facing, one in zip(self.facings, couplings, strict=True)])  # fmt: skip
            numbers[:, at.SLIP_LIMIT], numbers[:, at.DEEP] = self._slip * sizes, SLIP * sizes
        faces = [one.faces for one in couplings]
        first_face = starts(np.concatenate([np.diff(one.first_face) for one in couplings]))
        face_weights = np.concatenate([one.face_weights for one in couplings])
        if self._normal is not None:
            into = np.concatenate([one.normals(positions) for one in couplings]) @ self._normal
            numbers[:, at.NORMAL : at.NORMAL + 3] = np.sign(into)[:, None] * self._normal
            faces, first_face, face_weights = [faces[0][:0]], np.zeros(rows + 1, dtype=np.int64), face_weights[:0]
        whole = {
            at.SLAVES: slaves,
            at.FIRST_ENTRY: first,
            at.MASTERS: self._slot[masters],
            at.SIDES: np.concatenate(sides),
            at.FIRST_FACE: first_face,
            at.FACES: np.concatenate(faces).reshape(-1),
            at.NODE_ROW: row_of,
            at.SURFACE: self._slot[self._nodes],
        }
        real = {
            at.WEIGHTS: weights,
            at.FACE_WEIGHTS: face_weights,
            at.NUMBERS: numbers.reshape(-1),
            at.SEARCHED: self._searched.reshape(-1),
        }
        if self._rows is not None:
            real[at.VELOCITIES] = np.zeros(3 * len(self._boundary))
            pairs = np.concatenate(sides) // 2
            of = np.repeat(np.arange(rows), np.diff(first))
            totals = np.bincount(of, weights * self._coefficients[pairs], rows)
            self._rows.set_coefficients(slaves, totals.clip(0.0))
        header = np.zeros(at.LISTS_HEADER, dtype=np.int64)
        header[at.ROWS], header[at.SURFACE_NODES], header[at.PAIRS] = rows, len(self._nodes), len(self._first)
        for sections, start in ((whole, at.LISTS_HEADER), (real, at.VALUES_HEADER)):
            place = start
            for section, content in sections.items():
                header[section] = place
                place += len(content)
        front = np.array([*centre, self.margin, stale, 0.0, arrays.get(self.values)[at.SQUEEZED]])
        self.lists = self._written(self.lists, np.concatenate([header, *whole.values()]))
        self.values = self._written(self.values, np.concatenate([front, *real.values()]))

    def _written(self, array: arrays.Array, content: np.ndarray) -> arrays.Array:
        """Write into an array, or into a larger one that replaces it."""
        if len(content) > int(np.prod(array.shape)):
            with arrays.standing_in(None):
                array = arrays.put(np.zeros(int(SPARE * len(content)), dtype=arrays.get(array).dtype))
        arrays.set_values(array, content)
        return array

    def _sides(self, facing: Facing, bodies: np.ndarray) -> np.ndarray:
        """Return 2 * pair + (0 if the slave is the first body of the pair) of entries with masters in `bodies`."""
        pair = facing.pair[bodies]
        first = np.array(self._first)[pair] == self._numbers[facing.slave.body]
        return np.asarray(2 * pair + np.where(first, 0, 1))

    def check_start(self, domain: Domain, u: np.ndarray) -> None:
        """Refuse bodies of its domain that overlap at the displacement u [n, 3] [m] of the start. Raises `InputError`.

        They do where a row has a negative gap and faces overlap: flat faces on curved surfaces may do one of the two;
        and where they overlap without a row (start_overlap.py). Warns where rows of a coarse slave press though no face
        does, deep or with some energy.
        """
        positions = self._reference + u
        for facing in self.facings:
            pairs = close_faces(facing, positions)
            gap, where = deepest_point(facing, positions, pairs)
            rows = self._movable(self._couple(facing, positions, pairs))
            gaps = rows.gaps(positions)
            smallest = float(gaps.min(initial=np.inf))
            if gap > 0.0 and (
                smallest < -max(COARSE * facing.slave.size, facing.closed)
                or (smallest < -facing.closed and not u.any() and self._outweighs(facing, rows, gaps))
            ):
                masters = " or ".join(sorted({self.labels[body] for body in facing.master_bodies}))
                warnings.warn(
                    f"the faces of the slave {self.labels[facing.slave.body]} are too coarse for the curvature of"
                    f" {masters}: its rows press {-smallest:.3g} m deep where nothing touches yet; make {masters} the"
                    " slave (Pair.slave), or refine these faces",
                    SlaveWarning,
                    stacklevel=4,
                )
            gap = max(gap, smallest)
            allowed = (self._left if u.any() else OVERLAP) * facing.slave.size
            if gap < -max(allowed, facing.closed):
                others = sorted({self.labels[body] for body in facing.master_bodies})
                place = ", ".join(f"{part:.4g}" for part in where)
                remedy = f"it starts {-gap:.3g} m inside {' or '.join(others)} near ({place}); move them apart"
                if -gap <= facing.sagitta:
                    remedy += ", or give the pair initial_gap='closed', the coarser body being the slave"
                raise InputError("Scene.bodies", self.labels[facing.slave.body], remedy)
            least = (LEFT if u.any() else OVERLAP) * facing.slave.size
            refuse_overlaps(domain, facing, rows, positions, least, allowed)

    def _outweighs(self, facing: Facing, rows: Coupling, gaps: np.ndarray) -> bool:
        """Return whether what rows press in at the start is not small against the motion of the bodies.

        gaps [r] [m]: of the rows. A layer as thick as a slave face is pressed in by them, of the softer body: that is
        the elastic energy of the first row of the history within a factor of 2.
        """
        bodies = [self._bodies[body].body for body in sorted({facing.slave.body, *facing.master_bodies})]
        modulus = min(stiffness(body) for body in bodies)
        pressed = 0.5 * modulus / facing.slave.size * float(rows.area @ np.minimum(gaps, 0.0) ** 2)
        speeds = [float((body.initial_velocity**2).sum(axis=1).mean()) for body in bodies]
        moves = 0.5 * sum(body.mass * square for body, square in zip(bodies, speeds, strict=True) if square > 0.0)
        return pressed > PHANTOM * moves > 0.0

    def _close(self, couplings: list[Coupling], positions: np.ndarray) -> None:
        """Let the gaps of the start that come from flat faces count as closed, for pairs that ask for it."""
        for facing, one in zip(self.facings, couplings, strict=True):
            gap = one.gaps(positions)
            slot = self._slot[one.slaves]
            small = (np.abs(gap) <= facing.closed) & ~self._given[slot]
            self._closed[slot[small]] = gap[small]

    def squeezed(self, slots: int, obstacles: Sequence[str]) -> tuple[BodyPlan, str] | None:
        """Return the body of a contact node that is squeezed between partners, and the reason; None without any.

        slots: rows of a node; obstacles [k * slots]: names of the obstacles of all rows.
        """
        noted = int(arrays.get(self.values)[at.SQUEEZED]) - 1
        if noted < 0:
            return None
        row, pressing = divmod(noted, slots)
        k, deep = divmod(row, slots)
        names = [self._masters_of(k) if p == slots - 1 else f"obstacle {obstacles[k * slots + p]}"
                 for p in (pressing, deep)]  # fmt: skip
        node = int(self._boundary[k])
        body = int(np.searchsorted(self._node_start, node, side="right")) - 1
        place = ", ".join(f"{part:.4g}" for part in self._reference[node])
        text = f"the contact node at ({place}) at rest is squeezed between {' and '.join(names)}, whose normals are"
        text += " nearly parallel there, or it has more than three partners, or two of them with friction and"
        text += " removal='full': leave it out of a contact set, or refine the mesh there (the body is one cell thick)"
        return self._bodies[body], text

    def _masters_of(self, k: int) -> str:
        """Return the names of the bodies whose nodes are masters of contact node k."""
        lists = arrays.get(self.lists)
        row = lists[lists[at.NODE_ROW] + k]
        first, end = lists[lists[at.FIRST_ENTRY] + row : lists[at.FIRST_ENTRY] + row + 2] if row >= 0 else (0, 0)
        nodes = self._boundary[lists[lists[at.MASTERS] + first : lists[at.MASTERS] + end]]
        bodies = np.unique(np.searchsorted(self._node_start, nodes, side="right")) - 1
        return " or ".join(f"body {self.labels[body]}" for body in bodies) or "another body"

    def checkpoint(self) -> dict[str, Any]:
        """Return what the next steps need."""
        found = {"lists": np.array(arrays.get(self.lists)), "values": np.array(arrays.get(self.values))}
        found |= {f"candidates{number}": pairs for number, pairs in enumerate(self._candidates)}
        counts = {"rebuilds": self.rebuilds, "searches": self.searches, "fast": self._fast.astype(np.int32)}
        counts |= {"steps": self.steps, "built_at": self._built_at}
        return {**found, "searched": self._searched, "built": self.built, "closed": self._closed, **counts}

    def restore(self, saved: dict[str, Any]) -> None:
        """Take over what `checkpoint` returned."""
        self.rebuilds, self.searches = saved["rebuilds"], saved["searches"]
        self._searched, self._closed = np.array(saved["searched"]), np.array(saved["closed"])
        self.built, self._fast = np.array(saved["built"]), np.array(saved["fast"], dtype=bool)
        self.steps, self._built_at = saved["steps"], saved["built_at"]
        self._candidates = [np.array(saved[f"candidates{number}"]) for number in range(len(self.facings))]
        self.lists = self._written(self.lists, saved["lists"])
        self.values = self._written(self.values, saved["values"])
        self.margin = float(saved["values"][at.MARGIN])

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of the rows."""
        return [self.lists, self.values]


def check_starts(domains: Iterable[Domain], displacement: Sequence[np.ndarray]) -> None:
    """Refuse bodies that overlap at the start; displacement: of every body [n, 3] [m]. Raises `InputError`."""
    for domain in domains:
        if domain.pairs:
            parts = [
                displacement[number][body.node_order]
                for number, body in zip(domain.numbers, domain.bodies, strict=True)
            ]
            PairContact(domain).check_start(domain, np.concatenate(parts))
