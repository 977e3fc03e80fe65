"""Assembly of implicit schemes: forces of cells and nodes, and tangent blocks in a fixed sparsity, from the points.

    f_a = sum over points of P G_a,   K_ab = sum over points of G_a . dP/dF . G_b,   + an hourglass stiffness h_ab I,
    with mean dilatation  K_ab += lam/V (sum of dP/dp1 G_a) (sum of cof F1 G_b)^t.

Forces are summed node by node, blocks colour by colour (cells of a colour share no node): the same bits with any number
of threads. P and dP/dF include the weights of the points.
"""

from ..engine import ti
from ..lanes import GRAIN
from ..language.arguments import ARRAY, INDEX

PORTIONS = 16


@ti.kernel
def dilatations(
    corners: ti.i32,
    per_cell: ti.i32,
    linear: ti.i32,
    connectivity: INDEX,
    gradients: ARRAY,
    weights: ARRAY,
    u: ARRAY,
    change_out: ARRAY,
):
    """Set the mean of det F - 1 of each cell, or of tr grad u if the law is linear."""
    for cell in range(change_out.shape[0]):
        total, volume = 0.0, 0.0
        for q in range(per_cell):
            point = cell * per_cell + q
            h = ti.Matrix.zero(ti.f64, 3, 3)
            origin = 3 * connectivity[cell * corners]
            for a in range(1, corners):
                node = 3 * connectivity[cell * corners + a]
                for i, j in ti.static(ti.ndrange(3, 3)):
                    h[i, j] += (u[node + i] - u[origin + i]) * gradients[3 * (corners * point + a) + j]
            change = h.trace()
            if linear == 0:
                minors = h[0, 0] * h[1, 1] - h[0, 1] * h[1, 0] + h[1, 1] * h[2, 2] - h[1, 2] * h[2, 1]
                minors += h[0, 0] * h[2, 2] - h[0, 2] * h[2, 0]
                change += minors + h.determinant()
            total += weights[point] * change
            volume += weights[point]
        change_out[cell] = total / volume


