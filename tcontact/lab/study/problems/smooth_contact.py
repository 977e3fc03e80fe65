"""A pressed bar receives a smooth strain wave at its contact end: the force is smooth and exact, contact never opens.

Unit length, speed, young and density. Without jumps, the order in h of the contact force itself can be seen.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ....results.exact import SmoothBump
from .. import errors as err
from . import cell_stiffness, column

unit = cell_stiffness
ERRORS = ("force_error", "largest_force_error", "displacement_error")
SIZES = (20, 40, 80, 160)
METHODS = ("massless-normal", "massless-full", "massless-depth-3", "massless-penalty-10", "massless-penalty-100")
REFERENCE = "exact: E A (p + 2 b(c t)), the wave arrives and doubles (tcontact.results.exact.SmoothBump)"
WAVE = SmoothBump(prestrain=0.2, height=0.2, centre=0.45, half=0.3)
END = 1.05


def scene(*, cells: int = 80, kind: str = "hex8") -> Any:
    """The bar touches the wall and is pressed by its held far end; kind: hex8 or tet4."""
    import tcontact as tc

    mesh, material = column(cells, 1.0, 1.0, 1.0)
    if kind != "hex8":
        low, high = mesh.bounds
        mesh = tc.box_mesh(size=high - low, cells=(1, 1, cells), kind=kind, origin=low)
    bar = tc.Body(
        mesh,
        material,
        velocity=lambda x: np.stack([0 * x[:, 2], 0 * x[:, 2], -WAVE.bump(x[:, 2])], axis=1),
        contact="zmin",
        supports=[tc.Support("zmax", "z")],
        name="bar",
    )
    return tc.Scene(bodies=[bar], obstacles=[tc.Plane()], duration=END)


def displaced(scene: Any) -> Any:
    """Return the scene with the bar pressed, and the wave in it."""
    z = scene.bodies[0].mesh.nodes[:, 2]
    moved = np.zeros((len(z), 3))
    moved[:, 2] = -WAVE.prestrain * z - WAVE.integral(z)
    penalty = getattr(scene.contact, "penalty", None) or getattr(scene.contact, "stiffness", None)
    if penalty is not None:  # the wall gives way under the prestress
        moved[:, 2] -= WAVE.prestrain / penalty
    return replace(scene, bodies=[replace(scene.bodies[0], displacement=moved)])


def errors(result: Any) -> dict[str, float]:
    """Return errors of force (mean, largest) and of the displacement of the end state in units of the wave's."""
    body = result.scene.bodies[0]
    size = np.ptp(body.mesh.nodes, axis=0)
    area = float(size[0] * size[1])
    time, force = result.history["time"], err.normal_force(result)

    def impulse(t: np.ndarray) -> np.ndarray:
        return area * (WAVE.prestrain * t + 2.0 * WAVE.integral(t))

    wanted = err.centred_mean(impulse, time)
    z, t = body.mesh.nodes[:, 2], result.time
    moved = -WAVE.prestrain * z - WAVE.integral(z + t) + WAVE.integral(np.maximum(t - z, 0.0))
    found = result.position[:, 2] - z
    return {
        "force_error": err.relative_l2(force, wanted),
        "largest_force_error": float(np.abs(force - wanted).max() / wanted.max()),
        "displacement_error": float(np.sqrt(np.mean((found - moved) ** 2)) / WAVE.integral(np.array(1.0))),
    }
