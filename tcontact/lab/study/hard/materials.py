"""Materials at their limits: near-incompressible bodies, shocks, a law beyond its ellipticity."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from tcontact.cases import bar_impact, cube_impact, wall_shock

from ....results import checks as ck
from ....results.exact import SofteningBar
from ....results.result import Result
from ....scene.dissipation import BulkViscosity
from ....scene.scene import Scene
from ..hard_cases import HardCase, Run, sound
from .references import against


def cases() -> list[HardCase]:
    """Return the cases: Poisson's ratios near 1/2 with both removals; shocks; St Venant-Kirchhoff beyond its limit."""
    return [
        *(_near_incompressible(nu, removal) for nu in (0.49, 0.499, 0.4999) for removal in ("normal", "full")),
        *(_wall_shock(mach) for mach in (0.05, 0.1, 0.2)),
        _viscous_shock(),
        HardCase(
            name="svk-beyond-its-limit",
            hard="St Venant-Kirchhoff bar at 0.35 of its wave speed: the law has no solution beyond 0.266; .2 has one",
            runs=lambda full: [Run(_softening(full, mach)) for mach in (0.2, 0.35)],
            judge=lambda results: [],
            judge_stopped=_beyond,
            expected=("stopped",),
            says="StVenantKirchhoff loses ellipticity",
            remedy="use NeoHookean",
        ),
    ]


SOFTENING = {"young": 1e7, "density": 1000.0, "length": 0.1}  # wave speed 100 m/s


def _softening(full: bool, mach: float) -> Scene:
    """Return a scene: a St Venant-Kirchhoff bar at a share of its wave speed."""
    cells, speed = 160 if full else 20, 100.0 * mach
    return bar_impact.scene(cells=cells, law="st-venant-kirchhoff", speed=speed, gap=1e-4, duration=2e-3, **SOFTENING)


def _beyond(results: list[Result]) -> list[ck.Check]:
    """Check that below the limit the run ends with the plateau of the simple wave and stops beyond it, after touch."""
    slow, fast = results
    wave = SofteningBar(SOFTENING["young"], SOFTENING["density"], 20.0)
    time, force = slow.history["time"], slow.history["contact_force"][:, 2]
    flat = force[(time > 0.4e-3) & (time < 1.6e-3)]  # within 2 L/c = 2 ms
    area = (SOFTENING["length"] / 8.0) ** 2
    return [
        ck.finished(slow),
        ck.no_overlap(slow),
        ck.at_most("plateau against the simple wave, error", abs(flat.mean() / (wave.pressure * area) - 1.0), 0.02),
        ck.equals("stopped beyond the limit", fast.ok, 0),
        ck.at_least("time of the stop / time of touch", fast.time / (1e-4 / 35.0), 1.0),
    ]


def _near_incompressible(poisson: float, removal: Literal["normal", "full"]) -> HardCase:
    def runs(full: bool) -> list[Run]:
        both = (removal, "full" if removal == "normal" else "normal")
        n = 8 if full else 4
        return [
            Run(cube_impact.scene(cells=n, poisson=poisson, removal=kind, duration=1.5e-3)) for kind in both[:count]
        ]

    may_stop = removal == "full"
    count = 2 if may_stop else 1
    return HardCase(
        name=f"nu-{poisson:g}-{removal}",
        hard=f"poisson {poisson:g}: K_KK is ill-conditioned ({removal} removal)",
        runs=runs,
        judge=lambda results: [
            *_alike(results),
            *against(f"nu-{poisson:g}-{removal}", results),
            *sound(results, energy=0.05, momentum=1e-4),
        ],
        expected=("right", "stopped") if may_stop else ("right",),
        says="removal='normal'",
        remedy="removal='normal'" if may_stop else "",
    )


def _alike(results: list[Result]) -> list[ck.Check]:
    """Check the impulses of both removals: on so few cells they differ by a tenth, which refining removes."""
    if len(results) < 2:
        return []
    full, normal = (result.history for result in results)
    other = np.interp(full["time"], normal["time"], normal["impulse"][:, 2])
    difference = np.abs(full["impulse"][:, 2] - other).max() / other[-1]
    return [ck.at_most("difference of the running impulses of both removals", difference, 0.2)]


def _wall_shock(mach: float) -> HardCase:
    return HardCase(
        name=f"shock-{mach:g}",
        hard=f"neo-Hookean block in uniaxial strain at {mach:g} of its wave speed: a shock",
        runs=lambda full: [Run(wall_shock.scene(cells=160 if full else 40, mach=mach))],
        judge=lambda results: _shock_checks(results[0], mach),
    )


def _viscous_shock() -> HardCase:
    def runs(full: bool) -> list[Run]:
        scene = wall_shock.scene(cells=160 if full else 80, mach=0.4)
        return [Run(scene), Run(replace(scene, viscosity=BulkViscosity()))]

    return HardCase(
        name="shock-0.4-viscous",
        hard="neo-Hookean block at 0.4 of its wave speed, too strong a shock without bulk viscosity",
        runs=runs,
        judge=lambda results: [*_shock_checks(results[1], 0.4), _calmer(results)],
    )


def _shock_checks(result: Result, mach: float) -> list[ck.Check]:
    """Return the checks of the case wall-shock against the jump conditions of the scene that was to be run."""
    scene = wall_shock.scene(cells=result.scene.bodies[0].mesh.cell_count, mach=mach)
    return wall_shock.checks(replace(result, scene=scene))


def _calmer(results: list[Result]) -> ck.Check:
    """Check the ringing of the compression behind the front, its standard deviation, over that without viscosity."""
    spread = []
    for result in results:
        levels, stretch = wall_shock.stretches(result)
        behind = (levels > 0.1 * levels[-1]) & (levels < 0.7 * wall_shock.TRAVEL * levels[-1])
        spread.append(float(stretch[behind].std()))
    return ck.at_most("ringing behind the front over that without viscosity", spread[1] / spread[0], 0.1)
