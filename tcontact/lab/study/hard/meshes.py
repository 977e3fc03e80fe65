"""Meshes that are hard on mass redistribution: thin layers, slivers, cells or bodies with nothing but contact nodes."""

from __future__ import annotations

import numpy as np

import tcontact as tc

from ....results import checks as ck
from ..hard_cases import HardCase, Run, nothing, sound
from .references import against, stable_step

SIZE, SPEED = 0.1, 2.0
RUBBER = tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0)
REFUSED = nothing("redistribution refuses the contact set of the mesh before anything runs", but="method")


def cases() -> list[HardCase]:
    """Return the cases: meshes."""
    return [
        HardCase(
            "thin-surface-layer",
            "the layer of cells at the contact face is ten times thinner",
            lambda full: [Run(_impact(thin_layer(8 if full else 4), removal=r)) for r in ("normal", "full")],
            lambda results: [*against("thin-surface-layer", results), *sound(results)],
        ),
        HardCase(
            "jittered-tets",
            "tetrahedra with nodes shaken by a quarter of a cell",
            lambda full: [Run(_impact(jittered(8 if full else 4), removal=r)) for r in ("normal", "full")],
            lambda results: [*against("jittered-tets", results), *sound(results)],
        ),
        HardCase(
            "sliver-tets",
            "a node at the contact face nearly in the plane of its cell: volume 1/50",
            lambda full: [Run(_impact(sliver(8 if full else 4), removal=r)) for r in ("normal", "full")],
            lambda results: [*against("sliver-tets", results), *sound(results)],
        ),
        HardCase(
            "sliver-tets-extreme",
            "volume 1/10000: in one step the node above flies through the whole cell; only a smaller step could help",
            lambda full: [Run(_impact(sliver(4, 1e-4), removal="normal"))],
            lambda results: sound(results),
            expected=("right", "stopped"),
            says="lower cfl",
            remedy="a better mesh, or a smaller step",
            judge_stopped=lambda results: [
                stable_step("sliver-tets-extreme", results),
                ck.at_least("time of the stop / time of touch", results[0].time / (1e-3 / SPEED), 1.0),
            ],
            cannot_feel={
                "method": "in one step the node flies through its cell, however the contact is resolved",
                "duration": "it stops within two steps of the touch, in the first half",
            },
        ),
        HardCase(
            "tets-all-in-contact-set",
            "corner tetrahedra whose every node is a contact node: no neighbour of the cell takes the mass",
            lambda full: [Run(_corner_tets(6 if full else 3))],
            lambda results: [*against("tets-all-in-contact-set", results), *sound(results, momentum=1e-6)],
        ),
        HardCase(
            "plate-both-faces",
            "a plate one cell thick with both faces in the contact set: no node has mass left",
            lambda full: [Run(_plate(16 if full else 6))],
            lambda results: sound(results),
            expected=("refused",),
            says="make the contact set smaller (only the faces that can touch) or the mesh finer",
            remedy="contact set of one face, or two cells through the thickness",
            cannot_feel=REFUSED,
        ),
        HardCase(
            "two-cells",
            "a body of two hexes, standing and lying, normal and full removal",
            lambda full: [
                Run(_impact(tc.box_mesh((SIZE / 2, SIZE / 2, SIZE), (1, 1, 2)), removal="normal")),
                Run(_impact(tc.box_mesh((SIZE / 2, SIZE / 2, SIZE), (1, 1, 2)), removal="full")),
                Run(_impact(tc.box_mesh((SIZE, SIZE / 2, SIZE / 2), (2, 1, 1)), removal="normal")),
                Run(_impact(tc.box_mesh((SIZE, SIZE / 2, SIZE / 2), (2, 1, 1)), removal="full")),
            ],
            lambda results: [*against("two-cells", results), *sound(results, energy=0.25)],  # O(h), with so few cells
        ),
        HardCase(
            "hinged-contact-nodes",
            "full removal where the contact nodes have only two neighbours with mass: they can turn about them",
            lambda full: [Run(_wedge())],
            lambda results: sound(results, energy=0.25),
            expected=("refused",),
            says="removal='normal'",
            remedy="removal='normal' or a finer mesh",
            cannot_feel=REFUSED,
        ),
    ]


