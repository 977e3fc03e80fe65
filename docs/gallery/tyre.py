"""A rubber tyre on a rigid rim lands on a road, rolls and drags the rim along."""

import numpy as np

import tcontact as tc

CELLS, DURATION = 48, 0.25
OUTER, INNER, WIDTH, SPEED = 0.10, 0.06, 0.04, 2.0  # [m], [m/s]; it lands without turning

mesh = tc.ring_mesh(INNER, OUTER, WIDTH, cells=CELLS, axis="y", center=(0.0, 0.0, OUTER + 5e-4))
rubber = tc.NeoHookean(young=5e6, poisson=0.45, density=1100.0)
tyre = tc.Body(
    mesh,
    rubber,
    velocity=(SPEED, 0.0, -0.5),
    contact="outer",
    rigid_parts=[tc.RigidPart("inner", mass=0.5)],
    name="tyre",
)
road = tc.Plane(friction=tc.Coulomb(0.8), name="road")
scene = tc.Scene(
    [tyre], [road], duration=DURATION, gravity=(0.0, 0.0, -9.81), contact=tc.MasslessContact(removal="full")
)
result = tc.simulate(scene, out="runs/tyre", frames=60)
print(result)

history = result.history
spin = history["part_angular_velocity:tyre-inner"][-1, 1]
speed = history["part_velocity:tyre-inner"][-1, 0]
print(f"the rim turns with {spin:.1f} rad/s; rolling without slip would take {speed / OUTER:.1f}")
print(f"largest force on the road {np.linalg.norm(history['contact_force'], axis=1).max():.0f} N")
print(f"friction took {history['friction_work'][-1]:.2f} J of {history['kinetic'][0]:.2f} J")
print(f"largest energy error {history['energy_error'].max():.1e}")
