"""Friction layers with their state, a batch of cells advanced together."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import validate
from ..base.errors import InputError
from ..device import arrays, runtime
from ..device.launch import Prepared
from ..kernels.lanes import GRAIN
from .grid import Column, column, depths, half_cells
from .metals import Metal

METHODS = ("bracketed-newton", "thermal-softening-secant", "stress-secant")
MAXIMUM_NUMBERS = 2**30  # in an array: kernels count them in 32 bits
CHUNKS_PER_THREAD = 8
LAYOUTS = {"cpu": (8, 8), "cuda": (1, 32)}  # lanes of a thread, lanes of a pack in memory


class Layer:
    """State of `cells` layers of one metal, or two metals back to back (METHOD 5).

    metals: the metal of the cell, and that of the body it slides on if both layers are resolved; otherwise heat_share
    of the slip heat goes into the one layer. conductance: contact conductance between two sides [W/(m^2 K)], None =
    perfect; plastic_heat: share of the plastic work that heats; reload: whether the yield limit may raise the stress
    again while a cell is pressed, by cooling or pressure (after an open spell it always starts from the yield limit).
    open_ends: whether heat flows through the far end of each side, to what `set_far_temperature` says one spacing
    beyond its last point; None: all are insulated. start_temperatures [K]: of each side, None: initial_temperature.
    Starts Taichi. Raises `InputError`.
    """

    def __init__(
        self,
        metals: tuple[Metal, ...],
        cells: int,
        *,
        points: int = 40,
        grading: float = 30.0,
        thickness: float = 10e-6,
        heat_share: float = 0.5,
        conductance: float | None = None,
        plastic_heat: float = 0.0,
        initial_temperature: float = 300.0,
        method: str = "bracketed-newton",
        reload: bool = False,
        open_ends: tuple[bool, ...] | None = None,
        start_temperatures: tuple[float, ...] | None = None,
        threads: int | None = None,
        arch: str = "cpu",
    ) -> None:
        for metal in metals:
            if not isinstance(metal, Metal):
                raise InputError("material", metal, "give a friction_layer.Metal, such as STAINLESS_304")
        cells, points = validate.whole("cells", cells, 1), validate.whole("points", points, 3)
        validate.choice("method", method, METHODS)
        heat_share = validate.number("heat_share", heat_share, low=0.0, high=1.0, strict=False)
        plastic_heat = validate.number("plastic_heat", plastic_heat, low=0.0, high=1.0, strict=False)
        initial_temperature = validate.number("initial_temperature", initial_temperature, low=0.0, strict=False)
        if not isinstance(reload, bool):
            raise InputError("reload", reload, "give True or False")
        if conductance is not None:
            conductance = validate.number("conductance", conductance, low=0.0, strict=False)
            if len(metals) == 1:
                raise InputError("conductance", conductance, "is between two metals; give other, or leave it at None")
        if len(metals) == 2 and method != METHODS[0]:
            raise InputError("method", method, f"two sides are solved by {METHODS[0]!r} only")
        self.depth = depths(points, grading, thickness)
        self.metals, self.cells, self.points, self.thickness = metals, cells, points, thickness
        self.heat_share, self.conductance, self.plastic_heat = heat_share, conductance, plastic_heat
        self.initial_temperature, self.method, self.reload = initial_temperature, method, reload
        self.columns: list[Column] = []
        self._weight = half_cells(self.depth)
        spacing = float(self.depth[-1] - self.depth[-2])
        opened = open_ends or (False,) * len(metals)
        self.far_ends = [metal.conductivity / spacing * is_open for metal, is_open in zip(metals, opened, strict=True)]
        self._dt = 0.0

        width, self._stride = LAYOUTS["cuda" if arch == "cuda" else "cpu"]
        packs = -(-cells // self._stride)
        self.padded = packs * self._stride
        nodes = len(metals) * points
        if packs * nodes * self._stride >= MAXIMUM_NUMBERS:
            raise InputError("cells", cells, f"times {nodes} points are too many for one batch; split it")
        runtime.start(arch, threads)
        self._units = self.padded // width
        on_gpu = runtime.arch() == "cuda"
        self._chunks = self._units if on_gpu else min(self._units, CHUNKS_PER_THREAD * runtime.threads())

        from ..kernels.layer import layer1d, layer1d_step
        from ..kernels.layer.layer1d_residual import NODE, SCRATCH

        heating = plastic_heat > 0.0
        ends = any(opened)
        # lanes of a pack, sides, whether plastic work heats, method, whether far ends are open
        self.options = self._stride, len(metals), heating, METHODS.index(method), ends
        kernel = layer1d.make_layer(width, *self.options)
        self._cell_numbers = layer1d_step.cell_numbers(len(metals), ends)
        self._grain = 1 if on_gpu else GRAIN
        self._launch = Prepared(kernel)
        self._names = layer1d_step
        count = packs * nodes * self._stride
        self._nodes, self._params = arrays.zeros(nodes * NODE), arrays.zeros(self._setting_count())
        self._rise, self._growth, self._hardening = arrays.zeros(count), arrays.zeros(count), arrays.put(np.ones(count))
        self._carried = arrays.zeros(count if heating else 1)
        self._state = arrays.zeros(packs * self._cell_numbers * self._stride)
        lanes = -(-self._chunks * width // self._stride) * self._stride
        self._scratch = arrays.zeros(lanes * nodes * SCRATCH)
        self._set_cell(layer1d_step.CAP, np.full(self.padded, 1e300))
        self.start_temperatures = start_temperatures or (initial_temperature,) * len(metals)
        self.start_at(np.arange(cells), np.tile(self.start_temperatures, (cells, 1)))

    def limit_traction(self, cap: np.ndarray, drag: np.ndarray) -> None:
        """Limit the traction of a contact that transmits less than the strength of the layer (METHOD 5, coupling).

        The transmitted traction is t = min(sig/sqrt3, cap) [Pa], its heat t (v - drag t), drag = dt/(2 M) [m/(s Pa)]
        for a mass per area M [kg/m^2]; cap must not exceed v/(2 drag), where the contact sticks. Arrays [cells].
        """
        self._set_cell(self._names.CAP, np.minimum(cap, 1e300))
        self._set_cell(self._names.DRAG, drag)

    def advance(
        self,
        velocity: np.ndarray,
        pressure: np.ndarray,
        dt: float,
        *,
        first: int = 0,
        steps: int = 1,
        every: int = 1,
        surface: Any = None,
        stress: Any = None,
    ) -> None:
        """Do steps `first` ... of length dt [s] with tables of velocity [m/s] and pressure [Pa].

        A table is a device array [rows, padded]: one row for all steps, or a row per step. surface and stress: device
        arrays [rows, padded] that take T - initial_temperature [K] of the surface and tau [Pa] after every `every`-th
        step (row 0 is the start), None = not wanted.
        """
        self._prepare(dt)
        if surface is None or stress is None:
            surface, stress, every = self._scratch, self._scratch, 2**30
        self._launch(
            self._units,
            self._chunks,
            self._grain,
            self.points,
            len(self.metals) * self.points,
            first,
            steps,
            every,
            0 if int(np.prod(velocity.shape)) <= self.padded else self.padded,
            0 if int(np.prod(pressure.shape)) <= self.padded else self.padded,
            self._nodes,
            self._params,
            velocity,
            pressure,
            self._rise,
            self._growth,
            self._hardening,
            self._carried,
            self._state,
            self._scratch,
            surface,
            stress,
        )

    def start_stress(self, pressure: np.ndarray) -> np.ndarray:
        """Return tau [Pa] before the first step: the yield limit of the unstrained layer, 0 without pressure."""
        pressed = np.maximum(pressure, 0.0)
        limits = [metal.yields_at(np.array(self.initial_temperature), pressed, np.array(0.0)) for metal in self.metals]
        return np.where(pressure > 0.0, np.min(limits, axis=0), 0.0) / np.sqrt(3.0)

    def limit_stress(self, pressure: np.ndarray) -> np.ndarray:
        """Return tau [Pa] of layers whose contact closes now: their lowest yield limit, 0 without pressure."""
        pressed = np.maximum(pressure, 0.0)[:, None]
        sides = enumerate(self.metals)
        limits = [
            metal.yields_at(self.temperature(n), pressed, self.plastic_strain(n)).min(axis=1) for n, metal in sides
        ]
        return np.where(pressure > 0.0, np.min(limits, axis=0), 0.0) / np.sqrt(3.0)

    def temperature(self, side: int = 0) -> np.ndarray:
        """Return the absolute temperature [K], [cells, points]."""
        return self.initial_temperature + self._profile(self._rise, side)

    def plastic_strain(self, side: int = 0) -> np.ndarray:
        """Return the equivalent plastic strain [cells, points] [-]; at a melted surface it depends on the grid."""
        return self._profile(self._growth, side) / self.metals[side].hardening

    def heat(self, side: int = 0) -> np.ndarray:
        """Return the heat stored since the start [J/m^2], [cells]."""
        capacity = self.metals[side].volumetric_heat * self._weight
        return self._profile(self._rise, side) @ capacity

    def carried(self, side: int = 0) -> np.ndarray:
        """Return the plastic heat that waits for the next step [J/m^2], [cells]."""
        if self.plastic_heat == 0.0:
            return np.zeros(self.cells)
        return self._profile(self._carried, side) @ self._weight

    def cell(self, name: str) -> np.ndarray:
        """Return a number of every cell by its name in kernels/layer/layer1d_step (STRESS, WORK, ...), [cells]."""
        return self._number(getattr(self._names, name))

    def set_far_temperature(self, temperature: np.ndarray, side: int = 0) -> None:
        """Set the absolute temperature [cells] [K] beyond the open far end of a side."""
        first = self._names.far_places(len(self.metals))[0]
        self._set_cell(first + side, temperature - self.initial_temperature)

    def start_at(self, cells: np.ndarray, temperatures: np.ndarray) -> None:
        """Give the sides of cells [m] uniform absolute temperatures [m, sides] [K]."""
        self._set_profiles(self._rise, cells, np.repeat(temperatures - self.initial_temperature, self.points, axis=1))

    def heat_out(self, side: int = 0) -> np.ndarray:
        """Return the heat that left through the open far end of a side so far [J/m^2], [cells]."""
        return self._number(self._names.far_places(len(self.metals))[1] + side)

    def surface_temperature(self, side: int = 0) -> np.ndarray:
        """Return the absolute temperature of the surface [K], [cells]."""
        first = arrays.get(self._rise).reshape(-1, len(self.metals) * self.points, self._stride)[:, side * self.points]
        return self.initial_temperature + first.reshape(-1)[: self.cells]

    def state(self) -> dict[str, np.ndarray]:
        """Return the profiles [cells, points of all sides] and the numbers of the cells [cells, numbers]."""
        known = {name: self._profiles(getattr(self, f"_{name}")) for name in ("rise", "growth", "hardening")}
        if self.plastic_heat > 0.0:
            known["carried"] = self._profiles(self._carried)
        numbers = arrays.get(self._state).reshape(-1, self._cell_numbers, self._stride).transpose(0, 2, 1)
        return known | {"cells": numbers.reshape(-1, self._cell_numbers)[: self.cells].copy(), "base": self._base}

    def start_from(self, cells: np.ndarray, rows: np.ndarray, state: dict[str, np.ndarray]) -> None:
        """Start cells [m] of a new batch from rows [m] of the `state` of another one; their work starts at 0.

        A state with "own" holds the profiles of the first side alone, which met something else: other sides stay new,
        and the stress starts from the yield limit, as where a contact closes.
        """
        rise = state["rise"][rows] + (state["base"] - self._base)
        if "carried" in state and self.plastic_heat == 0.0:
            capacity = np.repeat([m.volumetric_heat for m in self.metals], self.points)
            rise += state["carried"][rows] / capacity[: rise.shape[1]]
        for name, values in state.items():
            if name in ("growth", "hardening") or (name == "carried" and self.plastic_heat > 0.0):
                self._set_profiles(getattr(self, f"_{name}"), cells, values[rows])
        self._set_profiles(self._rise, cells, rise)
        packs = arrays.get(self._state).reshape(-1, self._cell_numbers, self._stride).copy()
        kept = self._names.CELL
        numbers = state["cells"][rows, :kept]
        if "own" in state:
            numbers[:, np.arange(kept) != self._names.WARM] = 0.0
        packs[cells // self._stride, :kept, cells % self._stride] = numbers
        packs[:, kept:, :] = 0.0
        for name in ("WORK", "PLASTIC_WORK", "FAILURES", "EVALUATIONS"):
            packs[:, getattr(self._names, name), :] = 0.0
        arrays.set_values(self._state, packs)

    def arguments(self) -> dict[str, Any]:
        """Return the arrays by the names of kernels/language/bundles.LayerCells."""
        profiles = {name: getattr(self, f"_{name}") for name in ("rise", "growth", "hardening", "carried", "scratch")}
        return profiles | {"cells": self._state}

    def constants(self, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the columns of its nodes [all points * 6] and its parameters for a step dt [s], for the kernels."""
        self._prepare(dt)
        return arrays.get(self._nodes).copy(), arrays.get(self._params).copy()

    def heat_constants(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return conductance [W/(m^2 K)] to the next one and heat capacity [J/(m^2 K)] of the points, for every side.

        Behind the last point is the far end.
        """
        return [
            (np.append(metal.conductivity / np.diff(self.depth), far_end), metal.volumetric_heat * self._weight)
            for metal, far_end in zip(self.metals, self.far_ends, strict=True)
        ]

    @property
    def resistance(self) -> float:
        """The resistance [m^2 K/W] of the contact between two sides."""
        if self.conductance is None:
            return 0.0
        return 1.0 / self.conductance if self.conductance > 0.0 else np.inf

    def owned(self) -> list[Any]:
        """Return the arrays of the state."""
        return [self._rise, self._growth, self._hardening, self._carried, self._state, self._scratch]

    def checkpoint(self) -> dict[str, Any]:
        """Return the profiles, the numbers of the cells and their last step [s]."""
        return {name: arrays.get(array) for name, array in self._kept.items()} | {"dt": self._dt}

    def restore(self, saved: dict[str, Any]) -> None:
        """Set the state that `checkpoint` returned."""
        for name, array in self._kept.items():
            arrays.set_values(array, saved[name])
        if saved["dt"] != 0.0:
            self._prepare(float(saved["dt"]))

    @property
    def _kept(self) -> dict[str, Any]:
        names = ("rise", "growth", "hardening", "carried", "state")
        return {name: getattr(self, f"_{name}") for name in names}

    def memory(self) -> int:
        """Return the bytes of the state."""
        return arrays.size_in_bytes(self.owned())

    def _number(self, number: int) -> np.ndarray:
        values = arrays.get(self._state).reshape(-1, self._cell_numbers, self._stride)
        return values[:, number, :].reshape(-1)[: self.cells].copy()

    def _profile(self, array: Any, side: int) -> np.ndarray:
        packed = arrays.get(array).reshape(-1, len(self.metals) * self.points, self._stride)
        mine = packed[:, side * self.points : (side + 1) * self.points, :]
        return np.ascontiguousarray(mine.transpose(0, 2, 1)).reshape(-1, self.points)[: self.cells]

    def _profiles(self, array: Any) -> np.ndarray:
        """Return the values of all sides, one behind the other, [cells, points of all sides]."""
        return np.concatenate([self._profile(array, side) for side in range(len(self.metals))], axis=1)

    def _set_profiles(self, array: Any, cells: np.ndarray, values: np.ndarray) -> None:
        """Set values [m, points of all sides, or of the first] of cells [m]."""
        packed = arrays.get(array).reshape(-1, len(self.metals) * self.points, self._stride).copy()
        packed[cells // self._stride, : values.shape[1], cells % self._stride] = values
        arrays.set_values(array, packed)

    @property
    def _base(self) -> np.ndarray:
        """Return the temperature [K] relative to which `rise` counts."""
        return np.array(float(self.initial_temperature))

    def _set_cell(self, number: int, values: np.ndarray) -> None:
        state = arrays.get(self._state).reshape(-1, self._cell_numbers, self._stride)
        wide = np.zeros(self.padded)
        wide[: len(values)] = values
        state[:, number, :] = wide.reshape(-1, self._stride)
        arrays.set_values(self._state, state)

    def _setting_count(self) -> int:
        return len(self.metals) * self._names.MATERIAL + self._names.SETTINGS

    def _prepare(self, dt: float) -> None:
        """Compute the constants of a time step."""
        if dt == self._dt:
            return
        self._dt = dt
        sides = zip(self.metals, self.far_ends, strict=True)
        self.columns = [column(metal, self.depth, dt, far_end) for metal, far_end in sides]
        arrays.set_values(self._nodes, np.concatenate([side.table() for side in self.columns]))
        warmth = [side.warmth[0] for side in self.columns]
        compliance = sum(self.thickness / (3.0 * metal.shear_modulus) for metal in self.metals)
        even = 1.0 / (self.resistance + sum(warmth))
        params = np.zeros(self._setting_count())
        for side, metal in enumerate(self.metals):
            at = side * self._names.MATERIAL
            params[at : at + self._names.MATERIAL] = (
                metal.yield_stress,
                metal.hardening_exponent,
                metal.hardening,
                metal.pressure_factor,
                metal.thermal_softening,
                metal.sharpness,
                metal.melting_temperature,
                metal.reference_temperature,
                self.initial_temperature,
                metal.volumetric_heat,
                self.plastic_heat,
                self.far_ends[side],
            )
        params[-self._names.SETTINGS :] = (self.heat_share, even, compliance, dt, float(self.reload))
        arrays.set_values(self._params, params)
