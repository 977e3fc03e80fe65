"""A rubber ball is dropped beside the middle of a bowl, whose surface comes from an STL file."""

from pathlib import Path

import meshio
import numpy as np

import tcontact as tc

CELLS, GRID, DURATION = 8, 96, 0.03
FOLDER = Path("runs/bowl")

# the bowl, as a drawing program would export it: a profile turned about z, here of 64 pieces
angle = np.linspace(0.0, 0.45 * np.pi, 25)
inside = np.stack([0.10 * np.sin(angle), 0.10 - 0.10 * np.cos(angle)], axis=1)
outside = np.stack([0.115 * np.sin(angle), 0.10 - 0.115 * np.cos(angle)], axis=1)[::-1]
profile = np.concatenate([inside, outside])
turn = np.linspace(0.0, 2.0 * np.pi, 65)[:-1]
points = np.stack(
    [np.outer(np.cos(turn), profile[:, 0]), np.outer(np.sin(turn), profile[:, 0]), np.tile(profile[:, 1], (64, 1))],
    axis=2,
)
corner = np.arange(points[..., 0].size).reshape(points.shape[:2])
right, up = np.roll(corner, -1, axis=0), (slice(None), slice(1, None))
down = (slice(None), slice(None, -1))
faces = np.concatenate(
    [
        np.stack([corner[down], right[down], right[up]], axis=2)[:, 1:].reshape(-1, 3),
        np.stack([corner[down], right[up], corner[up]], axis=2)[:, :-1].reshape(-1, 3),
    ]
)  # without the triangles on the axis, where their corners meet
FOLDER.mkdir(parents=True, exist_ok=True)
meshio.Mesh(points.reshape(-1, 3), [("triangle", faces)]).write(FOLDER / "bowl.stl")

# the scene
bowl = tc.Sdf.from_surface(FOLDER / "bowl.stl", cells=GRID, name="bowl", friction=tc.Coulomb(0.3))
mesh = tc.ball_mesh(0.025, CELLS, center=(0.05, 0.0, 0.06))
ball = tc.Body(
    mesh, tc.NeoHookean(young=2e6, poisson=0.45, density=1100.0), velocity=(0, 0, -1.0), contact="surface", name="ball"
)
scene = tc.Scene([ball], [bowl], duration=DURATION, gravity=(0.0, 0.0, -9.81))
result = tc.simulate(scene, out=FOLDER / "run", frames=60)
print(result)

history = result.history
print(f"largest force {np.linalg.norm(history['contact_force'], axis=1).max():.1f} N")
print(f"smallest gap {history['gap_min'].min():.1e} m")
print(f"the ball leaves with {np.linalg.norm(history['momentum'][-1]) / (1100.0 * mesh.cell_volumes().sum()):.2f} m/s")
print(f"largest energy error {history['energy_error'].max():.1e}")
