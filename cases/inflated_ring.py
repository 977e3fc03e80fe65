"""A ring of rubber is inflated by a pressure that follows its inside, against the exact solution.

The ring is in plane strain, neo-Hookean. The pressure rises smoothly to what widens the inside by a given stretch, and
stays; mass damping lets the ring come to rest. The exact solution is that of the ring's equilibrium in finite
deformation, an ordinary differential equation for r(R). The work of the pressure is in the ledger, and the forces on
the closed inside balance to rounding at every shape of it.
"""

from __future__ import annotations

import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

import tcontact as tc
from tcontact.cases import _choices as choices
from tcontact.cases._inputs import checked
from tcontact.results import checks as ck
from tcontact.show import plots

INTERVALS = 400  # of the differential equation
RISE = 0.6  # share of the duration in which the pressure rises


@checked
def scene(
    *,
    cells: int = 24,
    stretch: float = 1.5,
    inside: float = 0.1,
    outside: float = 0.15,
    young: float = 1e6,
    poisson: float = 0.45,
    density: float = 1000.0,
    periods: float = 8.0,
) -> tc.Scene:
    """A ring with `cells` hexes around (mean dilatation) is inflated until its inside is `stretch` times as wide.

    SI units. periods: duration in 2 pi outside over the speed of waves in a bar of the material.
    """
    choices.positive(cells=cells, inside=inside, young=young, density=density, periods=periods)
    if not inside < outside:
        raise tc.InputError("outside", outside, "must be greater than inside")
    if not stretch > 1.0:
        raise tc.InputError("stretch", stretch, "must be greater than 1")
    law = tc.NeoHookean(young, poisson, density)
    mesh = tc.ring_mesh(inside, outside, 2.0 * np.pi * inside / cells, cells, layers=1)
    mesh = mesh.with_sets(node_sets={"all": np.arange(mesh.node_count)})
    speed = np.sqrt(young / density)
    duration = periods * 2.0 * np.pi * outside / speed
    top = equilibrium(law, inside, outside, stretch)[0]
    ring = tc.Body(
        mesh,
        law,
        supports=[tc.Support("all", "z")],
        loads=[tc.Load("inner", pressure=lambda t: top * smooth(t / (RISE * duration)))],
        name="ring",
        formulation="mean-dilatation",
    )
    return tc.Scene([ring], duration=duration, damping=tc.MassDamping(speed / outside))


def smooth(share: float) -> float:
    """Return a step from 0 to 1 with two derivatives of 0 at both ends."""
    s = min(max(share, 0.0), 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def equilibrium(law: tc.NeoHookean, inside: float, outside: float, stretch: float) -> tuple[float, float, float]:
    """Return pressure [Pa], outer radius [m] and energy per length [J/m] of a ring with this stretch of its inside.

    In plane strain, with a = dr/dR, b = r/R: d(R Pr)/dR = Pb, Pr = dW/da, Pb = dW/db, and Pr = 0 outside.
    """
    mu, lam = law.lame_mu, law.lame_lambda
    step = (outside - inside) / INTERVALS

    def radial(a, b):
        return mu * (a - 1.0 / a) + lam * (a * b - 1.0) * b

    def slope(at, state):
        a, b = state[1], state[0] / at
        hoop = radial(b, a)
        bent = lam * (2.0 * a * b - 1.0)  # dPr/db
        along = mu * (1.0 + 1.0 / a**2) + lam * b**2  # dPr/da
        energy = mu * (0.5 * (a**2 + b**2 - 2.0) - np.log(a * b)) + 0.5 * lam * (a * b - 1.0) ** 2
        return np.array([a, ((hoop - radial(a, b)) - bent * (a - b)) / at / along, 2.0 * np.pi * at * energy])

    def outer(first):
        state = np.array([stretch * inside, first, 0.0])
        for i in range(INTERVALS):
            at = inside + i * step
            k = [slope(at, state)]
            for share in (0.5, 0.5, 1.0):
                k.append(slope(at + share * step, state + share * step * k[-1]))
            state = state + step / 6.0 * (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3])
        return state, radial(state[1], state[0] / outside)

    low, high = 0.1 / stretch, 1.0  # of dr/dR inside
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if outer(middle)[1] > 0.0 else (middle, high)
    state, _ = outer(low)
    return -radial(low, stretch) / stretch, float(state[0]), float(state[2])


def exact(scene: tc.Scene) -> tuple[float, np.ndarray, np.ndarray, float]:
    """Return pressure [Pa], radii (inner, outer) [m] of the ring at rest and inflated, and its energy [J]."""
    body = scene.bodies[0]
    radius, thickness = np.linalg.norm(body.mesh.nodes[:, :2], axis=1), float(np.ptp(body.mesh.nodes[:, 2]))
    inside, outside = float(radius.min()), float(radius.max())
    top = body.loads[0].value(scene.duration)
    low, high = 1.0, 2.0
    while equilibrium(body.material, inside, outside, high)[0] < top:
        high *= 1.5
    for _ in range(40):  # the stretch at this pressure
        middle = 0.5 * (low + high)
        less = equilibrium(body.material, inside, outside, middle)[0] < top
        low, high = (middle, high) if less else (low, middle)
    _, outer, energy = equilibrium(body.material, inside, outside, low)
    return top, np.array([inside, outside]), np.array([low * inside, outer]), energy * thickness


def draw(result: tc.Result, folder: Path, title: str) -> None:
    """Draw the work of the pressure and where it goes."""
    history = result.history
    names = ("applied_work", "elastic", "damping_work", "kinetic")
    panels = {("energy", "J"): {name.replace("_", " "): (history["time"], history[name]) for name in names}}
    plots.panels(folder / "work.png", panels, title)


def checks(result: tc.Result) -> list[ck.Check]:
    """Check widening and energy against the exact solution, the balance of the forces inside, and the ledger."""
    found = [ck.finished(result), ck.energy(result, 1e-3)]
    if not result.ok:
        return found
    history, mesh = result.history, result.scene.bodies[0].mesh
    top, rest, wanted, energy = exact(result.scene)
    radius = np.linalg.norm(result.position[:, :2], axis=1)
    inner, outer = (radius[mesh.nodes_of(name)].mean() for name in ("inner", "outer"))
    around = len(mesh.face_sets["inner"])
    across = np.ptp(rest) * around / mesh.cell_count
    chord = 0.5 * ((2.0 * np.pi / around) ** 2 + (across / rest[0]) ** 2)  # cells of finite size, second order
    pressing = top * 2.0 * np.pi * wanted[0] * np.ptp(mesh.nodes[:, 2])
    return [
        *found,
        ck.between("widening inside / exact", (inner - rest[0]) / (wanted - rest)[0], 1.0 - chord, 1.0 + chord),
        ck.between("widening outside / exact", (outer - rest[1]) / (wanted - rest)[1], 1.0 - chord, 1.0 + chord),
        ck.between("elastic energy / exact", history["elastic"][-1] / energy, 1.0 - 2.0 * chord, 1.0 + 2.0 * chord),
        ck.at_most("net force inside / its sum", np.abs(history["applied_force"]).max() / pressing, 1e-12),
        ck.at_most("kinetic / elastic energy at the end", history["kinetic"][-1] / history["elastic"][-1], 1e-4),
    ]


if __name__ == "__main__":
    from tcontact.commands.cli import main

    sys.exit(main(["run", "inflated-ring", *sys.argv[1:]]))
