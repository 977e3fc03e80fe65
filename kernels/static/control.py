"""Control of the static solve: after each measured residual it decides whether to solve again, linearise, or stop.

The solve of an island is a Newton iteration: measure the residual on the contact cells, linearise (K_KK), solve the
linear contact problem by sweeps or MPRGP, move the nodes, measure again (solve.py). The decisions save work:

- The tangent is kept, also in later time steps, as long as every solve with it leaves at most RENEWAL of the residual.
- A solve whose result is expected to be below the limit LEFT is the last one; its residual is not measured.
- A linear problem is solved only as far as the nonlinearity of the law is worth, judged by the last contraction.
- Where K_KK is indefinite (buckling under strong compression) the residual falls slowly. Below the tolerance the solve
  ends then; above it the law is linearised again after every few sweeps, and the energy decreases.

Residuals are relative to F_ref, the force scale of the island (solve.py).
"""

from ..engine import ti

# numbers of `stats` [islands, STATS]
F_REF, RESIDUAL, SWEEPS = 0, 1, 2  # force scale [N]; residual; sweeps (or products) so far in this solve
PIVOT, STIFFEST = 3, 4  # smallest pivot of the diagonal blocks over their trace; largest trace [N/m]
ROUNDING, BEFORE, CONTRACTION = 5, 6, 7  # rounding error of the residual; last residual; ratio of the last two
STALE, TODO, NEXT, CONVERGED = 8, 9, 10, 11  # 1: renew the tangent; what to do now, and after that; 1: converged
VISCOUS_RATE = 12  # 1/dt [1/s] that the tangent holds for viscous contact cells
PAIR_STEP, SOLVES = 13, 14  # length of a projected step with pairs of bodies, 0: not known yet; solves of this step
STATS = 15
# numbers of `settings` [islands, SETTINGS]
MINIMUM_SWEEPS, MAXIMUM_IN_ALL = 0, 10  # sweeps of a solve
POLISHING_SWEEPS, MAXIMUM_SWEEPS = 1, 2  # largest number of sweeps of a linear problem, below and above the tolerance
AIM, TOLERANCE, LEFT = 3, 4, 5  # residual to aim at; to accept; that the last solve with a tangent may leave
REACH, MINIMUM_FORCE = 6, 7  # longest move of a node in one linear problem [m]; smallest F_ref [N]
LINEAR, RELAXATION, STEP_LENGTH = 8, 9, 11  # 1: law and gaps are linear; omega of sweeps.py; step of mprgp.py
REFUSES = 12  # 1: the law is not valid where a diagonal block is not positive definite (`Law.refusal`)
MAXIMUM_SOLVES = 13  # linear problems of a step after which its residual is accepted; 0: it must fall to the tolerance
SETTINGS = 14
# values of stats[TODO] and stats[NEXT]; SWEEP stands for a solve of the linear problem by either solver
DONE, MEASURE, SWEEP, LAST_SWEEP = 0.0, 1.0, 2.0, 3.0

RENEWAL = 0.05  # the tangent is renewed when a solve with it leaves more than this ratio of the residual
FORCING = 0.3  # ratio of the expected nonlinear residual to which a linear problem is solved
FEWEST = 2  # sweeps or products of a linear problem, at least
CALM = 0.5  # ratio of the tolerance above which no solve is the last one: with an old tangent it may raise the residual
SLOW = 0.5  # below the tolerance, the solve ends when a linear problem leaves more than this ratio of the residual


@ti.func
def judge(stats: ti.template(), settings: ti.template(), island, first):
    """Set stats[TODO] of an island from the residual just measured; first: 1 at the first measure of a time step."""
    at, its = island * STATS, island * SETTINGS
    residual = stats[at + RESIDUAL]
    aim, left = settings[its + AIM], settings[its + LEFT]
    stats[at + TODO] = SWEEP
    if settings[its + LINEAR] == 1.0:
        stats[at + TODO] = LAST_SWEEP
    fine = residual <= ti.max(settings[its + TOLERANCE], stats[at + ROUNDING])
    calm = residual <= ti.max(CALM * settings[its + TOLERANCE], stats[at + ROUNDING])
    if first == 1:
        stats[at + SWEEPS] = 0.0
        if residual == 0.0 and stats[at + STALE] == 0.0:  # as in free flight: no solve would move a node
            stats[at + TODO] = DONE
        elif calm and RENEWAL * residual <= left and stats[at + STALE] == 0.0:
            stats[at + TODO] = LAST_SWEEP
    else:
        contraction = ti.min(1.0, residual / ti.max(stats[at + BEFORE], aim))
        if stats[at + BEFORE] > aim:
            stats[at + CONTRACTION] = contraction
        stats[at + STALE] = ti.select(contraction > RENEWAL, 1.0, 0.0)
        if fine:
            enough = residual <= ti.max(aim, stats[at + ROUNDING])
            slow = contraction > SLOW and left > 0.0
            if enough or slow or contraction * residual <= left:
                if (slow or residual <= aim) and stats[at + SWEEPS] >= settings[its + MINIMUM_SWEEPS]:
                    stats[at + TODO] = DONE
                elif calm or stats[at + SWEEPS] >= settings[its + MAXIMUM_IN_ALL]:
                    stats[at + TODO] = LAST_SWEEP
        elif not residual < 1e300 or stats[at + SWEEPS] >= settings[its + MAXIMUM_IN_ALL]:
            stats[at + TODO] = DONE
    stats[at + SOLVES] = ti.select(first == 1, 1.0, stats[at + SOLVES] + 1.0)
    if settings[its + MAXIMUM_SOLVES] > 0.0 and stats[at + TODO] == SWEEP:
        if stats[at + SOLVES] >= settings[its + MAXIMUM_SOLVES]:
            stats[at + TODO] = LAST_SWEEP


@ti.func
def goals(stats: ti.template(), settings: ti.template(), island):
    """Return the minimum number of sweeps (or products) of a linear problem, the residual to aim at and to accept."""
    at, its = island * STATS, island * SETTINGS
    minimum, aim = settings[its + MINIMUM_SWEEPS], settings[its + AIM]
    if settings[its + LINEAR] == 0.0:
        if stats[at + TODO] == LAST_SWEEP:
            minimum = ti.max(FEWEST, minimum - stats[at + SWEEPS])
        else:
            minimum = ti.select(stats[at + SWEEPS] == 0.0, 0.5 * minimum, 1.0 * FEWEST)
            aim = ti.max(aim, FORCING * stats[at + CONTRACTION] * stats[at + RESIDUAL])
    return minimum, aim, ti.max(settings[its + TOLERANCE], stats[at + ROUNDING])


@ti.func
def needs_products(settings: ti.template(), island, done, residual, minimum, aim, accepted):
    """Return whether a linear problem needs more products with K than those done; minimum, aim, accepted: `goals`."""
    its = island * SETTINGS
    more = done < minimum or (done < settings[its + POLISHING_SWEEPS] and residual > aim)
    return more or (done < settings[its + MAXIMUM_IN_ALL] and residual > accepted)


@ti.func
def any_island(stats: ti.template(), number: ti.template(), value: ti.template()):
    """Return 1 if this number of `stats` has this value in any island, else 0."""
    found = 0
    for island in range(stats.shape[0] // STATS):
        if stats[island * STATS + number] == value:
            found = 1
    return found
