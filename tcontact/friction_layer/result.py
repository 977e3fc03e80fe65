"""The result of a run of friction layers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Side:
    """Final state on one side of the interface.

    depth [m] [points]; temperature [K], plastic_strain [-], yield_stress [Pa] at the last pressure, each [cells,
    points]; heat: stored since the start, carried_heat: plastic heat not yet released (both [J/m^2], [cells]).
    """

    depth: np.ndarray
    temperature: np.ndarray
    plastic_strain: np.ndarray
    yield_stress: np.ndarray
    heat: np.ndarray
    carried_heat: np.ndarray


@dataclass(frozen=True)
class LayerResult:
    """History and final state of friction layers; the final state of `other` in its own `Side`.

    time [s] [rows], row 0 the start; surface_temperature [K] and shear_stress tau [Pa] [rows, cells], tau = 0 where the
    contact is open; depth, temperature, plastic_strain, yield_stress, heat, carried_heat: as in `Side`. At a surface
    that has melted the plastic strain depends on the grid.
    slip_work: integral of tau |v|, plastic_work: integral of sig dep over the depth (both [J/m^2], [cells]);
    heat = heat_share * slip_work + plastic_heat * plastic_work - carried_heat to rounding (both sides together: 1 *
    slip_work). failures: steps the method could not solve; evaluations: of the scalar equation; both [cells].
    dt [s], steps, wall_s [s] of the steps, compile_s [s], memory [bytes].
    """

    time: np.ndarray
    surface_temperature: np.ndarray
    shear_stress: np.ndarray
    depth: np.ndarray
    temperature: np.ndarray
    plastic_strain: np.ndarray
    yield_stress: np.ndarray
    heat: np.ndarray
    carried_heat: np.ndarray
    slip_work: np.ndarray
    plastic_work: np.ndarray
    failures: np.ndarray
    evaluations: np.ndarray
    dt: float
    steps: int
    wall_s: float
    compile_s: float
    memory: int
    other: Side | None = None

    @property
    def cells(self) -> int:
        """Number of cells."""
        return len(self.slip_work)

    @property
    def cell_steps_per_s(self) -> float:
        """Cells times steps per second, without compiling."""
        return self.cells * self.steps / self.wall_s if self.wall_s > 0 else float("nan")
