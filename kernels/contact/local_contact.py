"""The contact problem of one node, solved exactly (METHOD 2).

    min 1/2 d.D d - r.d   with   g_p + n_p.d + e lambda_p >= 0,  lambda_p >= 0,  complementary,   p < slots

d has `block` components; e = 0 is the rigid constraint, e = 1/(kappa A) a penalty. In the multipliers this is a small
linear complementarity problem, W lambda + c >= 0 with W = N D^-1 N^t + e and c = g + N D^-1 r, solved by trying its
2^slots active sets. Violations of two sets count as equal when they differ by less than rounding, measured by the
largest penetration -c of the free motion D^-1 r. The gaps of distant rows do not enter this measure, so such a row does
not change the result by a bit. Where normals are linearly dependent, the motion is unique but lambda is not; the
shortest lambda with the same N^t lambda is taken.
"""

from ..engine import ti

SINGULAR = 1e-13  # normals are linearly dependent when a pivot is below this times its diagonal entry
TIE = 1e-12  # rounding error of W lambda + c, over the largest penetration
SHARING = 1e-9  # rows whose gap after the solve is below this times the largest penetration may share the load
# relative regularisation of N N^t; the error of the shared forces is SHARED^(REFINEMENTS + 1)
SHARED = 1e-10
REFINEMENTS = 3
SAME = 1e-11  # relative change of the total force that sharing may cause


@ti.func
def solved(matrix, right, slots: ti.template()):
    """Return the solution of a symmetric positive definite system, and its smallest pivot over the diagonal entry.

    Rows of the identity do not change the arithmetic of the other rows by a bit.
    """
    reduced = matrix
    answer = right
    pivot = 1.0
    for p in ti.static(range(slots)):
        pivot = ti.min(pivot, reduced[p, p] / matrix[p, p])
        for q in ti.static(range(p + 1, slots)):
            factor = reduced[q, p] / reduced[p, p]
            for s in ti.static(range(p + 1, slots)):
                reduced[q, s] = reduced[q, s] - factor * reduced[p, s]
            answer[q] = answer[q] - factor * answer[p]
    for back in ti.static(range(slots)):
        p = ti.static(slots - 1 - back)
        for q in ti.static(range(p + 1, slots)):
            answer[p] = answer[p] - reduced[p, q] * answer[q]
        answer[p] = answer[p] / reduced[p, p]
    return answer, pivot


@ti.func
def part(matrix, mask, slots: ti.template()):
    """Return the rows and columns of a matrix that are in the mask, and the identity elsewhere."""
    result = ti.Matrix.identity(ti.f64, slots)
    for p, q in ti.static(ti.ndrange(slots, slots)):
        if (mask >> p) & 1 == 1 and (mask >> q) & 1 == 1:
            result[p, q] = matrix[p, q]
    return result


@ti.func
def chosen(values, mask, slots: ti.template()):
    """Return the entries that are in the mask, and 0 elsewhere."""
    result = ti.Vector.zero(ti.f64, slots)
    for p in ti.static(range(slots)):
        if (mask >> p) & 1 == 1:
            result[p] = values[p]
    return result


@ti.func
def shortest(pressing, normals, sharing, slots: ti.template()):
    """Return the shortest lambda >= 0 of the rows in the mask with the same force, or `pressing` if there is none."""
    gram = normals @ normals.transpose()
    force = gram @ pressing
    matrix = part(gram, sharing, slots)
    for p in ti.static(range(slots)):
        matrix[p, p] = matrix[p, p] * (1.0 + SHARED)
    shared = ti.Vector.zero(ti.f64, slots)
    for _ in range(REFINEMENTS + 1):
        change, _pivot = solved(matrix, chosen(force - gram @ shared, sharing, slots), slots)
        shared += change
    shared = ti.max(shared, 0.0)
    same = (normals.transpose() @ (shared - pressing)).norm() <= SAME * (normals.transpose() @ pressing).norm()
    return ti.select(same, shared, pressing)


@ti.func
def multipliers(free, normals, gaps, inverse, compliance, slots: ti.template()):
    """Return lambda [slots] for the unconstrained solution d = free; normals [slots, block], inverse = D^-1."""
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
        live = 0
        for p in ti.static(range(slots)):
            coupling[p, p] += compliance
            if coupling[p, p] > 0.0:
                live += 1 << p
                span = ti.max(span, -start[p])
        if span > 0.0:
            best, sharing, active = 1e300, 0, 0
            for trial in range(2**slots):
                mask = 2**slots - 1 - trial
                if (mask & live) == mask:
                    guess, pivot = solved(part(coupling, mask, slots), chosen(0.0 - start, mask, slots), slots)
                    if pivot > SINGULAR:
                        rest = start + coupling @ guess
                        closed, violation = mask, 0.0
                        for p in ti.static(range(slots)):
                            if (live >> p) & 1 == 1:
                                violation = ti.max(violation, -rest[p], -guess[p] * coupling[p, p])
                                if rest[p] <= SHARING * span:
                                    closed |= 1 << p
                        if violation < best - TIE * span:
                            best, sharing, active = violation, closed, mask
                            result = ti.max(guess, 0.0)
            if sharing != active and compliance == 0.0:
                result = shortest(result, normals, sharing, slots)
    return result