def _impact(mesh: tc.Mesh, *, removal: str = "auto", contact: str = "zmin") -> tc.Scene:
    """Return a scene: the mesh flies down onto the plane z = 0 from 1 mm."""
    mesh = mesh.translated((0.0, 0.0, 1e-3 - mesh.nodes[:, 2].min()))
    body = tc.Body(mesh, RUBBER, velocity=(0.0, 0.0, -SPEED), contact=contact)
    return tc.Scene([body], [tc.Plane()], duration=3e-3, contact=tc.MasslessContact(removal=removal))


def _moved(mesh: tc.Mesh, nodes: np.ndarray) -> tc.Mesh:
    return tc.Mesh(nodes, mesh.cells, mesh.kind, face_sets=mesh.face_sets)


def thin_layer(n: int) -> tc.Mesh:
    """Return a cube of n^3 hexes whose lowest layer is a tenth as high as the others."""
    mesh = tc.box_mesh((SIZE,) * 3, (n,) * 3)
    levels = np.concatenate([[0.0], np.linspace(0.1 / (n - 0.9), 1.0, n)]) * SIZE
    nodes = np.array(mesh.nodes)
    nodes[:, 2] = levels[np.round(nodes[:, 2] / SIZE * n).astype(int)]
    return _moved(mesh, nodes)


def jittered(n: int) -> tc.Mesh:
    """Return a cube of tetrahedra; inner nodes are shaken, those on faces only within them."""
    mesh = tc.box_mesh((SIZE,) * 3, (n,) * 3, kind="tet4")
    nodes = np.array(mesh.nodes)
    shake = 0.25 * SIZE / n * np.random.default_rng(4).uniform(-1.0, 1.0, nodes.shape)
    shake[(nodes < 1e-9) | (nodes > SIZE - 1e-9)] = 0.0
    return _moved(mesh, nodes + shake)


def sliver(n: int, share: float = 0.02) -> tc.Mesh:
    """Return a cube of tetrahedra; a node above the contact face comes down until a cell has this volume share."""
    mesh = tc.box_mesh((SIZE,) * 3, (n,) * 3, kind="tet4")
    nodes, h = np.array(mesh.nodes), SIZE / n
    node = int(np.argmin(np.linalg.norm(nodes - (SIZE / 2, SIZE / 2, h), axis=1)))
    nodes[node, 2] = share * h
    return _moved(mesh, nodes)


def _corner_tets(n: int) -> tc.Scene:
    """Return a cube of tetrahedra with contact on three faces that meet where cells have all four nodes on them."""
    mesh = tc.box_mesh((SIZE,) * 3, (n,) * 3, kind="tet4", origin=(1e-3, -1e-3 - SIZE, 1e-3))
    names = ["xmin", "ymax", "zmin"]
    inside = np.zeros(mesh.node_count, dtype=bool)
    inside[mesh.nodes_of(names)] = True
    assert inside[mesh.cells].all(axis=1).any(), "the mesh shall have cells with contact nodes only"
    body = tc.Body(mesh, RUBBER, velocity=(-SPEED, SPEED, -SPEED), contact=names)
    walls = [tc.Plane(normal=normal) for normal in ((1, 0, 0), (0, -1, 0), (0, 0, 1))]
    return tc.Scene([body], walls, duration=3e-3)


def _plate(n: int) -> tc.Scene:
    mesh = tc.box_mesh((SIZE, SIZE, SIZE / n), (n, n, 1), origin=(0.0, 0.0, 1e-3))
    body = tc.Body(mesh, RUBBER, velocity=(0.0, 0.0, -SPEED), contact=["zmin", "zmax"])
    walls = [tc.Plane(), tc.Plane(point=(0, 0, SIZE / n + 2e-3), normal=(0, 0, -1))]
    return tc.Scene([body], walls, duration=3e-3)


def _wedge() -> tc.Scene:
    """Return two hexes side by side; bottom and both end faces touch: above stand only the nodes of the middle line."""
    mesh = tc.box_mesh((SIZE, SIZE / 2, SIZE / 2), (2, 1, 1), origin=(-SIZE / 2, 0.0, 1e-3))
    body = tc.Body(mesh, RUBBER, velocity=(0.0, 0.0, -SPEED), contact=["zmin", "xmin", "xmax"])
    return tc.Scene([body], [tc.Plane()], duration=3e-3, contact=tc.MasslessContact(removal="full"))
