"""When a static solve measures, linearises, sweeps and ends: one decision after every measure of the residual.

A tangent is kept, from step to step too, while each use of it makes the residual much smaller (USED_UP). A use that
will leave too little to matter is the last and is not measured again, and no linear problem is solved much further
than the contraction of the last use says that the law's nonlinearity is worth. Where K_KK is not definite (buckling
under strong compression) progress is slow: below the tolerance it is enough then, above it each few sweeps get their
own linearisation and go down in energy.
"""

import taichi as ti

# numbers of `stats` [islands, STATS]
F_REF, RESIDUAL, SWEEPS, PIVOT, STIFFEST, ROUNDING = 0, 1, 2, 3, 4, 5
BEFORE, CONTRACTION, STALE, TODO, NEXT, CONVERGED = 6, 7, 8, 9, 10, 11
VISCOUS_RATE = 12  # 1/dt [1/s] that the tangent has of viscous contact cells
STATS = 13
# numbers of `settings` [islands, SETTINGS]
MINIMUM_SWEEPS, POLISHING_SWEEPS, MAXIMUM_SWEEPS, AIM, TOLERANCE, LEFT, REACH, MINIMUM_FORCE = 0, 1, 2, 3, 4, 5, 6, 7
LINEAR, RELAXATION, MAXIMUM_IN_ALL, STEP_LENGTH = 8, 9, 10, 11
SETTINGS = 12
# values of stats[TODO] and stats[NEXT]
DONE, MEASURE, SWEEP, LAST_SWEEP = 0.0, 1.0, 2.0, 3.0

USED_UP = 0.05  # a tangent that leaves more than this share of a residual is renewed
FORCING = 0.3  # of the residual that the law's nonlinearity will leave anyway
FEWEST = 2  # sweeps or products of a linearisation
SLOW = 0.5  # a linearisation that leaves more than this share of a residual below the tolerance is the last one


@ti.func
def judge(stats: ti.template(), settings: ti.template(), island, first):
    """Decide what an island does next, stats[TODO], from the residual just measured; first: 1 at the first one."""
    at, its = island * STATS, island * SETTINGS
    residual = stats[at + RESIDUAL]
    aim, left = settings[its + AIM], settings[its + LEFT]
    stats[at + TODO] = SWEEP
    if settings[its + LINEAR] == 1.0:
        stats[at + TODO] = LAST_SWEEP
    fine = residual <= ti.max(settings[its + TOLERANCE], stats[at + ROUNDING])
    if first == 1:
        stats[at + SWEEPS] = 0.0
        if fine and USED_UP * residual <= left and stats[at + STALE] == 0.0:
            stats[at + TODO] = LAST_SWEEP
    else:
        contraction = ti.min(1.0, residual / ti.max(stats[at + BEFORE], aim))
        if stats[at + BEFORE] > aim:
            stats[at + CONTRACTION] = contraction
        stats[at + STALE] = ti.select(contraction > USED_UP, 1.0, 0.0)
        if fine:
            enough = residual <= ti.max(aim, stats[at + ROUNDING])
            slow = contraction > SLOW and left > 0.0
            if enough or slow or contraction * residual <= left:
                end = (slow or residual <= aim) and stats[at + SWEEPS] >= settings[its + MINIMUM_SWEEPS]
                stats[at + TODO] = ti.select(end, DONE, LAST_SWEEP)
        elif not residual < 1e300 or stats[at + SWEEPS] >= settings[its + MAXIMUM_IN_ALL]:
            stats[at + TODO] = DONE


@ti.func
def goals(stats: ti.template(), settings: ti.template(), island):
    """Least number of sweeps or products of a linear problem, the residual to aim at and the one that will do."""
    at, its = island * STATS, island * SETTINGS
    least, aim = settings[its + MINIMUM_SWEEPS], settings[its + AIM]
    if settings[its + LINEAR] == 0.0:
        if stats[at + TODO] == LAST_SWEEP:
            least = ti.max(FEWEST, least - stats[at + SWEEPS])
        else:
            least = ti.select(stats[at + SWEEPS] == 0.0, 0.5 * least, 1.0 * FEWEST)
            aim = ti.max(aim, FORCING * stats[at + CONTRACTION] * stats[at + RESIDUAL])
    return least, aim, ti.max(settings[its + TOLERANCE], stats[at + ROUNDING])


@ti.func
def any_island(stats: ti.template(), number: ti.template(), value: ti.template()):
    """Return 1 where a number of any island has this value, else 0."""
    found = 0
    for island in range(stats.shape[0] // STATS):
        if stats[island * STATS + number] == value:
            found = 1
    return found
