"""Cells in mixed precision: float32 arithmetic on differences that are formed in float64.

With a length unit L of the cells (a power of two near the length of an edge) each cell takes

    x'_k = (X_k - X_0)/L,   u'_k = (u_k - u_0)/L,   v'_k = (v_k - v_0)/L        differences in float64, then rounded

and computes in float32 what it computes in float64 otherwise (elements/, materials/). Gradients do not change, forces,
energies and volumes are multiplied by L^2, L^3 and L^3 in float64, where they are added to rows and sums. So

- a translation of the body, however far, costs no digits, and small strains keep theirs: the error of H = du/dX is 6e-8
  of the size of H, not of 1 or of u;
- a rotation makes H as large as 1, so that its strain has an absolute error of about 1e-7 and the stress one of 1e-7
  of the moduli, whatever the strain: at a strain of 1e-3 in a body that turns the force error is 1e-4. Laws that form
  P = F S with a symmetric S of E (St Venant-Kirchhoff, Ogden, here also neo-Hookean and Mooney-Rivlin) make no torque
  of it;
- areas and volumes of cells of any size fit in the exponents of float32 (1e-38 to 3e38), in one block of cells with
  sizes that differ by up to 1e5.

The first corner takes minus the sum of the other corner forces, in float64, so that momentum is kept to rounding.
Angular momentum is kept to the error of the forces.

Contact cells, whose forces the static solve balances to its tolerance, and products for the stable step, which are
differences of forces, stay in float64 (cell_phase.py), and so do all nodes, sums and state of points.
"""

from ..engine import ti
from ..lanes import FREE
from ..language.point_memory import RELEASED, STRAIN, WARMING, WORK
from ..language.precision import in_single

VOLUME = 9  # place among stored shapes of the volume; the numbers before it are inverse lengths (elements/)


@ti.func
def narrow(a):
    """Return a number or a vector of lanes as float32; lane by lane, as the compiler has no cast of vectors."""
    if ti.static(a.is_tensor()):
        return ti.Vector([ti.cast(a[i], ti.f32) for i in range(a.n)])
    else:
        return ti.cast(a, ti.f32)


@ti.func
def wide(a):
    """Return a number or a vector of lanes as float64."""
    if ti.static(a.is_tensor()):
        return ti.Vector([ti.cast(a[i], ti.f64) for i in range(a.n)])
    else:
        return ti.cast(a, ti.f64)


@ti.func
def differences(a, per_unit):
    """Return the values a[c][k] at the corners less those at the first one, over the unit, as float32."""
    return [[narrow((a[c][k] - a[c][0]) * per_unit) for k in range(len(a[0]))] for c in range(3)]


@ti.func
def stored_shape(shape, unit):
    """Return the stored shape of a cell in the unit, as float32."""
    per_volume = 1.0 / (unit * unit * unit)
    return [narrow(shape[i] * (unit if ti.static(i < VOLUME) else per_volume)) for i in range(len(shape))]


@ti.func
def balanced(force):
    """Return corner forces [corner] of one component whose sum is 0 to rounding in float64: the first takes the rest.

    So the rounding errors of cells do not change the momentum of the body.
    """
    rest = 0.0 - force[1]
    for k in ti.static(range(2, len(force))):
        rest = rest - force[k]
    return [rest] + [force[k] for k in range(1, len(force))]


