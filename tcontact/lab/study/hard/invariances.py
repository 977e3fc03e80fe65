"""Invariances: units, the direction of the wall, the numbering of nodes and cells, and float32 must not matter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import tcontact as tc
from tcontact.cases import cube_impact

from ....results import checks as ck
from ....results.result import Result
from ..hard_cases import HardCase, Run, sound
from .references import against

STEP = 8e-5  # step [s] for 4^3 cells, inside the stable one; halved with the size of the cells


def cases() -> list[HardCase]:
    """Return the cases: the same impact twice."""
    return [
        HardCase(
            "millimetres-and-tonnes",
            "the same impact in mm, t, s: stiffness, mass and length differ by powers of ten, the answer must not",
            lambda full: [_run(full), _millimetres(full)],
            lambda results: [_same(results, scale=1e3), *_right(results)],
        ),
        HardCase(
            "random-rotation",
            "mesh, velocity and wall turned by a random rotation",
            lambda full: [_run(full), _turned(full)],
            lambda results: [_same(results, turn=rotation()), *_right(results)],
        ),
        HardCase(
            "renumbering",
            "nodes and cells in random order",
            lambda full: [_run(full), _renumbered(full)],
            lambda results: [
                _same(results, order=_order(results[0].scene.bodies[0].mesh.node_count)),
                *_right(results),
            ],
        ),
        HardCase(
            "drop-in-f32-against-f64",
            "the same drop in mixed precision: float32 cells on float64 differences",
            lambda full: [_run(full), replace(_run(full), precision="mixed")],
            lambda results: [
                ck.equals("runs in mixed precision", sum(one.precision == "mixed" for one in results), 1),
                _same(results, bound=1e-6),
                _rounding("contact force", results, "contact_force"),
                _rounding("energy", results, "energy"),
                *_right(results),
                *sound(results[1:], energy=0.02),
            ],
        ),
    ]


def _scene(full: bool) -> tc.Scene:
    return cube_impact.scene(
        cells=8 if full else 4, removal="full", yaw=20.0, pitch=35.0, tolerance=1e-11, duration=4e-3
    )


def _scheme(full: bool) -> tc.CentralDifference:
    return tc.CentralDifference(dt=STEP / (2 if full else 1))


def _run(full: bool) -> Run:
    return Run(_scene(full), _scheme(full))


def _millimetres(full: bool) -> Run:
    scene = _scene(full)
    (body,) = scene.bodies
    soft = tc.NeoHookean(body.material.young * 1e-6, body.material.poisson, body.material.density * 1e-12)
    small = replace(body, mesh=body.mesh.scaled(1e3), material=soft, velocity=tuple(1e3 * v for v in body.velocity))
    return Run(replace(scene, bodies=[small]), _scheme(full))


def rotation() -> np.ndarray:
    """Return a random rotation [3, 3], always the same."""
    q, r = np.linalg.qr(np.random.default_rng(11).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return np.asarray(q * np.sign(np.linalg.det(q)))


def _turned(full: bool) -> Run:
    scene, turn = _scene(full), rotation()
    (body,) = scene.bodies
    turned = replace(body, mesh=body.mesh.rotated(turn), velocity=turn @ body.velocity)
    wall = tc.Plane(point=(0.0, 0.0, 0.0), normal=turn[:, 2])
    return Run(replace(scene, bodies=[turned], obstacles=[wall]), _scheme(full))


def _order(count: int) -> np.ndarray:
    return np.random.default_rng(12).permutation(count)


def _renumbered(full: bool) -> Run:
    """Return the run on a mesh whose node k is node order[k] of the old one."""
    scene = _scene(full)
    (body,) = scene.bodies
    mesh, order = body.mesh, _order(body.mesh.node_count)
    new = np.argsort(order)
    cells = np.random.default_rng(13).permutation(mesh.cell_count)
    sets = {name: new[faces] for name, faces in mesh.face_sets.items()}
    other = tc.Mesh(mesh.nodes[order], new[mesh.cells[cells]], mesh.kind, face_sets=sets)
    return Run(replace(scene, bodies=[replace(body, mesh=other)]), _scheme(full))


def _same(
    results: list[Result],
    scale: float = 1.0,
    turn: np.ndarray | None = None,
    order: np.ndarray | None = None,
    bound: float = 1e-9,
) -> ck.Check:
    """Check the end positions of both runs in the frame of the first, relative to the size of the body."""
    first, second = results
    moved = second.position / scale
    if turn is not None:
        moved = moved @ turn
    if order is not None:
        moved = moved[np.argsort(order)]
    size = first.scene.bodies[0].mesh.size
    pressed = float(first.history["contact_force"].max())
    difference = float(np.abs(moved - first.position).max()) / size
    return ck.at_most("difference of the end positions / size", difference if pressed > 0.0 else np.nan, bound)


def _rounding(name: str, results: list[Result], column: str) -> ck.Check:
    """Check the largest difference of a column between both runs over its largest value: it is that of rounding."""
    first, second = (result.history[column] for result in results)
    if len(first) != len(second):
        return ck.at_most(f"difference of the {name}", np.inf, 1e-5)
    return ck.at_most(f"difference of the {name}", float(np.abs(second - first).max() / np.abs(first).max()), 1e-5)


def _right(results: list[Result]) -> list[ck.Check]:
    """Check what the first of the two must be: two equal runs may be equally wrong."""
    return [*against("random-rotation", results[:1]), *sound(results[:1], energy=0.02, momentum=1e-5)]
