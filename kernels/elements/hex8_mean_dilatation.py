"""Hexahedra with one volume change per cell (Q1-P0), for nearly incompressible bodies, where hexes with 8 points lock.

    W_cell = int of W with parameters[0] = 0 over the Gauss points + V parameters[0]/2 (Theta - 1)^2,   Theta = v/V

with the volume V of the cell and v, that of the deformed cell: the mean of J over V (METHOD 4; Simo, Taylor and Pister,
Comput. Meth. Appl. Mech. Engng 51, 177, 1985). The force is the exact slope of this energy, with one pressure per cell:

    dW/du = int P : grad N + p dv/du,   p = parameters[0] (Theta - 1)

With D = 64 v a cubic of the modes of the deformed corners (`hex8`), s its slopes there and s0 those at rest,

    D(x + u) - D(x) = (s0.u + s.u - D(u))/2

without cancellation. A law with plastic flow has its own pressure and energy of Theta (materials/law.py). The linear
law has the mean of tr H instead, (s0.u)/D(x), and the slopes at rest.
"""

from ..engine import ti
from ..language.point_memory import recall
from .hex8 import hex_centre, hex_mode_forces, hex_point_gradient, hex_slopes, hex_viscosity
from .hex8_modes import hex_corner_forces, hex_modes
from .hex8_points import mode_forces_by_points
from .hex8_reduced import six
from .hex8_shapes import ANY, BOX, PARALLELEPIPED
from .points import of_shape
from .record import CellFunctions

SHARE = 1.0 / 512.0


@ti.func
def along(slopes, modes):
    """Return the sum over the first six modes of slope.mode."""
    sums = [six(modes[c], [slopes[m][c] for m in range(6)]) for c in range(3)]
    return sums[0] + sums[1] + sums[2]


@ti.func
def with_pressure(points, weight, modulus, reference, slopes, change):
    """Return [corner forces, energy, smallest det F - 1] of the points and the pressure by the change of D together."""
    pressure = weight * ((1.0 / 64.0) * modulus) * (change / reference)  # p dv/dD
    mode_f = [[points[0][c][m] + pressure * slopes[m][c] for m in range(6)] + [points[0][c][6]] for c in range(3)]
    energy = points[1] + 0.5 * pressure * change
    return [[hex_corner_forces(mode_f[c]) for c in range(3)], energy, points[2]]


@ti.func
def with_law(points, weight, volume, reference, slopes):
    """Return what `with_pressure` returns, with the pressure and energy of the cell [U', U, U''] from its law."""
    pressure = weight * ((1.0 / 64.0) * volume[0])
    mode_f = [[points[0][c][m] + pressure * slopes[m][c] for m in range(6)] + [points[0][c][6]] for c in range(3)]
    energy = points[1] + weight * ((1.0 / 64.0) * reference) * volume[1]
    return [[hex_corner_forces(mode_f[c]) for c in range(3)], energy, points[2]]


@ti.func
def mean_state(memory: ti.template()):
    """Return the mean of the states of the points."""
    total = recall(memory, 0)
    for point in range(1, 8):
        old = recall(memory, point)
        for i in ti.static(range(memory.size)):
            total[i] += old[i]
    return [0.125 * total[i] for i in range(memory.size)]


@ti.func
def split_force(x, u, weight, parameters, law: ti.template(), memory: ti.template(), shape: ti.template()):
    """Return what `hex8.hex_points` returns."""
    mode_x, mode_u = [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)]
    rest = hex_slopes(mode_x)
    now = hex_slopes([[mode_x[c][m] + mode_u[c][m] for m in range(7)] for c in range(3)])
    change = 0.5 * ((along(rest[1], mode_u) + along(now[1], mode_u)) - hex_slopes(mode_u)[0])
    if ti.static(memory and law.plastic):
        mean = change / rest[0]
        volume = law.plastic.volume(mean, parameters, mean_state(memory))
        within = ti.static(memory._replace(pressure=[volume[0], mean]))
        points = hex_mode_forces(x, mode_u, weight * SHARE, parameters, law, within, shape)
        return with_law(points, weight, volume, rest[0], now[1])
    else:
        without = [0.0] + [parameters[i] for i in range(1, len(parameters))]
        points = hex_mode_forces(x, mode_u, weight * SHARE, without, law, memory, shape)
        return with_pressure(points, weight, parameters[0], rest[0], now[1], change)


@ti.func
def linear_split_force(x, u, weight, parameters, law: ti.template(), memory: ti.template(), shape: ti.template()):
    """Return what `split_force` returns for the linear law."""
    mode_x, mode_u = [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)]
    points = hex_mode_forces(x, mode_u, weight * SHARE, [0.0, parameters[1]], law, memory, shape)
    rest = hex_slopes(mode_x)
    return with_pressure(points, weight, parameters[0], rest[0], rest[1], along(rest[1], mode_u))


