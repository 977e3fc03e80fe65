"""Run friction layers over a span of time: `solve`."""

from __future__ import annotations

import math
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base import validate
from ..base.errors import InputError
from ..device import arrays, runtime
from .layer import MAXIMUM_NUMBERS, Layer
from .metals import STAINLESS_304, Metal
from .result import LayerResult, Side

LAUNCH = 200_000_000  # node steps in a launch, a few seconds: Ctrl-C acts between launches
FITS = 1e-9  # part of a step by which a duration may differ from a whole number of steps


def solve(
    material: Metal = STAINLESS_304,
    velocity: ArrayLike = 34.0,
    pressure: ArrayLike = 1.3e9,
    duration: float = 0.6e-6,
    dt: float = 1e-9,
    points: int = 200,
    grading: float = 1.0,
    thickness: float = 10e-6,
    heat_share: float = 0.5,
    plastic_heat: float = 0.0,
    initial_temperature: float = 300.0,
    method: str = "bracketed-newton",
    *,
    other: Metal | None = None,
    conductance: float | None = None,
    reload: bool = False,
    history_every: int = 1,
    threads: int | None = None,
    arch: str = "cpu",
) -> LayerResult:
    """Solve for temperature, plastic strain and shear stress of layers of sliding metal (METHOD 5, paper 2).

    One layer of `thickness` [m] per cell; its far ends do not move relative to each other but for the slip at the
    surface, so its stress can only fall while it is pressed. The defaults are the paper's case.

    material: a `Metal`; velocity: slip speed [m/s], its sign does not matter; pressure [Pa]: where it is not positive
    the contact is open: nothing is transmitted, heat only spreads. Each a number, an array [cells] or a table [steps,
    cells] (row k holds during step k). When a cell is pressed (again), its stress starts from its yield limit.
    duration [s] and dt [s]: dt is shortened a little where duration is not a whole number of steps.
    points, grading: nodes over the depth, last spacing over first; 40 points graded 30 are as good as 200 uniform ones.
    heat_share: part of the slip heat that enters the layer; plastic_heat: part of the plastic work that heats it;
    initial_temperature [K]; at and above melting the layer has no strength.
    method: "bracketed-newton", which always succeeds, or the paper's "stress-secant" and "thermal-softening-secant";
    their failed steps are counted and done by the first.
    other: the metal of the other body: both layers are resolved, and conduction decides the heat share; conductance:
    between the two surfaces [W/(m^2 K)], None = perfect contact. reload: let cooling or rising pressure
    raise the stress, too.
    history_every: keep only every so many steps of the history; threads, arch: as in `simulate`.

    Returns a `LayerResult`. Raises `InputError`.
    """
    duration = validate.number("duration", duration, low=0.0)
    dt = validate.number("dt", dt, low=0.0)
    validate.whole("history_every", history_every, 1)
    validate.step_count("dt", dt, duration)
    steps = max(1, math.ceil(duration / dt - FITS * max(1.0, duration / dt * 1e-3)))
    speeds, pressures = _table("velocity", velocity, steps), _table("pressure", pressure, steps)
    cells = max(speeds.shape[1], pressures.shape[1])
    for name, table in (("velocity", speeds), ("pressure", pressures)):
        if table.shape[1] not in (1, cells):
            raise InputError(name, list(table.shape), f"give one value or {cells} for the {cells} cells")
    step = dt if abs(steps * dt - duration) <= 1e-6 * dt else duration / steps
    metals = (material,) if other is None else (material, other)
    layer = Layer(
        metals,
        cells,
        points=points,
        grading=grading,
        thickness=thickness,
        heat_share=heat_share,
        conductance=conductance,
        plastic_heat=plastic_heat,
        initial_temperature=initial_temperature,
        method=method,
        reload=reload,
        threads=threads,
        arch=arch,
    )
    rows = steps // history_every + 1
    if max(rows, len(speeds), len(pressures)) * layer.padded >= MAXIMUM_NUMBERS:
        raise InputError("history_every", history_every, f"leaves {rows} rows of {cells} cells; take it larger")
    spread, pushed = _on_device(speeds, layer), _on_device(pressures, layer)
    surface, stress = arrays.zeros(rows * layer.padded), arrays.zeros(rows * layer.padded)
    compile_s = _warm_up(metals, layer, threads, arch)
    begin = perf_counter()
    per_launch = max(1, LAUNCH // (layer.padded * points * len(metals)))
    for first in range(0, steps, per_launch):
        layer.advance(
            spread,
            pushed,
            step,
            first=first,
            steps=min(per_launch, steps - first),
            every=history_every,
            surface=surface,
            stress=stress,
        )
    if runtime.arch() == "cuda":
        runtime.load().sync()
    wall_s = perf_counter() - begin
    temperatures = initial_temperature + arrays.get(surface).reshape(rows, layer.padded)[:, :cells]
    shear = arrays.get(stress).reshape(rows, layer.padded)[:, :cells].copy()
    shear[0] = layer.start_stress(np.broadcast_to(pressures[0], cells))
    first_side, *more = _sides(layer, np.broadcast_to(pressures[-1], cells))
    return LayerResult(
        time=step * history_every * np.arange(rows),
        surface_temperature=temperatures,
        shear_stress=shear,
        depth=first_side.depth,
        temperature=first_side.temperature,
        plastic_strain=first_side.plastic_strain,
        yield_stress=first_side.yield_stress,
        heat=first_side.heat,
        carried_heat=first_side.carried_heat,
        slip_work=layer.cell("WORK"),
        plastic_work=layer.cell("PLASTIC_WORK"),
        failures=layer.cell("FAILURES").astype(np.int64),
        evaluations=layer.cell("EVALUATIONS").astype(np.int64),
        dt=step,
        steps=steps,
        wall_s=wall_s,
        compile_s=compile_s,
        memory=layer.memory(),
        other=more[0] if more else None,
    )


def _table(name: str, values: ArrayLike, steps: int) -> np.ndarray:
    """Return the values as [1 or steps, 1 or cells]. Raises `InputError`."""
    try:
        table = np.array(values, dtype=np.float64)
    except Exception as error:  # the object's conversion may raise anything
        raise InputError(name, values, "give numbers: one, [cells], or [steps, cells]") from error
    if table.ndim > 2 or table.size == 0:
        raise InputError(name, list(table.shape), "give one number, an array [cells], or a table [steps, cells]")
    if not np.isfinite(table).all():
        raise InputError(name, values, "give finite numbers")
    table = np.atleast_2d(table)
    if np.ndim(values) == 2 and len(table) != steps:
        raise InputError(name, list(table.shape), f"the table needs a row for each of the {steps} steps")
    return table


def _on_device(table: np.ndarray, layer: Layer) -> Any:
    """Return the table on the device, padded with open cells."""
    wide = np.zeros((len(table), layer.padded))
    wide[:, : layer.cells] = table
    return arrays.put(wide)


def _warm_up(metals: tuple[Metal, ...], layer: Layer, threads: int | None, arch: str) -> float:
    """Compile by a launch of a few idle cells; return the seconds it took."""
    begin = perf_counter()
    idle = Layer(
        metals,
        1,
        points=3,
        plastic_heat=layer.plastic_heat,
        method=layer.method,
        threads=threads,
        arch=arch,
    )
    idle.advance(arrays.zeros(idle.padded), arrays.zeros(idle.padded), 1e-9)
    return perf_counter() - begin


def _sides(layer: Layer, pressure: np.ndarray) -> list[Side]:
    found = []
    for number, metal in enumerate(layer.metals):
        temperature, strain = layer.temperature(number), layer.plastic_strain(number)
        limit = metal.yields_at(temperature, np.maximum(pressure, 0.0)[:, None], strain)
        heat, carried = layer.heat(number), layer.carried(number)
        found.append(Side(layer.depth, temperature, strain, limit, heat, carried))
    return found
