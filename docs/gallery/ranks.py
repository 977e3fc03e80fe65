"""A long rubber fender strikes a pier, on one process or on several: mpiexec -n 2 python ranks.py"""

import tcontact as tc

CELLS = (12, 12, 96)

rubber = tc.NeoHookean(young=1e7, poisson=0.3, density=1100.0)
fender = tc.Body(
    tc.box_mesh((0.1, 0.1, 0.8), CELLS).rotated(((0.0, 1.0, 0.0), 0.1)),
    rubber,
    velocity=(0.0, 0.0, -5.0),
    contact=("zmin", "xmin"),
    name="fender",
)
pier = tc.Plane((0.0, 0.0, -0.02), name="pier")
contact = tc.MasslessContact(tolerance=1e-8)
scene = tc.Scene([fender], [pier], duration=0.02, contact=contact, friction=tc.Coulomb(0.3))

result = tc.simulate(scene, out="runs/ranks", frames=40)
if tc.is_first_rank():  # all processes have the history, and one prints
    force = result.history["contact_force"][:, 2]
    print(f"{fender.mesh.cell_count} cells, {result.steps} steps of {1e6 * result.dt:.1f} us")
    print(f"largest force on the pier {force.max():.8f} N")
    print(f"largest energy error {result.history['energy_error'].max():.1e}")