@ti.func
def mean_step_force(x, d, weight, parameters, law: ti.template(), memory: ti.template()):
    """Return the forces of a step, with D(x) - D(x - d) accurate to the last digits."""
    mode_x, mode_d = [hex_modes(x[c]) for c in range(3)], [hex_modes(d[c]) for c in range(3)]
    points = hex_mode_forces(x, mode_d, weight * SHARE, [0.0, parameters[1]], law, memory, ANY)
    now = hex_slopes(mode_x)
    before = hex_slopes([[mode_x[c][m] - mode_d[c][m] for m in range(7)] for c in range(3)])
    change = 0.5 * ((along(now[1], mode_d) + along(before[1], mode_d)) - hex_slopes(mode_d)[0])
    return with_pressure(points, weight, parameters[0], now[0], now[1], change)


@ti.func
def mean_step_force_by_points(x, d, weight, parameters, law: ti.template(), memory: ti.template()):
    """Return what `mean_step_force` returns, point by point."""
    mode_x, mode_d = [hex_modes(x[c]) for c in range(3)], [hex_modes(d[c]) for c in range(3)]
    now = hex_slopes(mode_x)
    before = hex_slopes([[mode_x[c][m] - mode_d[c][m] for m in range(7)] for c in range(3)])
    change = 0.5 * ((along(now[1], mode_d) + along(before[1], mode_d)) - hex_slopes(mode_d)[0])
    pressure = weight * ((1.0 / 64.0) * parameters[0]) * (change / now[0])
    start, without = pressed(pressure, now[1]), [0.0, parameters[1]]
    points = mode_forces_by_points(x, mode_d, weight * SHARE, without, law, memory, ANY, start)
    return of_corners(points, 0.5 * pressure * change)


@ti.func
def split_force_by_points(x, u, weight, parameters, law: ti.template(), memory: ti.template(), shape: ti.template()):
    """Return what `split_force` returns, point by point.

    The sums over the points start from the forces of the pressure: a thread keeps no slopes.
    """
    mode_x, mode_u = [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)]
    rest = hex_slopes(mode_x)
    now = hex_slopes([[mode_x[c][m] + mode_u[c][m] for m in range(7)] for c in range(3)])
    change = 0.5 * ((along(rest[1], mode_u) + along(now[1], mode_u)) - hex_slopes(mode_u)[0])
    share = weight * (1.0 / 64.0)
    if ti.static(memory and law.plastic):
        mean = change / rest[0]
        volume = law.plastic.volume(mean, parameters, mean_state(memory))
        within = ti.static(memory._replace(pressure=[volume[0], mean]))
        start = pressed(share * volume[0], now[1])
        points = mode_forces_by_points(x, mode_u, weight * SHARE, parameters, law, within, shape, start)
        return of_corners(points, share * rest[0] * volume[1])
    else:
        without = [0.0] + [parameters[i] for i in range(1, len(parameters))]
        pressure = share * parameters[0] * (change / rest[0])
        start = pressed(pressure, now[1])
        points = mode_forces_by_points(x, mode_u, weight * SHARE, without, law, memory, shape, start)
        return of_corners(points, 0.5 * pressure * change)


@ti.func
def linear_split_force_by_points(
    x, u, weight, parameters, law: ti.template(), memory: ti.template(), shape: ti.template()
):
    """Return what `split_force_by_points` returns for the linear law."""
    mode_x, mode_u = [hex_modes(x[c]) for c in range(3)], [hex_modes(u[c]) for c in range(3)]
    rest = hex_slopes(mode_x)
    change = along(rest[1], mode_u)
    pressure = weight * ((1.0 / 64.0) * parameters[0]) * (change / rest[0])
    start, without = pressed(pressure, rest[1]), [0.0, parameters[1]]
    points = mode_forces_by_points(x, mode_u, weight * SHARE, without, law, memory, shape, start)
    return of_corners(points, 0.5 * pressure * change)


@ti.func
def pressed(pressure, slopes):
    """Return the forces p dv/du on the modes [component][mode]; pressure: 1/64 p."""
    return [[pressure * slopes[m][c] for m in range(6)] + [0.0 * pressure] for c in range(3)]


@ti.func
def of_corners(points, energy):
    """Return [corner forces, energy, smallest det F - 1] of points and the energy of the pressure."""
    return [[hex_corner_forces(points[0][c]) for c in range(3)], points[1] + energy, points[2]]


FUNCTIONS = {
    "hex8-mean-dilatation" + name: CellFunctions(
        8,
        of_shape(split_force, shape),
        mean_step_force,
        hex_viscosity,
        hex_centre,
        of_shape(linear_split_force, shape),
        "mean-dilatation",
        thread_force=of_shape(split_force_by_points, shape),
        linear_thread_force=of_shape(linear_split_force_by_points, shape),
        thread_step_force=mean_step_force_by_points,
        point_gradient=hex_point_gradient,
    )
    for name, shape in (("", ANY), ("-affine", PARALLELEPIPED), ("-box", BOX))
}
