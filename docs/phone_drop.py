"""A phone in its case falls on one corner on a shaking floor: python phone_drop.py phone.msh

The mesh [mm] comes from Gmsh, with the physical volumes "case" and "core" and the physical surface "screen".
"""

import sys

import numpy as np

import tcontact as tc

if len(sys.argv) != 2:
    sys.exit("usage: python phone_drop.py phone.msh")
mesh = tc.read_mesh(sys.argv[1], scale=1e-3)
low, high = mesh.bounds
corner = 0.5 * (low - high)  # from the middle to the corner that lands
turn = np.cross(corner, (0.0, 0.0, -1.0)), np.arccos(-corner[2] / np.linalg.norm(corner))
mesh = mesh.rotated(turn)
mesh = mesh.translated((0.0, 0.0, 1e-5 - mesh.bounds[0][2]))
materials = {"case": tc.NeoHookean(2e7, 0.4, 1200.0), "core": tc.NeoHookean(2e10, 0.3, 2400.0)}
felt = tc.Probe("screen", "acceleration")
phone = tc.Body(mesh, materials, velocity=(0.0, 0.0, -3.0), contact="auto", name="phone", probes=[felt])
floor = tc.Plane(velocity=lambda time: (0.0, 0.0, 0.1 * np.sin(2.0 * np.pi * 100.0 * time)))
scene = tc.Scene([phone], [floor], duration=2e-3, gravity=(0.0, 0.0, -9.81), maxima="von_mises")
result = tc.simulate(scene)
print(result)
print("largest acceleration of the screen [m/s^2]", np.abs(result.probes["phone_screen_acceleration"]).max())
print("largest stress of all cells and steps", result.maxima["von_mises"])
