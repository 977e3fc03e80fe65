"""Table of places: where the numbers of rigid bodies stand in `Rigid.values` (nodes/rigid_record.py).

Host and kernels share the table. `values` holds a head, a record for each rigid body, the arms [t, 3] of the tied nodes
of rigid parts at t = 0, and poses of all bodies, one for every time level of a launch, where parts are driven. `ties`
holds where the tied nodes of every body start and the last ones end [bodies + 1], then their boundary nodes [t].
"""

# head: number of records; place in `sums` of the group "rigid"; origin (3) [m] of the positions of the obstacles; time
# [s] within which a node must be able to touch to count in the stable step; step [s] before the first row; places
# of the arms and of the poses; rate [1/s^2] above which a launch ends
COUNT, SUMS_AT, CENTRE, REACH, FIRST_STEP, ARMS_AT, POSES_AT, LIMIT, HEAD = 0, 1, 2, 5, 6, 7, 8, 9, 10
# record: kind (0: a prescribed obstacle, 1: free, 2: driven); mass [kg] and its inverse; principal moments (3)
# [kg m^2] and their inverses (3); centre of mass (3) [m] at t = 0; principal axes (9, rows) and obstacle axes (9, rows)
# at t = 0; displacement (3) [m]; velocity (3) [m/s]; angular momentum (3) [kg m^2/s] about the centre; rotation since
# t = 0, unit quaternion (4); angular velocity (3) [rad/s] of the last step; force (3) [N] and moment (3) [N m] about
# the centre; bound of the stable step: 6 numbers of a direction, matrix (36) [1/s^2]
KIND, MASS, INVERSE_MASS, MOMENTS, INVERSE_MOMENTS, START, AXES, FRAME = 0, 1, 2, 3, 6, 9, 12, 21
MOVED, VELOCITY, SPIN, TURN, MEAN_SPIN, FORCE, MOMENT, DIRECTION, BOUND, RECORD = 30, 33, 36, 39, 43, 46, 49, 52, 58, 94
PRESCRIBED, FREE, DRIVEN = 0, 1, 2
# a pose of a driven part: displacement (3) [m] of the centre of mass and rotation (4) since t = 0
POSE = 7
