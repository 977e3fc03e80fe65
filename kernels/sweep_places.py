"""Places of the numbers that control the sweeps of an island (sweeps.py)."""

# 1 if another sweep follows; sweeps done and their last residual; 1 where it has stalled; relaxation; limit of sweeps;
# 1 where they are accelerated; sweeps done and residual at the last check; 1 before a backward sweep; factor of the
# extrapolation; pairs of sweeps since it restarted
RUNNING, COUNT, DEFECT, STALLING, OMEGA, SWEEP_LIMIT, ACCELERATED, CHECKED, MARK, BACKWARD, FACTOR, STRAIGHT = range(12)
STATE = 12
