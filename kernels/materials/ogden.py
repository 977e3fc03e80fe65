"""Ogden: W = sum over p, i of mu_p/alpha_p (l_i^alpha_p - 1) - sum of mu_p ln J + lam/2 (J - 1)^2, stretches l_i.

With the eigenvalues d_i and eigenvectors N_i of C - I, logarithmic strains e_i = ln(1 + d_i)/2 and
g_i = sum over p of mu_p (l_i^alpha_p - 1), all without cancellation:

    W = sum over p, i of mu_p/alpha_p (exp(alpha_p e_i) - 1 - alpha_p e_i) + lam/2 (J - 1)^2
    S = sum over i of s_i N_i x N_i,  s_i = (g_i + q)/l_i^2,  q = J p,  p = lam (J - 1) + the pressure of the cell

S does not depend on the choice of N_i where stretches coincide. The second derivative contains divided differences
Q_ik = (g_i - g_k)/(l_i^2 - l_k^2), computed from e_i - e_k without cancellation. In the frames n_i = F N_i / l_i, N_i
(Ogden, Non-Linear Elastic Deformations, 1984, ch. 6.1), with v = lam J^2 and K_ik = l_k^2 Q_ik - g_k - q:

    A_iiii = (g_i' - g_i - q + q + v)/l_i^2,  A_iikk = (q + v)/(l_i l_k),  A_ikik = Q_ik,  A_ikki = K_ik/(l_i l_k)

parameters: lam, the shear modulus sum(mu_p alpha_p)/2, then mu_p/alpha_p and alpha_p of three pairs.
(Ogden, Proc. R. Soc. Lond. A 328, 567, 1972. Eigenvalues: cyclic Jacobi, Golub and Van Loan, ch. 8.5.)
"""

from ..engine import ti
from ..language import tensor3
from ..language.precision import by_precision
from ..language.transcendental import exponential_less_one, exponential_split, log_split
from .law import Law, StepLaw, Tangent

PAIRS = 3
SWEEPS = 5  # sweeps of Jacobi rotations; four make the off-diagonal entries smaller than rounding
TINY, TINY_SINGLE = 1e-300, 1e-37


@ti.func
def magnitude(a):
    """Return |a|; `ti.abs` does not compile for vectors of lanes."""
    return ti.max(a, 0.0 - a)


@ti.func
def rotation(first, second, shared):
    """Return [t, cos, sin] of the Jacobi rotation that zeroes the entry `shared` of two diagonal entries, |t| <= 1."""
    x, y = second - first, 2.0 * shared
    length = ti.max(magnitude(x) + ti.sqrt(x * x + y * y), magnitude(y) + ti.static(by_precision(TINY, TINY_SINGLE)))
    t = ti.select(x < 0.0, 0.0 - y, y) / length
    c = 1.0 / ti.sqrt(1.0 + t * t)
    return [t, c, t * c]


@ti.func
def eigen(a):
    """Return [eigenvalues, eigenvectors [component][number]] of a symmetric a[i][j], without branches."""
    xx, yy, zz = a[0][0], a[1][1], a[2][2]
    xy, xz, yz = a[0][1], a[0][2], a[1][2]
    zero = 0.0 * xx
    one = zero + 1.0
    v00, v01, v02 = one, zero, zero
    v10, v11, v12 = zero, one, zero
    v20, v21, v22 = zero, zero, one
    for _ in range(SWEEPS):
        r = rotation(xx, yy, xy)
        xx, yy, xy = xx - r[0] * xy, yy + r[0] * xy, zero
        xz, yz = r[1] * xz - r[2] * yz, r[2] * xz + r[1] * yz
        v00, v01 = r[1] * v00 - r[2] * v01, r[2] * v00 + r[1] * v01
        v10, v11 = r[1] * v10 - r[2] * v11, r[2] * v10 + r[1] * v11
        v20, v21 = r[1] * v20 - r[2] * v21, r[2] * v20 + r[1] * v21
        q = rotation(xx, zz, xz)
        xx, zz, xz = xx - q[0] * xz, zz + q[0] * xz, zero
        xy, yz = q[1] * xy - q[2] * yz, q[2] * xy + q[1] * yz
        v00, v02 = q[1] * v00 - q[2] * v02, q[2] * v00 + q[1] * v02
        v10, v12 = q[1] * v10 - q[2] * v12, q[2] * v10 + q[1] * v12
        v20, v22 = q[1] * v20 - q[2] * v22, q[2] * v20 + q[1] * v22
        w = rotation(yy, zz, yz)
        yy, zz, yz = yy - w[0] * yz, zz + w[0] * yz, zero
        xy, xz = w[1] * xy - w[2] * xz, w[2] * xy + w[1] * xz
        v01, v02 = w[1] * v01 - w[2] * v02, w[2] * v01 + w[1] * v02
        v11, v12 = w[1] * v11 - w[2] * v12, w[2] * v11 + w[1] * v12
        v21, v22 = w[1] * v21 - w[2] * v22, w[2] * v21 + w[1] * v22
    return [[xx, yy, zz], [[v00, v01, v02], [v10, v11, v12], [v20, v21, v22]]]


