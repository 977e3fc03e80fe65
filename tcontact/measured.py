"""Measured rows: what a step measures, by name, made of raw rows of a body; rows of several bodies make one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from .kernels.columns import COLUMNS, Column, cell_groups, group_columns

if TYPE_CHECKING:
    from .plan import BodyPlan
    from .scene import Scene

COMBINE: dict[str, Callable[..., np.ndarray]] = {
    "sum": np.sum,
    "min": np.min,
    "max": np.max,
    "fmin": np.fmin.reduce,
    "first": lambda values, axis: values[0],
}


class Layout:
    """Where the columns of a scene stand in its rows.

    terms: the parts of a scene that have columns of their own; obstacles: names of those whose loads are measured;
    place: by name, what is measured first, then from `width` on up to `end` the integrals over time; shown: the columns
    of the history in their order.
    """

    def __init__(self, terms: Collection[str] = (), obstacles: tuple[str, ...] = ()) -> None:
        self.terms, self.obstacles = frozenset(terms), obstacles
        mine = [column for column in COLUMNS if not column.term or column.term in self.terms]
        self.shown = [column for column in self._of_obstacles(mine) if column.shown]
        self.measured = list(self._of_obstacles([column for column in mine if column.groups]))
        names = {column.name for column in self.measured}
        self.integrals = [column for column in mine if column.integral_of in names]
        self.place: dict[str, slice] = {}
        self.end = 0
        for column in (*self.measured, *self.integrals):
            self.place[column.name] = slice(self.end, self.end + column.size)
            self.end += column.size
        self.width = sum(column.size for column in self.measured)
        self.summed = [self.place[column.name] for column in self.measured if column.combine in ("sum", "first")]

    def _of_obstacles(self, columns: list[Column]) -> Iterator[Column]:
        """The columns, those of an obstacle once for each of them, after the first of which all others come."""
        each = [column for column in columns if "obstacle" in column.groups]
        for column in columns:
            if column not in each:
                yield column
            elif column is each[0]:
                yield from (part._replace(name=f"{part.name}:{name}") for name in self.obstacles for part in each)

    def stored(self, row: np.ndarray) -> Any:
        """Energy that is stored at a row [end], or at each of several [end, m] [J]."""
        return sum(row[self.place[column.name].start] for column in self.measured if column.energy == "stored")

    def empty(self, count: int) -> np.ndarray:
        """Rows [count, width] of a body that measures nothing."""
        return np.repeat([[column.absent for column in self.measured for _ in range(column.size)]], count, axis=0)


def raw_groups(scene: Scene, body: BodyPlan) -> tuple[str, ...]:
    """The groups of columns in the raw rows of a body, in their order (kernels/raw_rows.py)."""
    groups = ["nodes", *cell_groups(body.dissipates)]
    if body.small or len(body.boundary) or body.contact is not None:
        groups += ["boundary", "support"]
    if body.contact is not None:
        groups += ["contact", "gaps"]
        if len(body.contact.nodes):
            groups += ["friction"] if scene.friction is not None else []
            groups += ["loads", *["obstacle"] * len(scene.obstacles)] if scene.tracked else []
    return tuple(groups)


def measured_rows(
    raw: np.ndarray, groups: tuple[str, ...], layout: Layout, times: np.ndarray, gravity: np.ndarray
) -> np.ndarray:
    """Measured rows [n, width] of raw rows [n, ...] with these groups, at the times [s] and in the gravity [m/s^2]."""
    found: dict[str, np.ndarray] = {"time": times[:, None]}
    names, start = iter(layout.obstacles), 0
    for group in groups:
        obstacle = f":{next(names)}" if group == "obstacle" else ""
        for column in group_columns(group):
            values = raw[:, start : start + column.size]
            name, start = column.name + obstacle, start + column.size
            found[name] = found[name] + values if name in found else values
    moved = found["mass_displacement"]
    weight = sum(moved[:, j] * gravity[j] for j in range(3))  # the same bits for any number of rows
    found["load_work"] = np.asarray(weight)[:, None] + found.get("load_work", 0.0)
    rows = layout.empty(len(times))
    for name in found.keys() & layout.place.keys():
        rows[:, layout.place[name]] = found[name]
    return rows


def combined(rows: list[np.ndarray], layout: Layout) -> np.ndarray:
    """The rows [m, width] of all bodies together, each column as the table says."""
    if len(rows) == 1:
        return rows[0]
    total = np.sum(rows, axis=0)
    for column in layout.measured:
        if column.combine != "sum":
            place = layout.place[column.name]
            total[:, place] = COMBINE[column.combine]([row[:, place] for row in rows], axis=0)
    return total
