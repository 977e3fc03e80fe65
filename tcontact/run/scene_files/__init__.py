"""Scenes as TOML files: `load_scene` and `save_scene`.

    duration = 3e-3
    gravity = [0, 0, -9.81]

    [contact]                       # type and options as in Python; contact = "none" for none
    type = "MasslessContact"

    [[bodies]]
    name = "cube"
    velocity = [0, 0, -2.8]
    contact = "auto"
    mesh = { box = [0.1, 0.1, 0.1], cells = [8, 8, 8] }     # or { file = "part.msh", scale = 1e-3 }
                                    # or { ball = { radius = 0.05, cells = 8 } }, so cylinder and ring
    material = { type = "NeoHookean", young = 1e7, poisson = 0.3, density = 1000 }
    supports = [{ set = "zmax", axes = "xy" }]
    loads = [{ set = "xmin", pressure = 1e5 }, { set = "ymax", force = [0, 0, -10] }]
    springs = [{ set = "zmax", stiffness = 1e4, damping = 2, to = ["other", "zmin"] }]

    [[obstacles]]
    type = "Plane"
    point = [0, 0, -1e-3]

    [run]                           # options of `simulate`
    frames = 20
    scheme = { type = "central-difference", cfl = 0.9 }

Keys are the names of the arguments in Python. Tables with several classes to choose from say which by `type`. Arrays
that are long stand in an .npz file beside the TOML: { file = "scene.npz", array = "velocity" }.
"""

from .read import load_scene
from .write import save_scene

__all__ = ["load_scene", "save_scene"]