@ti.func
def stretched(d, parameters):
    """Return [e, g, sum over p of mu_p/alpha_p (exp(alpha_p e) - 1 - alpha_p e), 1/l^2] of d = l^2 - 1."""
    split = log_split(d)
    strain = 0.5 * (d - split[0])
    pull, energy = 0.0 * d, 0.0 * d
    for p in ti.static(range(PAIRS)):
        ratio, alpha = parameters[2 + 2 * p], parameters[3 + 2 * p]
        power = exponential_split(alpha * strain)
        pull += ratio * alpha * power[0]
        energy += ratio * power[1]
    return [strain, pull, energy, split[1]]


@ti.func
def second_piola(difference, j, parameters):
    """Return [S, W] from C - I [i][j] and J - 1."""
    lam = parameters[0]
    found = eigen(difference)
    n = found[1]
    at = [stretched(found[0][i], parameters) for i in range(3)]
    s = [(at[i][1] + lam * j * (1.0 + j)) * at[i][3] for i in range(3)]
    scaled = [[n[i][k] * s[k] for k in range(3)] for i in range(3)]
    energy = (at[0][2] + at[1][2]) + at[2][2] + 0.5 * lam * j * j
    return [tensor3.product_transposed(scaled, n), energy]


@ti.func
def update(h, parameters):
    square = tensor3.transposed_product(h, h)
    difference = [[h[i][j] + h[j][i] + square[i][j] for j in range(3)] for i in range(3)]
    change = tensor3.volume_change(h, tensor3.cofactor(h))
    answer = second_piola(difference, change, parameters)
    moved = tensor3.product(h, answer[0])
    return [[[answer[0][i][j] + moved[i][j] for j in range(3)] for i in range(3)], answer[1], change]


@ti.func
def divided(e1, e2, parameters):
    """Return Q = (g_1 - g_2)/(l_1^2 - l_2^2) of two logarithmic strains, or its limit where they are equal."""
    apart = e1 - e2
    spread = exponential_less_one(2.0 * apart)
    result = 0.0
    for p in ti.static(range(PAIRS)):
        ratio, alpha = parameters[2 + 2 * p], parameters[3 + 2 * p]
        share = 0.5 * alpha
        if spread != 0.0:
            share = exponential_less_one(alpha * apart) / spread
        result += ratio * alpha * share * (1.0 + exponential_less_one((alpha - 2.0) * e2))
    return result


