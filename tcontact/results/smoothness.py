"""Measures of how smooth a contact pressure is. Nothing is filtered; every number is 0 or 1 for the ideal one.

With F^n the total contact force of row n, p_k^n the pressure of contact node k (force along the normal over its area
weight A_k), P^n = sum_k A_k p_k^n / sum_k A_k the mean pressure of the face:

    force_variation    sum_n |F^n - F^{n-1}| / (2 max F)                  1: rises once and falls once
    peak_over_plateau  max F / median of F over the rows with F > 0.2 max F
    releases           how often F falls to 1e-6 max F or below
    nodal_variation    mean over k of sum_n |p_k^n - p_k^{n-1}| / (2 max P)
    checkerboard       sum |p_- - 2 p + p_+| / 4 over sum |p|, both over the inner nodes of all grid lines of the face
                       and the rows with F > 0.2 max F: 0 for pressures linear along the lines, 1 for a checkerboard

The first three need the history; the last two need the pressures of every row (`PressureRecord`),
which `simulate(pressures=True)` keeps.
"""

from __future__ import annotations

import numpy as np

LOADED = 0.2  # share of the largest force: rows with less count as arriving or leaving
OPEN = 1e-6


def force_variation(force: np.ndarray) -> float:
    """Return the sum of all changes of a force [rows] over twice its largest value; nan if it never pushes."""
    return _ratio(np.abs(np.diff(force)).sum(), 2.0 * largest(force))


def peak_over_plateau(force: np.ndarray) -> float:
    """Return the largest force over the median of the loaded rows; nan if it never pushes."""
    peak = largest(force)
    return _ratio(peak, float(np.median(force[force > LOADED * peak])) if peak > 0.0 else 0.0)


def releases(force: np.ndarray) -> int:
    """Count how often the force falls to nothing."""
    floor = OPEN * largest(force)
    return int(np.sum((force[:-1] > floor) & (force[1:] <= floor)))


def nodal_variation(pressure: np.ndarray, areas: np.ndarray) -> float:
    """Return the mean over the nodes of their pressure changes over twice the largest face mean.

    pressure: [rows, k] [Pa]; areas: [k] area weights [m^2]. nan if nothing ever pushes.
    """
    face_mean = pressure @ areas / areas.sum()
    return _ratio(float(np.abs(np.diff(pressure, axis=0)).sum(axis=0).mean()), 2.0 * largest(face_mean))


def checkerboard(pressure: np.ndarray, areas: np.ndarray, lines: np.ndarray) -> float:
    """Return the share of the pressures that alternates from node to node along grid lines.

    pressure: [rows, k] [Pa]; areas: [k]; lines: [m, 3] columns of three nodes in a row (`grid_lines`).
    nan if there are no lines or nothing pushes.
    """
    force = pressure @ areas
    loaded = pressure[force > LOADED * largest(force)] if largest(force) > 0.0 else pressure[:0]
    before, middle, after = (loaded[:, lines[:, i]] for i in range(3)) if len(lines) else (loaded[:, :0],) * 3
    return _ratio(float(np.abs(before - 2.0 * middle + after).sum()) / 4.0, float(np.abs(middle).sum()))


def grid_lines(faces: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Return three nodes in a row [m, 3], as places in `nodes`, from quadrilaterals among faces [f, 4|3].

    The middle node has two faces (on an edge of the set) or four; two of its neighbours stand opposite if no face holds
    both.
    """
    if len(faces) == 0 or faces.shape[1] != 4:
        return np.zeros((0, 3), dtype=np.int64)
    faces = faces[faces[:, 3] != faces[:, 2]]
    around: dict[int, list[int]] = {}
    for number, face in enumerate(faces.tolist()):
        for node in face:
            around.setdefault(node, []).append(number)
    corners = faces.tolist()
    place = {int(node): index for index, node in enumerate(nodes)}
    found = []
    for node, mine in around.items():
        if len(mine) not in (2, 4):
            continue
        pairs = set()  # neighbours along an edge, and which of them share a face
        for number in mine:
            at = corners[number].index(node)
            pairs.add(frozenset((corners[number][at - 1], corners[number][(at + 1) % 4])))
        near = sorted({neighbour for pair in pairs for neighbour in pair})
        opposite = [(a, b) for i, a in enumerate(near) for b in near[i + 1 :] if frozenset((a, b)) not in pairs]
        if len(near) == 3 + (len(mine) == 4) and len(opposite) == len(mine) // 2:
            found += [(place[a], place[node], place[b]) for a, b in opposite if {a, b, node} <= place.keys()]
    return np.array(found, dtype=np.int64).reshape(-1, 3)


class PressureRecord:
    """Record of the pressures of the contact nodes of one body, a row per row of the history, in float32.

    nodes: [k] the body's contact nodes; areas: [k] their area weights [m^2]; faces: its contact faces [f, 4|3].
    """

    def __init__(self, nodes: np.ndarray, areas: np.ndarray, faces: np.ndarray) -> None:
        self.nodes = np.asarray(nodes)
        self.areas = np.asarray(areas, dtype=float)
        self.lines = grid_lines(np.asarray(faces), self.nodes)
        self._rows: list[np.ndarray] = []

    def add(self, force: np.ndarray) -> None:
        """Add a row: contact forces [k, 3] [N] on the nodes; their size is taken, normals may differ."""
        with np.errstate(over="ignore", invalid="ignore"):  # a run that blows up
            self._rows.append((np.linalg.norm(force, axis=1) / self.areas).astype(np.float32))

    @property
    def row_size(self) -> int:
        """Bytes of a row."""
        return 4 * len(self.nodes)

    def thin(self) -> None:
        """Drop every second row, as the history does."""
        del self._rows[1::2]

    def checkpoint(self) -> dict[str, np.ndarray]:
        """Return the rows so far."""
        return {"rows": np.array(self._rows, dtype=np.float32).reshape(len(self._rows), len(self.nodes))}

    def restore(self, saved: dict[str, np.ndarray]) -> None:
        """Continue from those rows."""
        self._rows = list(saved["rows"])

    @property
    def pressure(self) -> np.ndarray:
        """Pressures [rows, k] [Pa]."""
        return np.array(self._rows, dtype=float).reshape(len(self._rows), len(self.nodes))

    def numbers(self) -> dict[str, float]:
        """Return nodal_variation and checkerboard."""
        pressure = self.pressure
        return {
            "nodal_variation": nodal_variation(pressure, self.areas),
            "checkerboard": checkerboard(pressure, self.areas, self.lines),
        }


def largest(values: np.ndarray) -> float:
    """Return the largest value, 0 if none is positive."""
    return float(np.max(values, initial=0.0))


def _ratio(value: float, scale: float) -> float:
    return float(value) / scale if scale > 0.0 else float("nan")