def single_force(force_of, law, stored: int, averaged: bool):
    """Return force(x or shape, u, weight, parameters, memory, unit[, averages]) in float64 by `force_of` in float32.

    force_of: of an element (elements/record.py). It returns what `force_of` returns.
    """
    inner, flows = in_single(force_of), law.plastic is not None

    @ti.func
    def at_rest(x, unit):
        if ti.static(stored):
            return stored_shape(x, unit)
        else:
            return differences(x, 1.0 / unit)

    @ti.func
    def answer_of(x, u, weight, parameters, memory: ti.template(), unit):
        constants = [narrow(parameters[i]) for i in range(len(parameters))]
        return inner(at_rest(x, unit), differences(u, 1.0 / unit), narrow(weight), constants, law, memory)

    @ti.func
    def averaged_answer_of(x, u, weight, parameters, memory: ti.template(), unit, averages):
        constants = [narrow(parameters[i]) for i in range(len(parameters))]
        means = [narrow(averages[0]), [narrow(averages[1][k]) for k in range(len(averages[1]))]]
        return inner(at_rest(x, unit), differences(u, 1.0 / unit), narrow(weight), constants, law, memory, means)

    @ti.func
    def in_metres(answer, unit):
        area, volume = unit * unit, unit * unit * unit
        forces = [balanced([area * wide(answer[0][c][k]) for k in range(len(answer[0][0]))]) for c in range(3)]
        energies = [volume * wide(answer[i]) for i in range(3, len(answer))]
        return [forces, volume * wide(answer[1]), wide(answer[2])] + energies

    @ti.func
    def add_tally(memory: ti.template(), tally, unit):
        """Add up what the points dissipate and let go, and note the largest plastic strain and temperature rise."""
        for i in ti.static((WORK, RELEASED)):
            memory.tally[i] = memory.tally[i] + (unit * unit * unit) * wide(tally[i])
        for i in ti.static((STRAIN, WARMING)):
            memory.tally[i] = ti.max(memory.tally[i], wide(tally[i]))

    @ti.func
    def force(x, u, weight, parameters, memory: ti.template(), unit):
        if ti.static(flows):
            tally = [narrow(memory.tally[i]) for i in range(4)]
            within = ti.static(memory._replace(tally=tally))
            answer = answer_of(x, u, weight, parameters, within, unit)
            add_tally(memory, tally, unit)
            return in_metres(answer, unit)
        else:
            return in_metres(answer_of(x, u, weight, parameters, memory, unit), unit)

    @ti.func
    def averaged_force(x, u, weight, parameters, memory: ti.template(), unit, averages):
        if ti.static(flows):
            tally = [narrow(memory.tally[i]) for i in range(4)]
            within = ti.static(memory._replace(tally=tally))
            answer = averaged_answer_of(x, u, weight, parameters, within, unit, averages)
            add_tally(memory, tally, unit)
            return in_metres(answer, unit)
        else:
            return in_metres(averaged_answer_of(x, u, weight, parameters, memory, unit, averages), unit)

    return averaged_force if averaged else force


def single_viscosity(viscosity_of):
    """Return viscosity(x, u, v, half, speed, square, unit) in float64 by `viscosity_of` of an element in float32."""
    inner = in_single(viscosity_of)

    @ti.func
    def viscosity(x, u, v, half, speed, square, unit):
        per_unit = 1.0 / unit
        area = unit * unit
        answer = inner(
            differences(x, per_unit),
            differences(u, per_unit),
            differences(v, per_unit),
            narrow(half),
            narrow(speed * per_unit),
            narrow(square),
        )
        force = [balanced([(area * area) * wide(answer[0][c][k]) for k in range(len(answer[0][0]))]) for c in range(3)]
        volume = area * unit
        return [
            force, area * wide(answer[1]), volume * wide(answer[2]), wide(answer[3]), volume * wide(answer[4]),
            wide(answer[5]),
        ]  # fmt: skip

    return viscosity


def by_kind_of_cell(exact, quick, plastic_sums: bool):
    """Return the block phase that takes contact cells and products by `exact`, other cells by `quick`."""

    @ti.func
    def block_phase(body: ti.template(), base, own, first, end, commit):
        answer = quick(body, base, own, first, ti.select(is_exact(body, own), first, end), commit)
        other = exact(body, base, own, ti.select(is_exact(body, own), first, end), end, commit)
        sums = [answer[0] + other[0], ti.min(answer[1], other[1]), answer[2] + other[2], answer[3] + other[3]]
        fastest = ti.max(answer[4], other[4])
        if ti.static(plastic_sums):
            lost = [answer[i] + other[i] for i in range(5, 8)]
            return sums + [fastest] + lost + [ti.max(answer[i], other[i]) for i in range(8, 10)]
        else:
            return sums + [fastest]

    return block_phase


@ti.func
def is_exact(body: ti.template(), own):
    """Return whether a chunk is computed in float64: of contact cells, or in a product for the stable step."""
    return own == 1 or body.params[FREE] != 0.0
