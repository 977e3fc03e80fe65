"""A block vibrates freely in an isochoric mode; a contact set exists, its wall is never reached.

What redistributed mass does to waves and vibrations alone. The method impulse has ordinary mass: the comparison.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ....results.exact import LameMode
from .. import errors as err
from . import cell_stiffness

unit = cell_stiffness
ERRORS = ("displacement_error", "energy_norm_error")
SIZES = (4, 8, 16, 32)
METHODS = ("massless-normal", "massless-full", "massless-depth-3", "impulse")
REFERENCE = "exact: Lame's mode of a free square block (tcontact.results.exact.LameMode)"
PERIODS = 2.125  # an eighth after a zero: errors of phase and of size both count
AMPLITUDE = 1e-3  # amplitude over the edge


def scene(
    *, cells: int = 16, young: float = 1e7, poisson: float = 0.3, density: float = 1000.0, edge: float = 0.1
) -> Any:
    """A block edge x edge, one cell thick along x, lies over a wall ten edges away; it starts flat and moving."""
    import tcontact as tc

    material = tc.LinearElastic(young=young, poisson=poisson, density=density)
    mesh = tc.box_mesh(size=(edge / cells, edge, edge), cells=(1, cells, cells))
    mode = LameMode(edge, material.lame_mu, density, AMPLITUDE * edge)
    speed = mode.amplitude * mode.frequency
    block = tc.Body(mesh, material, velocity=lambda x: speed * mode.shape(x), contact="zmin", name="block")
    wall = tc.Plane(point=(0.0, 0.0, -10.0 * edge))
    return tc.Scene(bodies=[block], obstacles=[wall], duration=PERIODS * 2.0 * np.pi / mode.frequency)


def errors(result: Any) -> dict[str, float]:
    """Return errors of displacement (L2) and strain (energy norm) at the end, relative to the mode's largest."""
    body = result.scene.bodies[0]
    material, edge = body.material, float(np.ptp(body.mesh.nodes[:, 2]))
    mode = LameMode(edge, material.lame_mu, material.density, AMPLITUDE * edge)
    moved = result.position - body.mesh.nodes
    points, weights, values, gradients = err.hex_quadrature(body.mesh, moved)
    factor = mode.factor(result.time)
    shape, slope = mode.shape(points), mode.gradient(points)
    l2 = np.sqrt(weights @ ((values - factor * shape) ** 2).sum(axis=1))
    energy = err.elastic_norm(gradients - factor * slope, weights, material)
    return {
        "displacement_error": float(l2 / (mode.amplitude * np.sqrt(weights @ (shape**2).sum(axis=1)))),
        "energy_norm_error": energy / (mode.amplitude * err.elastic_norm(slope, weights, material)),
    }
