"""A nylon punch strikes a rubber bumper: the script of the tutorial. It takes half a minute: python tutorial.py"""

# --8<-- [start:bodies]
import numpy as np

import tcontact as tc

rubber = tc.NeoHookean(young=5e6, poisson=0.45, density=1100.0)
nylon = tc.LinearElastic(young=2e9, poisson=0.39, density=1150.0)

block = tc.box_mesh(size=(0.10, 0.10, 0.04), cells=(12, 12, 6))
bumper = tc.Body(block, rubber, contact="zmax", supports=[tc.Support("zmin", "xyz")], name="bumper")

rod = tc.cylinder_mesh(radius=0.02, length=0.05, cells=4, center=(0.05, 0.05, 0.066))
punch = tc.Body(rod, nylon, velocity=(0.0, 0.0, -5.0), contact="zmin", name="punch")
# --8<-- [end:bodies]

# --8<-- [start:scene]
scene = tc.Scene(bodies=[bumper, punch], duration=4e-3, friction=tc.Coulomb(0.3))
print(tc.plan(scene).describe())
# --8<-- [end:scene]

# --8<-- [start:run]
result = tc.simulate(scene, out="runs/punch", frames=40, progress=True)
print(result)
# --8<-- [end:run]

# --8<-- [start:questions]
history = result.history
force = np.linalg.norm(history["pair_force:bumper-punch"], axis=1)
print(f"largest force {force.max():.0f} N at {1e3 * history['time'][force.argmax()]:.2f} ms")

upward = result.velocity[result.nodes_of("punch"), 2].mean()
print(f"the punch comes back with {upward:.2f} m/s")

print(f"largest energy error {history['energy_error'].max():.1e}")
print(f"friction took {history['friction_work'][-1]:.3f} J, viscosity {history['viscous_work'][-1]:.3f} J")

result.plot("contact_force").figure.savefig("runs/punch/force.png")
result.render("runs/punch/pressed.png", time=history["time"][force.argmax()])
# --8<-- [end:questions]

# --8<-- [start:error]
finer = tc.simulate(scene, scheme=tc.CentralDifference(cfl=0.45))
half = np.linalg.norm(finer.history["pair_force:bumper-punch"], axis=1)
print(f"half the step changes the largest force by {abs(half.max() / force.max() - 1):.1e}")
# --8<-- [end:error]