@ti.kernel
def cell_forces(
    corners: ti.i32,
    per_cell: ti.i32,
    level: ti.f64,
    hourglass: ti.i32,
    connectivity: INDEX,
    gradients: ARRAY,
    stress: ARRAY,
    stiffness: ARRAY,  # [cells, corners, corners] against hourglassing
    u0: ARRAY,
    d: ARRAY,
    force_out: ARRAY,
):
    """Set the corner forces of each cell; level: place between u0 and u0 + d (0..1) of the hourglass forces."""
    for row in range(force_out.shape[0] // 3):
        cell, a = row // corners, row % corners
        f = ti.Vector.zero(ti.f64, 3)
        for q in range(per_cell):
            point = cell * per_cell + q
            for i, j in ti.static(ti.ndrange(3, 3)):
                f[i] += stress[9 * point + 3 * i + j] * gradients[3 * (corners * point + a) + j]
        if hourglass != 0:
            origin = 3 * connectivity[cell * corners]
            for b in range(1, corners):
                node = 3 * connectivity[cell * corners + b]
                for i in ti.static(range(3)):
                    there = (u0[node + i] - u0[origin + i]) + level * (d[node + i] - d[origin + i])
                    f[i] += stiffness[row * corners + b] * there
        for i in ti.static(range(3)):
            force_out[3 * row + i] = f[i]


@ti.kernel
def node_sums(starts: INDEX, corners_of_node: INDEX, force: ARRAY, total_out: ARRAY):
    """Sum over the cell corners of each node, always in the same order."""
    for node in range(starts.shape[0] - 1):
        total = ti.Vector.zero(ti.f64, 3)
        for place in range(starts[node], starts[node + 1]):
            for i in ti.static(range(3)):
                total[i] += force[3 * corners_of_node[place] + i]
        for i in ti.static(range(3)):
            total_out[3 * node + i] = total[i]


@ti.kernel
def tangent_blocks(
    corners: ti.i32,
    per_cell: ti.i32,
    begin: ti.i32,
    end: ti.i32,
    factor: ti.f64,
    hourglass: ti.f64,
    bulk: ti.f64,
    colour: INDEX,  # cells, colour by colour
    slots: INDEX,  # [cells, corners, corners] place of a block, -1 = not needed
    gradients: ARRAY,
    weights: ARRAY,
    tangent: ARRAY,
    slopes: ARRAY,
    stiffness: ARRAY,
    blocks_out: ARRAY,  # [blocks, 3, 3]
):
    """Add factor times the tangents of the cells begin .. end, all of one colour.

    hourglass: factor of the hourglass stiffness, bulk: lam of mean dilatation; 0 where there is none.
    """
    for portion in range(PORTIONS * GRAIN):
        if portion % GRAIN == 0:
            number = portion // GRAIN
            count = end - begin
            for place in range(begin + count * number // PORTIONS, begin + count * (number + 1) // PORTIONS):
                cell = colour[place]
                volume = 0.0
                for q in range(per_cell):
                    volume += weights[cell * per_cell + q]
                for b in range(corners):
                    block = ti.Vector.zero(ti.f64, 72)
                    right = ti.Vector.zero(ti.f64, 3)
                    for q in range(per_cell):
                        point = cell * per_cell + q
                        at = 3 * (corners * point + b)
                        g = ti.Vector([gradients[at + j] for j in ti.static(range(3))])
                        t = ti.Matrix.zero(ti.f64, 9, 3)
                        for k, j in ti.static(ti.ndrange(3, 9)):
                            at = (9 * point + 3 * k) * 9 + j
                            t[j, k] = tangent[at] * g[0] + tangent[at + 9] * g[1] + tangent[at + 18] * g[2]
                        for a in range(corners):
                            at = 3 * (corners * point + a)
                            h = ti.Vector([gradients[at + j] for j in ti.static(range(3))])
                            for i, k in ti.static(ti.ndrange(3, 3)):
                                block[9 * a + 3 * i + k] += (
                                    t[3 * i, k] * h[0] + t[3 * i + 1, k] * h[1] + t[3 * i + 2, k] * h[2]
                                )
                        if bulk != 0.0:
                            for i, j in ti.static(ti.ndrange(3, 3)):
                                right[i] += slopes[18 * point + 9 + 3 * i + j] * g[j]
                    for a in range(corners):
                        if bulk != 0.0:
                            left = ti.Vector.zero(ti.f64, 3)
                            for q in range(per_cell):
                                point = cell * per_cell + q
                                at = 3 * (corners * point + a)
                                for i, j in ti.static(ti.ndrange(3, 3)):
                                    left[i] += slopes[18 * point + 3 * i + j] * gradients[at + j]
                            for i, k in ti.static(ti.ndrange(3, 3)):
                                block[9 * a + 3 * i + k] += bulk / volume * left[i] * right[k]
                        if hourglass != 0.0:
                            stiff = hourglass * stiffness[(cell * corners + a) * corners + b]
                            for i in ti.static(range(3)):
                                block[9 * a + 4 * i] += stiff
                        slot = slots[(cell * corners + a) * corners + b]
                        if slot >= 0:
                            for i in ti.static(range(9)):
                                blocks_out[9 * slot + i] = blocks_out[9 * slot + i] + factor * block[9 * a + i]


@ti.kernel
def block_product(starts: INDEX, columns: INDEX, blocks: ARRAY, x: ARRAY, y_out: ARRAY):
    """Set y = K x, with K in blocks [.., 3, 3] of rows of nodes."""
    for row in range(starts.shape[0] - 1):
        total = ti.Vector.zero(ti.f64, 3)
        for place in range(starts[row], starts[row + 1]):
            at = 3 * columns[place]
            for i, j in ti.static(ti.ndrange(3, 3)):
                total[i] += blocks[9 * place + 3 * i + j] * x[at + j]
        for i in ti.static(range(3)):
            y_out[3 * row + i] = total[i]
