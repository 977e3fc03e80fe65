"""Algebra of 3x3 tensors as nested lists of scalars, a[row][column].

Such lists compile several times faster than `ti.Matrix`, and the vectoriser sees straight-line arithmetic only.
"""

from ..engine import ti
from .precision import single


@ti.func
def trace(a):
    """Return tr a."""
    return a[0][0] + a[1][1] + a[2][2]


@ti.func
def dot(a, b):
    """Return a : b, the sum of the products of all components."""
    return (
        (a[0][0] * b[0][0] + a[0][1] * b[0][1] + a[0][2] * b[0][2])
        + (a[1][0] * b[1][0] + a[1][1] * b[1][1] + a[1][2] * b[1][2])
        + (a[2][0] * b[2][0] + a[2][1] * b[2][1] + a[2][2] * b[2][2])
    )


@ti.func
def cofactor(a):
    """Return cof a = det(a) a^-t, finite for singular a."""
    return [
        [
            a[1][1] * a[2][2] - a[1][2] * a[2][1],
            a[1][2] * a[2][0] - a[1][0] * a[2][2],
            a[1][0] * a[2][1] - a[1][1] * a[2][0],
        ],
        [
            a[2][1] * a[0][2] - a[2][2] * a[0][1],
            a[2][2] * a[0][0] - a[2][0] * a[0][2],
            a[2][0] * a[0][1] - a[2][1] * a[0][0],
        ],
        [
            a[0][1] * a[1][2] - a[0][2] * a[1][1],
            a[0][2] * a[1][0] - a[0][0] * a[1][2],
            a[0][0] * a[1][1] - a[0][1] * a[1][0],
        ],
    ]


@ti.func
def determinant(a, cofactor_a):
    """Return det a from a and its cofactor."""
    return a[0][0] * cofactor_a[0][0] + a[0][1] * cofactor_a[0][1] + a[0][2] * cofactor_a[0][2]


@ti.func
def volume_change(h, cofactor_h):
    """Return det(I + h) - 1 = tr h + tr cof h + det h without cancellation."""
    return trace(h) + (trace(cofactor_h) + determinant(h, cofactor_h))


@ti.func
def product(a, b):
    """Return a b."""
    return [[a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] for j in range(3)] for i in range(3)]


@ti.func
def product_transposed(a, b):
    """Return a b^t."""
    return [[a[i][0] * b[j][0] + a[i][1] * b[j][1] + a[i][2] * b[j][2] for j in range(3)] for i in range(3)]


@ti.func
def transposed_product(a, b):
    """Return a^t b."""
    return [[a[0][i] * b[0][j] + a[1][i] * b[1][j] + a[2][i] * b[2][j] for j in range(3)] for i in range(3)]


@ti.func
def scaled(factor, a):
    """Return factor a."""
    return [[factor * a[i][j] for j in range(3)] for i in range(3)]


@ti.func
def plus_identity(a, factor):
    """Return a + factor I."""
    return [[a[i][j] + (factor if ti.static(i == j) else 0.0) for j in range(3)] for i in range(3)]


@ti.func
def to_bits(a):
    """Return the bits of a float, or of each lane of a vector of floats, as u64, in float32 as u32.

    `ti.bit_cast` takes no vectors; the compiler folds the lanes into one register reinterpretation.
    """
    if ti.static(a.is_tensor()):
        return ti.Vector([whole_of(a[i]) for i in range(a.n)])
    else:
        return whole_of(a)


@ti.func
def from_bits(a):
    """Return the float, or the vector of floats, with these bits."""
    if ti.static(a.is_tensor()):
        return ti.Vector([float_of(a[i]) for i in range(a.n)])
    else:
        return float_of(a)


@ti.func
def whole_of(a):
    """Return the bits of one number."""
    if ti.static(single()):
        return ti.bit_cast(a, ti.u32)
    else:
        return ti.bit_cast(a, ti.u64)


@ti.func
def float_of(a):
    """Return the number with these bits."""
    if ti.static(single()):
        return ti.bit_cast(a, ti.f32)
    else:
        return ti.bit_cast(a, ti.f64)
