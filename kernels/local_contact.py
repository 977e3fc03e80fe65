"""The contact problem of one node, solved exactly (METHOD 2).

    min 1/2 d.D d - r.d   with   g_p + n_p.d + e lambda_p >= 0,  lambda_p >= 0,  complementary,   p < slots

d has `block` components; e = 0 is the rigid constraint, e = 1/(kappa A) a penalty. In the multipliers it is a small
linear complementarity problem, W lambda + c >= 0 with W = N D^-1 N^t + e and c = g + N D^-1 r, solved by trying its
2^slots active sets, the largest first so that dependent normals share their load.
"""

import taichi as ti

# W is regularised and the solution refined (proximal iteration): from lambda = 0 it reaches the least-norm multipliers
# of linearly dependent normals, with an error of DEPENDENT^(REFINEMENTS + 1)
DEPENDENT = 1e-5
REFINEMENTS = 4
TIE = 1e-8  # of the largest gap in play


@ti.func
def multipliers(free, normals, gaps, inverse, compliance, slots: ti.template()):
    """lambda [slots] for the unconstrained solution d = free; normals [slots, block], inverse = D^-1."""
    result = ti.Vector.zero(ti.f64, slots)
    if ti.static(slots == 1):
        normal = ti.Vector([normals[0, j] for j in ti.static(range(normals.m))])
        stiffness = normal.dot(inverse @ normal) + compliance
        violation = -(gaps[0] + normal.dot(free))
        if violation > 0.0 and stiffness > 0.0:
            result[0] = violation / stiffness
    else:
        coupling = normals @ inverse @ normals.transpose()
        start = gaps + normals @ free
        span = 0.0
        for p in ti.static(range(slots)):
            coupling[p, p] += compliance
            if coupling[p, p] > 0.0:
                span = ti.max(span, ti.abs(start[p]))
        best = 1e300
        for trial in range(2**slots):
            mask = 2**slots - 1 - trial
            matrix = ti.Matrix.identity(ti.f64, slots)
            right = ti.Vector.zero(ti.f64, slots)
            for p in ti.static(range(slots)):
                if (mask >> p) & 1 == 1:
                    right[p] = 0.0 - start[p]
                    if coupling[p, p] > 0.0:
                        for q in ti.static(range(slots)):
                            if (mask >> q) & 1 == 1:
                                matrix[p, q] = coupling[p, q]
                        matrix[p, p] = coupling[p, p] * (1.0 + DEPENDENT)
            solve = matrix.inverse()
            guess = solve @ right
            rest = start + coupling @ guess
            for _ in range(REFINEMENTS):
                for p in ti.static(range(slots)):
                    right[p] = ti.select((mask >> p) & 1 == 1 and coupling[p, p] > 0.0, 0.0 - rest[p], 0.0)
                guess += solve @ right
                rest = start + coupling @ guess
            violation = 0.0
            for p in ti.static(range(slots)):
                if (mask >> p) & 1 == 1:
                    scale = ti.select(coupling[p, p] > 0.0, coupling[p, p], 1.0)
                    violation = ti.max(violation, -guess[p] * scale, ti.abs(rest[p]))
                else:
                    violation = ti.max(violation, -rest[p])
            if violation < best - TIE * span:  # on a tie the larger set stays: its walls share the load
                best = violation
                result = ti.max(guess, 0.0)
    return result
