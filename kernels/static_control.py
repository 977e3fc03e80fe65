"""When a static solve measures, linearises, sweeps and ends: one decision after every measure of the residual.

A tangent is kept, from step to step too, while each use of it makes the residual much smaller (USED_UP). A use that
will leave too little to matter is the last and is not measured again, and no linear problem is solved much further
than the contraction of the last use says that the law's nonlinearity is worth. Where K_KK is not definite (buckling
under strong compression) progress is slow: below the tolerance it is enough then, above it each few sweeps get their
own linearisation and go down in energy.
"""

import taichi as ti

# numbers of `stats`
F_REF, RESIDUAL, SWEEPS, PIVOT, STIFFEST, ROUNDING = 0, 1, 2, 3, 4, 5
BEFORE, CONTRACTION, STALE, TODO, NEXT, CONVERGED = 6, 7, 8, 9, 10, 11
STATS = 12
# numbers of `settings`
LEAST_SWEEPS, POLISHING_SWEEPS, MOST_SWEEPS, AIM, TOLERANCE, LEFT, REACH, LEAST_FORCE = 0, 1, 2, 3, 4, 5, 6, 7
LINEAR, RELAXATION, MOST_IN_ALL, STEP_LENGTH = 8, 9, 10, 11
SETTINGS = 12
# values of stats[TODO] and stats[NEXT]
DONE, MEASURE, SWEEP, LAST_SWEEP = 0.0, 1.0, 2.0, 3.0

USED_UP = 0.05  # a tangent that leaves more than this share of a residual is renewed
FORCING = 0.3  # of the residual that the law's nonlinearity will leave anyway
FEWEST = 2  # sweeps or products of a linearisation
SLOW = 0.5  # a linearisation that leaves more than this share of a residual below the tolerance is the last one


@ti.func
def judge(stats: ti.template(), settings: ti.template(), first):
    """stats[TODO] from the residual just measured; `first` measure of this step or not."""
    residual = stats[RESIDUAL]
    aim, left = settings[AIM], settings[LEFT]
    stats[TODO] = SWEEP
    if settings[LINEAR] == 1.0:
        stats[TODO] = LAST_SWEEP
    fine = residual <= ti.max(settings[TOLERANCE], stats[ROUNDING])
    if first == 1:
        stats[SWEEPS] = 0.0
        if fine and USED_UP * residual <= left and stats[STALE] == 0.0:
            stats[TODO] = LAST_SWEEP
    else:
        contraction = ti.min(1.0, residual / ti.max(stats[BEFORE], aim))
        if stats[BEFORE] > aim:
            stats[CONTRACTION] = contraction
        stats[STALE] = ti.select(contraction > USED_UP, 1.0, 0.0)
        if fine:
            enough = residual <= ti.max(aim, stats[ROUNDING])
            slow = contraction > SLOW and left > 0.0
            if enough or slow or contraction * residual <= left:
                end = (slow or residual <= aim) and stats[SWEEPS] >= settings[LEAST_SWEEPS]
                stats[TODO] = ti.select(end, DONE, LAST_SWEEP)
        elif not residual < 1e300 or stats[SWEEPS] >= settings[MOST_IN_ALL]:
            stats[TODO] = DONE


@ti.func
def goals(stats: ti.template(), settings: ti.template()):
    """Least number of sweeps or products of a linear problem, the residual to aim at and the one that will do."""
    least, aim = settings[LEAST_SWEEPS], settings[AIM]
    if settings[LINEAR] == 0.0:
        if stats[TODO] == LAST_SWEEP:
            least = ti.max(FEWEST, least - stats[SWEEPS])
        else:
            least = ti.select(stats[SWEEPS] == 0.0, 0.5 * least, 1.0 * FEWEST)
            aim = ti.max(aim, FORCING * stats[CONTRACTION] * stats[RESIDUAL])
    return least, aim, ti.max(settings[TOLERANCE], stats[ROUNDING])