@ti.func
def slopes(difference, j, parameters, pressure):
    """Return [N, l^2, s l^2 = g + q, g', Q, K, q + v] from C - I [3, 3] and J - 1; Q and K without diagonals."""
    found = eigen([[difference[i, k] for k in range(3)] for i in range(3)])
    at = [stretched(found[0][i], parameters) for i in range(3)]
    jacobian = 1.0 + j
    spherical = (parameters[0] * j + pressure) * jacobian
    squares = ti.Vector([1.0 / at[i][3] for i in range(3)])
    pulls = ti.Vector([at[i][1] for i in range(3)])
    steep = ti.Vector.zero(ti.f64, 3)
    for i, p in ti.static(ti.ndrange(3, PAIRS)):
        ratio, alpha = parameters[2 + 2 * p], parameters[3 + 2 * p]
        steep[i] += ratio * alpha * alpha * (1.0 + exponential_less_one(alpha * at[i][0]))
    ratios, crosses = ti.Matrix.zero(ti.f64, 3, 3), ti.Matrix.zero(ti.f64, 3, 3)
    for i, k in ti.static(((0, 1), (0, 2), (1, 2))):
        ratios[i, k] = divided(at[i][0], at[k][0], parameters)
        crosses[i, k] = squares[k] * ratios[i, k] - pulls[k] - spherical
        ratios[k, i], crosses[k, i] = ratios[i, k], crosses[i, k]
    return [
        ti.Matrix(found[1]),
        squares,
        pulls + spherical,
        steep,
        ratios,
        crosses,
        spherical + parameters[0] * jacobian**2,
    ]


@ti.func
def point(f, parameters, pressure):
    identity = ti.Matrix.identity(ti.f64, 3)
    frame, squares, pulls, steep, ratios, crosses, volume = slopes(
        f.transpose() @ f - identity, f.determinant() - 1.0, parameters, pressure
    )
    turned = f @ frame
    direct = ti.Matrix.zero(ti.f64, 3, 3)
    stretch = ti.sqrt(squares)
    for i, k in ti.static(ti.ndrange(3, 3)):
        turned[i, k] /= stretch[k]
        direct[i, k] = volume / (stretch[i] * stretch[k])
        crosses[i, k] /= stretch[i] * stretch[k]
        if ti.static(i == k):
            direct[i, i] += (steep[i] - pulls[i]) / squares[i]
    return [frame, turned, direct, ratios, crosses]


@ti.func
def corner(data, g):
    """Return the gradient in the frame N."""
    return data[0].transpose() @ g


@ti.func
def pair(data, ga, gb, a, b):
    same = data[3] @ (a * b)
    value = data[2] * a.outer_product(b) + data[4] * b.outer_product(a)
    for i in ti.static(range(3)):
        value[i, i] += same[i]
    return data[1] @ value @ data[1].transpose()


@ti.func
def of_strain(e, j, parameters):
    return second_piola([[2.0 * e[i, k] for k in range(3)] for i in range(3)], j, parameters)


@ti.func
def energy(e, j, parameters):
    return of_strain(e, j, parameters)[1]


@ti.func
def stress(e, j, parameters):
    return ti.Matrix(of_strain(e, j, parameters)[0])


@ti.func
def stress_change(e, j, parameters, along):
    """Return the change of S along a change of E.

    In the frame N: dS_ii = (g_i' de_i + (q + v) sum of de)/l_i^2 - 2 s_i de_i,  dS_ik = 2 K_ik/(l_i l_k)^2 dE_ik.
    """
    frame, squares, pulls, steep, _ratios, crosses, volume = slopes(2.0 * e, j, parameters, 0.0)
    change = frame.transpose() @ along @ frame
    growth = change[0, 0] / squares[0] + change[1, 1] / squares[1] + change[2, 2] / squares[2]
    result = ti.Matrix.zero(ti.f64, 3, 3)
    for i, k in ti.static(ti.ndrange(3, 3)):
        result[i, k] = 2.0 * crosses[i, k] / (squares[i] * squares[k]) * change[i, k]
        if ti.static(i == k):
            result[i, i] = ((steep[i] - 2.0 * pulls[i]) * (change[i, i] / squares[i]) + volume * growth) / squares[i]
    return frame @ result @ frame.transpose()


LAW = Law(
    ("lam", "mu", "mu_1/alpha_1", "alpha_1", "mu_2/alpha_2", "alpha_2", "mu_3/alpha_3", "alpha_3"),
    update,
    (Tangent(point, corner, pair),),
    StepLaw(energy, stress, stress_change),
    refusal="an Ogden law with exponents below 1 may lose ellipticity at such stretches: raise them, or use NeoHookean",
)
