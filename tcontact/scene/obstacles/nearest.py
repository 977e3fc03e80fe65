"""Find the nearest points of many triangles, by a tree of cylinders around groups of them.

Triangles in the order of a Morton curve (Morton 1966) make groups of 8, 64, ... Each is bounded by a flat cylinder
along its mean normal, close to a smooth surface: few groups can hold the nearest point, whatever its distance.
They are chosen for many neighbouring positions together first, then for fewer, then for each.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np

GROUP = 8  # members of a group
FEW = 24  # groups at the top of the tree
BLOCKS = (12, 9, 6, 3)  # bits of the key that positions of a block differ in, for which groups are chosen together
AT_ONCE = 1 << 16  # pairs of positions and groups at once: temporaries stay in cache
SLACK = 1e-12  # rounding of a distance, over the size of the surface
CELLS = 2**20  # of the curve along an axis
SPREAD = (  # shifts and masks that put two zeros before every bit
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
ENDS = ((0, 1), (1, 2), (2, 0))


def pieces_of(corners: np.ndarray, longest: float) -> np.ndarray:
    """Halve triangles [m, 3, 3] at their longest edge until none is longer; return pieces [p, 3, 3]."""
    done = []
    while len(corners):
        edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        worst = edges.argmax(axis=1)
        rows = np.arange(len(corners))
        small = edges[rows, worst] <= longest
        done.append(corners[small])
        rows, worst, corners = np.arange((~small).sum()), worst[~small], corners[~small]
        a, b, c = (corners[rows, (worst + i) % 3] for i in range(3))
        middle = 0.5 * (a + b)
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done)


class _Level:
    """Groups of a level of the tree: their cylinders (centre, unit normal, radius, half height) and a point of each."""

    def __init__(self, corners: np.ndarray, count: int) -> None:
        """Bound groups of so many consecutive triangles [m, 3, 3]."""
        points = corners.reshape(-1, 3 * count, 3)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal = normal.reshape(-1, count, 3).sum(axis=1)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        centre = points.mean(axis=1)
        away = points - centre[:, None]
        along = np.einsum("gpi,gi->gp", away, normal)
        square = np.einsum("gpi,gpi->gp", away, away)
        self.half = np.abs(along).max(axis=1)
        self.radius = np.sqrt(np.maximum(square - along**2, 0.0).max(axis=1))
        middles = points.reshape(-1, count, 3, 3).mean(axis=2)
        apart = np.linalg.norm(middles - centre[:, None], axis=2)
        self.normal, self.centre = _columns(normal), _columns(centre)
        self.point = self.centre if count == 1 else _columns(middles[np.arange(len(middles)), apart.argmin(axis=1)])

    def bounds(self, positions: list[np.ndarray], groups: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return lower and upper bounds [p] of the squares of distances, of positions (x, y, z) [p] and groups [p]."""
        away = [x - c.take(groups) for x, c in zip(positions, self.centre, strict=True)]
        along = np.abs(_dot(away, [n.take(groups) for n in self.normal]))
        square = _dot(away, away)
        across = np.sqrt(np.maximum(square - along * along, 0.0))
        along = np.maximum(along - self.half.take(groups), 0.0)
        across = np.maximum(across - self.radius.take(groups), 0.0)
        if self.point is not self.centre:
            away = [x - c.take(groups) for x, c in zip(positions, self.point, strict=True)]
            square = _dot(away, away)
        return along * along + across * across, square

    def around(self, positions: list[np.ndarray], groups: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
        """Return the distance [p] of positions (x, y, z) [p] from the cylinders of groups [p], and its gradient."""
        away = [x - c.take(groups) for x, c in zip(positions, self.centre, strict=True)]
        normal = [n.take(groups) for n in self.normal]
        along = _dot(away, normal)
        radial = np.sqrt(np.maximum(_dot(away, away) - along * along, 0.0))
        beyond = np.maximum(np.abs(along) - self.half.take(groups), 0.0)
        across = np.maximum(radial - self.radius.take(groups), 0.0)
        distance = np.sqrt(beyond * beyond + across * across)
        safe = np.maximum(distance, 1e-300)
        outward = across / np.maximum(radial * safe, 1e-300)
        axial = np.copysign(beyond, along) / safe - outward * along
        return distance, [axial * n + outward * x for n, x in zip(normal, away, strict=True)]


class TriangleTree:
    """Finds the nearest points of triangles [m, 3, 3], exactly."""

    def __init__(self, corners: np.ndarray) -> None:
        self.low = corners.min(axis=(0, 1))
        self.size = float((corners.max(axis=(0, 1)) - self.low).max())
        self.order = np.argsort(
            _curve((corners.mean(axis=1) - self.low) * (CELLS / max(self.size, 1e-300))), kind="stable"
        )
        top, count = 0, len(corners)
        while count > FEW:
            top, count = top + 1, -(-count // GROUP)
        whole = np.concatenate([self.order, np.repeat(self.order[-1:], -len(corners) % GROUP**top)])
        self.order, corners = whole, corners[whole] - self.low
        self.levels = [_Level(corners, GROUP**level) for level in range(top + 1)]
        edges = [corners[:, end] - corners[:, start] for start, end in ENDS]
        normal = np.cross(edges[0], -edges[2])
        square = np.einsum("mi,mi->m", normal, normal)
        normal /= np.where(square > 0.0, square, 1.0)[:, None]
        self.flat = ~(square > 0.0)
        self.corners = [_columns(corners[:, i]) for i in range(3)]
        self.edges = [_columns(edge) for edge in edges]
        lengths = [np.einsum("mi,mi->m", edge, edge) for edge in edges]
        self.inverses = [1.0 / np.where(length > 0.0, length, 1.0) for length in lengths]
        # x - a times these are the barycentric coordinates of b and c
        self.duals = [_columns(np.cross(-edges[2], normal)), _columns(np.cross(normal, edges[0]))]

    def nearest(self, positions: np.ndarray, pitch: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the nearest points [n, 3] of the triangles to positions [n, 3], and their triangles [n].

        pitch [m]: about the distance of neighbouring positions, and exactly that of a grid, for speed alone.
        """
        found, owner = np.empty_like(positions), np.empty(len(positions), dtype=np.int64)
        if not len(positions):
            return found, owner
        low = positions.min(axis=0)
        keys = _curve(np.rint((positions - low) / max(pitch, float(np.ptp(positions, axis=0).max()) / CELLS)))
        order = np.argsort(keys, kind="stable")
        keys = keys[order]

        def search(part: slice) -> None:
            here = positions[order[part]] - self.low
            for rows, point, triangle in self._search(here, keys[part]):
                to = order[part][rows]
                found[to], owner[to] = point + self.low, self.order[triangle]

        ends = np.append(_starts(keys, BLOCKS[0])[::4], len(keys))
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for _ in pool.map(search, map(slice, ends[:-1], ends[1:])):
                pass
        return found, owner

    def _search(
        self,
        positions: np.ndarray,
        keys: np.ndarray,
        before: np.ndarray | None = None,
        candidates: tuple[np.ndarray, np.ndarray] | None = None,
        stage: int = 0,
        level: int = 0,
    ) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
        """Yield rows, nearest points and triangles of positions [n, 3] in the order of the curve.

        before: first position of each block of the stage before; candidates: start of the groups of each, and the
        groups, of the level; None: there is one block, with all at the top.
        """
        last = stage == len(BLOCKS)
        starts = np.arange(len(keys)) if last else _starts(keys, BLOCKS[stage])
        low, high = np.minimum.reduceat(positions, starts), np.maximum.reduceat(positions, starts)
        centre, widths = 0.5 * (low + high), 0.5 * (high - low)
        if before is None or candidates is None:
            level = len(self.levels) - 1
            groups = np.arange(len(self.levels[level].half))
            before, candidates = np.zeros(1, dtype=np.int64), (np.array([0, len(groups)]), groups)
        begin, groups = candidates
        parent = np.searchsorted(before, starts, side="right") - 1
        many = np.diff(begin)[parent]
        ends = np.append(starts, len(keys))
        for one, other in _portions(many):
            part, count = slice(ends[one], ends[other]), many[one:other]
            own = np.repeat(np.arange(other - one), count)
            place = np.arange(len(own)) - np.repeat(np.cumsum(count) - count - begin[parent[one:other]], count)
            here, below = (centre[one:other], None if last else widths[one:other]), level
            pairs = self._kept(level, *here, own, groups[place])
            while below > 0 and (last or self._wide(below, widths[one:other])):
                below -= 1
                pairs = self._kept(below, *here, *_members(*pairs))
            if last:
                yield part, *self._closest(positions[part], *pairs)
                continue
            inner = np.searchsorted(pairs[0], np.arange(other - one + 1)), pairs[1]
            first = starts[one:other] - part.start
            for rows, point, triangle in self._search(positions[part], keys[part], first, inner, stage + 1, below):
                yield slice(part.start + rows.start, part.start + rows.stop), point, triangle

    def _wide(self, level: int, widths: np.ndarray) -> bool:
        """Return whether groups of a level are wider than blocks of half widths [n, 3] [m]."""
        return bool(np.median(self.levels[level].radius) > 0.7 * np.median(np.linalg.norm(widths, axis=1)))

    def _kept(
        self, level: int, positions: np.ndarray, widths: np.ndarray | None, own: np.ndarray, groups: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the pairs whose group may hold the point nearest to the position, or to one of a block around it.

        widths [n, 3] [m]: half widths of the blocks.
        """
        if widths is not None:
            return self._kept_for_blocks(level, positions, widths, own, groups)
        lower, upper = self.levels[level].bounds([x.take(own) for x in _columns(positions)], groups)
        best = np.sqrt(np.minimum.reduceat(upper, np.searchsorted(own, np.arange(len(positions)))))
        best = (best * (1.0 + SLACK) + SLACK * self.size) ** 2
        kept = np.flatnonzero(lower <= best.take(own))
        return own.take(kept), groups.take(kept)

    def _kept_for_blocks(
        self, level: int, centres: np.ndarray, widths: np.ndarray, own: np.ndarray, groups: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the pairs whose group may hold the point nearest to some position c + d of a block, |d_i| <= widths_i.

        With a point p at u = |c - p| and e = (c - p) / u it is at most u + e.d + d.d / 2u away; a cylinder, which is
        convex, is at least as far as its distance l at c and the gradient g there say: l + g.d. A group is out if the
        difference is positive in the whole block.
        """
        at, here, rows = self.levels[level], [x.take(own) for x in _columns(centres)], np.arange(len(centres))
        lower, gradient = at.around(here, groups)
        away = [x - c.take(groups) for x, c in zip(here, at.point, strict=True)]
        square = _dot(away, away)
        best = np.minimum.reduceat(square, np.searchsorted(own, rows))
        hit = np.flatnonzero(square == best.take(own))
        hit = hit[np.searchsorted(own[hit], rows)]
        best = np.sqrt(best)
        reach = np.linalg.norm(widths, axis=1)
        slack = np.zeros(len(own))
        for axis in range(3):
            toward = away[axis][hit] / np.maximum(best, 1e-300)
            slack += np.abs(toward.take(own) - gradient[axis]) * widths[:, axis].take(own)
        slack += (reach * reach / np.maximum(2.0 * best, 1e-300)).take(own)
        limit = np.minimum(slack, 2.0 * reach.take(own)) + best.take(own)
        kept = np.flatnonzero(lower <= limit * (1.0 + SLACK) + SLACK * self.size)
        return own.take(kept), groups.take(kept)

    def _closest(self, positions: np.ndarray, own: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return nearest points and triangles of positions, each with candidates: ascending own [p], triangles [p]."""
        here = [x.take(own) for x in _columns(positions)]
        point = self.closest(here, triangles)
        away = [x - y for x, y in zip(here, point, strict=True)]
        square, rows = _dot(away, away), np.arange(len(positions))
        best = np.minimum.reduceat(square, np.searchsorted(own, rows))
        hit = np.flatnonzero(square == best.take(own))
        hit = hit[np.searchsorted(own[hit], rows)]
        return np.stack([x[hit] for x in point], axis=1), triangles[hit]

    def closest(self, positions: list[np.ndarray], triangles: np.ndarray) -> list[np.ndarray]:
        """Return the nearest points (x, y, z) [p] of triangles [p], in the order of the tree, to positions."""
        corner = [a.take(triangles) for a in self.corners[0]]
        away = [x - a for x, a in zip(positions, corner, strict=True)]
        second, third = (_dot(away, [e.take(triangles) for e in dual]) for dual in self.duals)
        result = [
            a + second * b.take(triangles) - third * c.take(triangles)
            for a, b, c in zip(corner, self.edges[0], self.edges[2], strict=True)
        ]
        inside = (second >= 0.0) & (third >= 0.0) & (second + third <= 1.0) & ~self.flat.take(triangles)
        off = np.flatnonzero(~inside)
        positions, triangles = [x.take(off) for x in positions], triangles.take(off)
        smallest = np.full(len(off), np.inf)
        best = [np.empty(len(off)) for _ in range(3)]
        for start, edge, inverse in zip(self.corners, self.edges, self.inverses, strict=True):
            origin, along = [a.take(triangles) for a in start], [e.take(triangles) for e in edge]
            away = [x - a for x, a in zip(positions, origin, strict=True)]
            part = np.clip(_dot(away, along) * inverse.take(triangles), 0.0, 1.0)
            away = [w - part * e for w, e in zip(away, along, strict=True)]
            square = _dot(away, away)
            nearer = square < smallest
            smallest = np.where(nearer, square, smallest)
            for kept, a, e in zip(best, origin, along, strict=True):
                np.copyto(kept, a + part * e, where=nearer)
        for whole, own in zip(result, best, strict=True):
            whole[off] = own
        return result


def _curve(places: np.ndarray) -> np.ndarray:
    """Return the keys of places [n, 3] from 0 to CELLS along a Morton curve."""
    key = np.zeros(len(places), dtype=np.uint64)
    for axis in range(3):
        bits = places[:, axis].astype(np.uint64)
        for shift, mask in SPREAD:
            bits = (bits | (bits << np.uint64(shift))) & np.uint64(mask)
        key |= bits << np.uint64(axis)
    return key


def _starts(keys: np.ndarray, bits: int) -> np.ndarray:
    """Return the first place of every run of sorted keys that differ in so many low bits alone."""
    blocks = keys >> np.uint64(bits)
    return np.append(0, np.flatnonzero(blocks[1:] != blocks[:-1]) + 1)


def _columns(vectors: np.ndarray) -> list[np.ndarray]:
    """Return the components x, y, z [n] of vectors [n, 3], each contiguous."""
    return [np.ascontiguousarray(vectors[:, axis]) for axis in range(3)]


def _dot(a: list[np.ndarray], b: list[np.ndarray]) -> np.ndarray:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _members(own: np.ndarray, groups: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs with every member of the groups instead."""
    return own.repeat(GROUP), (groups[:, None] * GROUP + np.arange(GROUP)).reshape(-1)


def _portions(counts: np.ndarray) -> Iterator[tuple[int, int]]:
    """Yield first and end of consecutive rows whose counts add up to about `AT_ONCE`, or of one row."""
    number = (np.cumsum(counts) - counts) // AT_ONCE
    ends = np.append(np.flatnonzero(np.diff(number)) + 1, len(counts))
    yield from zip(np.append(0, ends[:-1]).tolist(), ends.tolist(), strict=True)
