"""The rows that a step measures: what stands where in them, and how those of several bodies make one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

# what a step measures, in this order; the vectors take three places
MEASURED = {
    "time": 1,
    "kinetic": 1,
    "elastic": 1,
    "contact": 1,
    "load_work": 1,
    "support_power": 1,
    "contact_force": 3,
    "support_force": 3,
    "momentum": 3,
    "angular_momentum": 3,
    "gap_min": 1,
    "contact_nodes": 1,
    "sweeps": 1,
    "static_residual": 1,
    "jacobian_min": 1,
    "hourglass": 1,
    "viscous_power": 1,
    "viscous_rate": 1,
}
_ends = np.cumsum(list(MEASURED.values()))
PLACE = {name: slice(end - size, end) for (name, size), end in zip(MEASURED.items(), _ends, strict=True)}
# measured only where they exist, after the others: with friction its work up to the row and in the half kick after it;
# with several or moving obstacles their power on the bodies and the load of each (force, moment); with friction layers
# their own columns
FRICTION = {"friction_before": 1, "friction_after": 1}
LAYERS = {
    "layer_heat": 1,
    "layer_temperature_max": 1,
    "layer_shear_min": 1,
    "layer_error": 1,
    "layer_substeps": 1,
}


class Layout:
    """Where what is measured stands in a row: `place` by name, `width` in all; obstacles: names of tracked ones."""

    def __init__(self, friction: bool = False, obstacles: tuple[str, ...] = (), layers: bool = False) -> None:
        self.obstacles = obstacles
        sizes = dict(MEASURED) | (FRICTION if friction else {})
        if obstacles:
            sizes["obstacle_power"] = 1
            for name in obstacles:
                sizes |= {f"obstacle_force:{name}": 3, f"obstacle_moment:{name}": 3}
        sizes |= LAYERS if layers else {}
        ends = np.cumsum(list(sizes.values()))
        self.sizes = sizes
        self.place = {name: slice(end - size, end) for (name, size), end in zip(sizes.items(), ends, strict=True)}
        self.width = int(ends[-1])


COMBINED: dict[str, Callable[..., np.ndarray]] = {
    "gap_min": np.min,
    "jacobian_min": np.min,
    "sweeps": np.max,
    "static_residual": np.max,
    "viscous_rate": np.max,
    "layer_temperature_max": np.max,
    "layer_shear_min": np.fmin.reduce,
    "layer_error": np.max,
    "layer_substeps": np.max,
}


def combined(rows: list[np.ndarray], layout: Layout) -> np.ndarray:
    """The rows [m, width] of all bodies together: sums, but for what COMBINED names."""
    if len(rows) == 1:
        return rows[0]
    total = np.sum(rows, axis=0)
    total[:, 0] = rows[0][:, 0]
    for name, pick in COMBINED.items():
        if name in layout.place:
            place = layout.place[name].start
            total[:, place] = pick([row[:, place] for row in rows], axis=0)
    return total
