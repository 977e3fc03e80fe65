"""Integration points of implicit steps: P with f* = int P : grad U, dP/dF1, energy and det F - 1 at the end (METHOD 4).

    F0 = I + grad u0,   dF = grad d,   u1 = u0 + d;   P = F_m S*  (F1 S with the rule "end"),   dP = dF_m S* + F_m dS*

Strain increments come from d alone, 2 dE = dC = 2 sym(F_m^t dF), so that they stay accurate for small increments.
"""

import functools

from ..engine import ti
from ..language.arguments import ARRAY, INDEX
from ..language.compile_options import LEAVE_TO_LLVM, compiled_with
from ..language.implicit_geometry import cofactor, identity, volume_change
from ..materials import LAWS
from .implicit_rules import mean_stress, mean_stress_change, step_stress, step_stress_change, volume_growth


@ti.func
def symmetric(a):
    """Return the symmetric part of a."""
    return 0.5 * (a + a.transpose())


@ti.func
def gradient(corners, connectivity: ti.template(), gradients: ti.template(), cell, place, values: ti.template()):
    """Return the gradient of nodal values at a point, from differences to the first corner.

    place: start of the shape gradients of the point.
    """
    result = ti.Matrix.zero(ti.f64, 3, 3)
    first = 3 * connectivity[cell * corners]
    for a in range(1, corners):
        node = 3 * connectivity[cell * corners + a]
        for i, j in ti.static(ti.ndrange(3, 3)):
            result[i, j] += (values[node + i] - values[first + i]) * gradients[place + 3 * a + j]
    return result


@ti.func
def unit(k):
    """Return the unit vector along axis k."""
    return ti.Vector([ti.select(k == i, 1.0, 0.0) for i in ti.static(range(3))])


@functools.cache
def make_points(law: str, rule: str, mean: bool):
    """Return the kernel for a law and a rule of `implicit_rules`, memoised.

    mean: with one pressure per cell (mean dilatation) in place of parameters[0].
    """
    known = LAWS[law]
    step_law, linear, count, end = known.step, known.linear, len(known.parameters), rule == "end"

    @ti.func
    def linear_update(h, parameters):
        """Return the stress and the energy of the linear law."""
        answer = known.update([[h[i, j] for j in range(3)] for i in range(3)], parameters)
        return ti.Matrix(answer[0]), answer[1]

    @ti.func
    def linear_stress(h, parameters):
        return linear_update(h, parameters)[0]

    @ti.func
    def linear_rule(h0, dh, constants, chi, p0, p1):
        """Return P of linear elasticity, and its derivative by p1."""
        h = h0 + (1.0 if ti.static(end) else 0.5) * dh
        p = linear_stress(h, constants)
        share = 1.0 if ti.static(end) else 0.5
        pressure = p1 if ti.static(end) else 0.5 * (p0 + p1)
        if ti.static(rule == "dissipative"):
            p += 0.5 * chi * linear_stress(dh, constants)
            share += 0.5 * chi
            pressure += 0.5 * chi * (p1 - p0)
        if ti.static(mean):
            p += pressure * identity()
        return p, share

    @ti.kernel
    def points(
        corners: ti.i32,
        per_cell: ti.i32,
        tangents: ti.i32,
        chi: ti.f64,
        parameters: ARRAY,
        connectivity: INDEX,
        gradients: ARRAY,
        weights: ARRAY,
        u0: ARRAY,
        d: ARRAY,
        pressures: ARRAY,  # p0, p1 of each cell
        stress_out: ARRAY,
        tangent_out: ARRAY,
        measures_out: ARRAY,  # energy and det F1 - 1 of each point
        slopes_out: ARRAY,  # with mean dilatation: dP/dp1 and cof F1, both times the weight
    ):
        for point in range(weights.shape[0]):
            cell, w = point // per_cell, weights[point]
            constants = [parameters[i] for i in range(count)]
            h0 = gradient(corners, connectivity, gradients, cell, 3 * corners * point, u0)
            dh = gradient(corners, connectivity, gradients, cell, 3 * corners * point, d)
            h1 = h0 + dh
            p0, p1 = 0.0, 0.0
            if ti.static(mean):
                p0, p1 = pressures[2 * cell], pressures[2 * cell + 1]
            if ti.static(linear):
                p, share = linear_rule(h0, dh, constants, chi, p0, p1)
                for i, j in ti.static(ti.ndrange(3, 3)):
                    stress_out[9 * point + 3 * i + j] = w * p[i, j]
                    if ti.static(mean):
                        slopes_out[18 * point + 3 * i + j] = ti.select(i == j, w * share, 0.0)
                        slopes_out[18 * point + 9 + 3 * i + j] = ti.select(i == j, w, 0.0)
                measures_out[2 * point] = w * linear_update(h1, constants)[1]
                measures_out[2 * point + 1] = volume_change(h1)
                if tangents != 0:
                    for direction in range(9):
                        change = share * linear_stress(
                            unit(direction // 3).outer_product(unit(direction % 3)), constants
                        )
                        for i, j in ti.static(ti.ndrange(3, 3)):
                            tangent_out[(9 * point + direction) * 9 + 3 * i + j] = w * change[i, j]
            else:
                e0 = symmetric(h0 + 0.5 * (h0.transpose() @ h0))
                f = identity() + h0 + 0.5 * dh
                de = symmetric(f.transpose() @ dh)
                e1 = e0 + de
                j0, j1 = volume_change(h0), volume_change(h1)
                s = step_stress(step_law, rule, e0, e1, de, j0, j1, constants, chi)
                if ti.static(end):
                    f = identity() + h1
                if ti.static(mean):
                    more, slope = mean_stress(rule, e0, e1, de, j0, j1, p0, p1, chi)
                    s += more
                    left, right = f @ slope, cofactor(identity() + h1)
                    for i, j in ti.static(ti.ndrange(3, 3)):
                        slopes_out[18 * point + 3 * i + j] = w * left[i, j]
                        slopes_out[18 * point + 9 + 3 * i + j] = w * right[i, j]
                p = f @ s
                for i, j in ti.static(ti.ndrange(3, 3)):
                    stress_out[9 * point + 3 * i + j] = w * p[i, j]
                measures_out[2 * point] = w * step_law.energy(e1, j1, constants)
                measures_out[2 * point + 1] = j1
                if tangents != 0:
                    for direction in range(9):
                        along_f = unit(direction // 3).outer_product(unit(direction % 3))
                        along = symmetric((identity() + h1).transpose() @ along_f)
                        growth = volume_growth(h1, along_f)
                        ds = step_stress_change(step_law, rule, e0, e1, de, j0, j1, constants, chi, along, growth)
                        if ti.static(mean):
                            ds += mean_stress_change(rule, e0, e1, de, j0, j1, p0, p1, chi, along, growth)
                        change = f @ ds
                        if ti.static(end):
                            change += along_f @ s
                        else:
                            change += 0.5 * (along_f @ s)
                        for i, j in ti.static(ti.ndrange(3, 3)):
                            tangent_out[(9 * point + direction) * 9 + 3 * i + j] = w * change[i, j]

    return compiled_with(points, **LEAVE_TO_LLVM)
