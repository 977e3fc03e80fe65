"""The scenes that are timed: a soft cube, sheared by waves, that presses on a wall from the first step on, or flies."""

from __future__ import annotations

import numpy as np

from ...mesh.box import box_mesh
from ...mesh.mesh import Mesh
from ...scene import materials
from ...scene.body import Body
from ...scene.contact_models import MasslessContact
from ...scene.obstacles import Plane
from ...scene.scene import Scene

LENGTH = 0.1  # [m]
SPEED = 10 / 3.6  # [m/s]
SKEW = np.array([[1.0, 0.1, 0.0], [0.2, 1.1, 0.0], [0.1, -0.1, 0.9]])  # planes z = constant stay such
STRETCH = np.diag([1.0, 1.1, 0.9])
TURNED = np.array([[0.96, 0.28, 0.0], [-0.28, 0.96, 0.0], [0.0, 0.0, 1.0]])
# shape of the cells by kind: another one may have other kernels
FORMS = {"hex8": STRETCH, "hex8-mean-dilatation": STRETCH, "hex8-skew": SKEW, "hex8-turned": TURNED}
YOUNG, POISSON, DENSITY = 1e7, 0.3, 1000.0  # [Pa], [-], [kg/m^3]


def material(law: str) -> materials.Material:
    """Return the soft material of the main case, with the named law."""
    return materials.LAWS[law].of(YOUNG, POISSON, DENSITY)


def block(kind: str, law: str, size: int, contact: str = "none", duration: float = 1e-9) -> Scene:
    """Return a scene: a cube of size^3 hexes (six tets or two prisms for each) flies down, sheared by standing waves.

    contact: "none" = the same cube with nothing in its way, else the removal of its massless contact with a wall that
    it touches at the start.
    """
    cells, formulation = _element(kind)
    mesh = box_mesh(size=(LENGTH,) * 3, cells=(size,) * 3, kind=cells)
    if kind in ("hex8-skew", "hex8-turned"):
        mesh = Mesh(mesh.nodes @ FORMS[kind], mesh.cells, cells, face_sets=mesh.face_sets)
    if kind == "hex8-distorted":
        mesh = Mesh(_moved(mesh.nodes, size), mesh.cells, cells, face_sets=mesh.face_sets)
    touching = contact != "none"
    facing = "zmin" if touching else None
    body = Body(mesh, material(law), _velocity, contact=facing, name="block", formulation=formulation)
    if not touching:
        return Scene(bodies=[body], duration=duration)
    return Scene([body], [Plane()], duration, contact=MasslessContact(removal=contact))


def _element(kind: str) -> tuple[str, str]:
    """Return kind of the mesh and formulation of an element such as "hex8-reduced"."""
    cells, _, variant = kind.partition("-")
    return cells, variant if variant in ("reduced", "mean-dilatation") else "full"


def _moved(nodes: np.ndarray, size: int) -> np.ndarray:
    """Return the nodes with the inner ones at random places up to 0.1 of a cell away."""
    inner = (np.abs(nodes - 0.5 * LENGTH) < (0.5 - 1e-9) * LENGTH).all(axis=1)
    away = np.random.default_rng(1).uniform(-0.1, 0.1, nodes.shape) * LENGTH / size
    return nodes + away * inner.reshape(-1, 1)


def _velocity(nodes: np.ndarray) -> np.ndarray:
    wave = np.cos(np.pi * nodes / LENGTH)[:, [1, 2, 0]]
    return 0.5 * SPEED * wave - SPEED * np.array([0.0, 0.0, 1.0])


def shaken(kind: str, law: str, size: int, seed: int = 0) -> tuple[Scene, np.ndarray]:
    """Return a cube of cells in the form of their kind (FORMS), or shaken by 0.15 of a cell, and random displacements.

    Displacements [n, 3] [m]. Kinds of a form are timed on boxes or parallelepipeds, whose kernels are other ones.
    """
    random = np.random.default_rng(seed)
    h = LENGTH / size
    cells, formulation = _element(kind)
    box = box_mesh(size=(LENGTH,) * 3, cells=(size,) * 3, kind=cells)
    nodes = box.nodes @ FORMS.get(kind, SKEW)
    if kind not in FORMS:
        nodes = nodes + 0.15 * h * random.uniform(-1.0, 1.0, box.nodes.shape)
    body = Body(Mesh(nodes, box.cells, cells), material(law), name="shaken", formulation=formulation)
    return Scene([body], duration=1.0), 0.05 * h * random.uniform(-1.0, 1.0, box.nodes.shape)
