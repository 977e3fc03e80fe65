"""One massless contact node in its own coordinates: basis, constraints, balance (METHOD 2, paper eqs 15-17).

    f_K(x_J, x_K) - f_ext,K = lambda nu,   g(x_K) >= 0,  lambda >= 0,  lambda g = 0

in the massless components of a node, x = x_0 + B d with B = basis [3, block]; unused columns of B are zero.
"""

from ..contact.constraint_rows import EPSILON, normal_of, number_of
from ..contact.local_contact import multipliers
from ..engine import ti

SHORT = 1e-6  # a row whose normal is shorter than this in the massless components exerts no force on the node


@ti.func
def basis_of(basis: ti.template(), k, block: ti.template()):
    """Return the basis [3, block] of node k: its massless directions as columns."""
    return ti.Matrix([[basis[(3 * k + i) * block + j] for j in ti.static(range(block))] for i in ti.static(range(3))])


@ti.func
def along(contact: ti.template(), k, vector):
    """Return the massless components B^t v [block] of a vector [3] at node k."""
    if ti.static(contact.options.plain):
        return vector
    else:
        return basis_of(contact.basis, k, ti.static(contact.options.block)).transpose() @ vector


@ti.func
def in_space(contact: ti.template(), k, components):
    """Return the vector B d [3] of massless components d [block] of node k."""
    if ti.static(contact.options.plain):
        return components
    else:
        return basis_of(contact.basis, k, ti.static(contact.options.block)) @ components


@ti.func
def block_of(values: ti.template(), e, block: ti.template()):
    """Return matrix e [block, block] out of values [e, row, column]."""
    return ti.Matrix(
        [[values[(e * block + i) * block + j] for j in ti.static(range(block))] for i in ti.static(range(block))]
    )


@ti.func
def segment(values: ti.template(), k, block: ti.template()):
    """Return numbers [block] of node k out of values [k, block]."""
    return ti.Vector([values[k * block + j] for j in ti.static(range(block))])


@ti.func
def entries(values: ti.template(), k, stride, first: ti.template(), size: ti.template()):
    """Return components first, first + 1, ... [size] of node k out of values [component, node] with `stride` nodes."""
    return ti.Vector([values[(first + j) * stride + k] for j in ti.static(range(size))])


@ti.func
def square(values: ti.template(), k, stride, block: ti.template()):
    """Return the matrix [block, block] of node k out of values [row, column, node]."""
    return ti.Matrix(
        [[values[(i * block + j) * stride + k] for j in ti.static(range(block))] for i in ti.static(range(block))]
    )


@ti.func
def constraints(contact: ti.template(), rows: ti.template(), k, block: ti.template(), slots: ti.template()):
    """Return normals [slots, block] in massless components and gaps [slots]; a row without force there has gap 1."""
    normals = ti.Matrix.zero(ti.f64, slots, block)
    gaps = ti.Vector.one(ti.f64, slots)
    for p in ti.static(range(slots)):
        r = k * slots + p
        reduced = along(contact, k, normal_of(rows, r))
        if reduced.norm() >= SHORT:
            gaps[p] = number_of(rows, r, rows.at.gap)
            for j in ti.static(range(block)):
                normals[p, j] = reduced[j]
    return normals, gaps


@ti.func
def balance(out_of_balance, normals, active, block: ti.template(), slots: ti.template()):
    """Return lambda [slots] >= 0 of the active rows that balances B^t (f - f_ext) best, and the remainder [block].

    With a penalty it equals kappa A max(0, -g) in equilibrium, but does not suffer from the rounding of a stiff gap.
    """
    rows = ti.Matrix.zero(ti.f64, slots, block)
    slack = ti.Vector.one(ti.f64, slots)
    for p in ti.static(range(slots)):
        if (active >> p) & 1 == 1:
            slack[p] = 0.0
            for j in ti.static(range(block)):
                rows[p, j] = normals[p, j]
    pressing = multipliers(0.0 - out_of_balance, rows, slack, ti.Matrix.identity(ti.f64, block), 0.0, slots)
    return pressing, out_of_balance - normals.transpose() @ pressing


@ti.func
def unbalanced(out_of_balance, normals, gaps, active, compliance, block: ti.template(), slots: ti.template()):
    """Return the unbalanced force [block] [N]; with a penalty, the contact force is that of the actual gap."""
    _pressing, rest = balance(out_of_balance, normals, active, block, slots)
    if compliance > 0.0:
        rest = out_of_balance - normals.transpose() @ (ti.max(0.0 - gaps, 0.0) / compliance)
    return rest


@ti.func
def violated(gap, pressing):
    """Return by how much [m] a gap violates  gap >= 0, gap lambda = 0; with a penalty the gap includes e lambda."""
    return ti.select(pressing > 0.0, ti.abs(gap), ti.max(0.0, 0.0 - gap))


@ti.func
def constraint_violation(contact: ti.template(), rows: ti.template(), k, gaps, pressing, slots: ti.template()):
    """Return the largest violation [m] of the exact constraints of a node beyond the rounding of its gaps."""
    result = 0.0
    if contact.compliance[k] == 0.0:
        for p in ti.static(range(slots)):
            missed = violated(gaps[p], pressing[p])
            if missed > 0.0:
                size = ti.sqrt(number_of(rows, k * slots + p, rows.at.size_squared))
                result = ti.max(result, missed - EPSILON * size)
    return result


@ti.func
def largest(vector: ti.template()):
    """Return the largest magnitude among the entries of a vector."""
    result = 0.0
    for j in ti.static(range(vector.n)):
        result = ti.max(result, ti.abs(vector[j]))
    return result


@ti.func
def settle(contact: ti.template(), system: ti.template(), k, d, mask, block: ti.template()):
    """Store increment d and active rows (mask) of node k; return the defect [N]: change of d times stiffness."""
    stride = system.stiffness.shape[0]
    change = d - entries(system.increment, k, stride, 0, block)
    defect = system.stiffness[k] * largest(change)
    if contact.compliance[k] > 0.0 and mask > 0:
        defect += change.norm() / contact.compliance[k]
    contact.active[k] = mask
    for j in ti.static(range(block)):
        system.increment[j * stride + k] = d[j]
    return defect
