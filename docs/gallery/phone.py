"""A case for a phone, a thin shell of tetrahedra, falls on one corner."""

import numpy as np

import tcontact as tc

CELLS, DURATION = (80, 40, 6), 2e-3
SIZE = np.array((0.150, 0.075, 0.009))
WALL = 0.003

block = tc.box_mesh(SIZE, CELLS, kind="tet4")
centre = block.cell_centres()
pocket = np.all((centre > WALL) & (centre < SIZE - (WALL, WALL, 0.0)), axis=1)  # open above
kept, cells = np.unique(block.cells[~pocket], return_inverse=True)
mesh = tc.Mesh(block.nodes[kept], cells.reshape(-1, 4), kind="tet4")

corner = -0.5 * SIZE  # from the middle to the corner that lands
turn = np.cross(corner, (0.0, 0.0, -1.0)), np.arccos(-corner[2] / np.linalg.norm(corner))
mesh = mesh.rotated(turn)
mesh = mesh.translated((0.0, 0.0, 1e-5 - mesh.bounds[0][2]))

rubber = tc.NeoHookean(young=5e7, poisson=0.45, density=1200.0)
case = tc.Body(mesh, rubber, velocity=(0.0, 0.0, -3.0), contact="auto", name="case")
scene = tc.Scene([case], [tc.Plane(name="floor")], duration=DURATION, friction=tc.Coulomb(0.3), maxima="von_mises")
result = tc.simulate(scene, out="runs/phone", frames=60)
print(f"{mesh.cell_count} tetrahedra, {mesh.node_count} nodes")
print(result)

history = result.history
print(f"largest force on the floor {history['contact_force'][:, 2].max():.0f} N")
print(f"largest stress of all cells and steps {result.maxima['von_mises'].value / 1e6:.1f} MPa")
print(f"largest energy error {history['energy_error'].max():.1e}")
