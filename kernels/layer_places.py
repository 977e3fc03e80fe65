"""Places of what couples friction layers with contact nodes on a GPU (layer/device_layers.py); the host shares them.

`layers` holds the numbers of all, HEAD of them; then every number of a node for all nodes k, [NODE, k]; then every
number of a layer for all entries e, [ENTRY, e]; then the largest friction work [J/m^2] of every body. An entry is a
layer of a node: a node that may slide on several metals has one for each of them.

`layer_tables` holds the layer step [s] of its columns, then for every batch of layers of the same metals the columns of
the nodes (layer/layer1d_residual.py) and the parameters of the metals (layer/layer1d.py), which the layer kernels read,
and what these are computed from: of every node its conductance to the next one, behind the last one that of the far end
[W/(m^2 K)], and its heat capacity [J/(m^2 K)]; then the resistance of the contact [m^2 K/W].

`layer_lists` are joint lists (language/joint_lists.py).
"""

# layer steps per mechanical step, mechanical steps per layer step, estimated error; time [s] and mechanical steps since
# the last layer step; kick [s] whose work or force waits to be collected; share of START (below); what the layers do
# next: REST, SPEND or SOLVE; tolerance and largest number of layer steps of the model; shares of the heat of slip and
# of plastic work that stay in the layer; warming of a surface by heat of a time, times its root [K m^2 s^(1/2)/J]; rise
# of temperature that melts [K]
SUBSTEPS, SPAN, ERROR, ELAPSED, COUNT, KICK, SHARE, PHASE = range(8)
TOLERANCE, MOST_SUBSTEPS, HEAT_SHARE, PLASTIC_HEAT, SOFTNESS, MELTING_RISE = range(8, 14)
HEAD = 14
REST, SPEND, SOLVE = 0.0, 1.0, 2.0  # nothing; a step with the work that waits; a step together with the kick

# of a node: area [m^2], coefficient of friction, batch of the layer that it uses; work that waits [J/m^2]; impulses of
# friction and pressure since the last layer step [Pa s]; 1 where it is pressed, pressure [Pa] and friction force [N] of
# the last level; 1 where it slides; work of the last kick that the layers took with it, work owed by an earlier run,
# heat to obstacles that does not count on the present area [J/m^2]; values before the kick: surface temperature less
# the base [K], shear stress [Pa], plastic work and heat to obstacles [J/m^2]; pressure now [Pa]; of the last layer
# step: 1 where it slid, mean shear stress [Pa], friction power [W/m^2], change of the surface temperature [K]
AREA, COEFFICIENT, USED, WAITING, FRICTION_IMPULSE, PRESSURE_IMPULSE, PRESSED, LAST, LAST_FORCE, SLID = range(10)
KICK_WORK, OWED, GIVEN_BEFORE, START_RISE, START_SHEAR, START_PLASTIC, START_GIVEN = range(10, 17)
PRESSURE, SLIDES, MEAN_SHEAR, POWER, WARMING = range(17, 22)
NODE = 22
# of a layer, after its last step: sqrt3 tau [Pa], its last two changes, 1 - sig/s_melt, work of slip, plastic work and
# heat to the obstacle [J/m^2], surface temperature less the base [K]
STRESS, CHANGE, BEFORE, CLOSE, WORK, PLASTIC, GIVEN, RISE = range(8)
ENTRY = 8

# lists: bodies with contact nodes, entries, batches, columns of PARTNERS, points of a side; first contact node of every
# body, and the end; body of every node; place in `layer_tables` and sides of every batch; batch of a body on every
# obstacle [body, obstacle]; node of every entry; entry of every node in every batch [batch, k], -1 for none
SIZES, STARTS, BODY_OF, TABLES, SIDES, PARTNERS, NODE_OF, ENTRY_OF = range(8)
LISTS = 8
BODIES, ENTRIES, BATCHES, COLUMNS, POINTS = range(5)
# what takes heat of slip beside the layer of the body: an obstacle what its one layer does not take; the second side,
# of an obstacle; that of another body
TO_NONE, TO_OBSTACLE, TO_BODY = 0, 1, 2

# numbers of a row of the history: heat in the layers, heat to obstacles [J]; hottest surface less the base [K], lowest
# shear stress of a layer that slides [Pa], 0 for none; estimated error; layer steps in a mechanical step
ROW = ("layer_heat", "obstacle_heat", "layer_temperature_max", "layer_shear_min", "layer_error", "layer_substeps")

# how the layers choose their steps (tcontact/contact/layered_friction.py uses the same numbers)
COOL = 0.5  # 1 - stress/(stress that would melt the surface) above which a layer step may span mechanical ones
FIRST = 8  # layer steps in the first mechanical step that slides
MAXIMUM_SPAN = 32  # mechanical steps that one layer step may span
SMALLEST_WORK = 1e-6  # share of the largest friction work of a step of its body above which a node slides
ROUNDING = 1e-10  # relative rounding error of the friction work of a node that sticks
EASY = 0.1  # share of the tolerance below which the error allows longer layer steps
WARM = 0.1  # share of the rise that melts the metal: least scale of changes of the surface temperature
STEADY = 0.4  # share of the tolerance below which the change of the surface temperature allows longer layer steps
