"""Figures of independent code for the impacts of the hard cases: impulse and mean time of the force on every wall.

The figures come from the plain numpy code in tests/oracle, which shares no code with this package: its own mass
redistribution, internal forces, leapfrog, and a dense active-set Newton method for the contact problem. It was run on
the meshes of the cases with its own stable step by

    python tests/hard_references.py            (sizes of the test suite)
    python tests/hard_references.py --full     (full sizes, slow)

on 2026-11-22; tests/test_hard_references.py runs some again. Both codes solve the same discrete equations, so what may
differ is what the step, the choice of the removed mass and the tolerance of the static solve change: TOLERANCE. For
comparison: .7 of the modulus delays the force by a fifth of the contact time.
"""

from __future__ import annotations

import numpy as np

from ....results import checks as ck
from ....results.result import Result

TOLERANCE = 0.04

UNTIL = {"80-bounces": 5e-3}  # [s]: the first contact, before small differences grow
RUNS = {"80-bounces": 2, "spinning-cube": 1, "random-rotation": 1}  # how many runs are compared, all if not named

# by case and number of cells: for every run, for every wall, impulse [N s], mean time [s] and width [s] of the force
IMPULSES: dict[str, dict[int, list[list[tuple[float, float, float]]]]] = {
    "nu-0.49-normal": {64: [[(3.4052, 0.00094168, 0.0003694)]], 512: [[(3.2427, 0.00090996, 0.0003648)]]},
    "nu-0.49-full": {
        64: [[(3.0527, 0.00088403, 0.0003248)], [(3.4052, 0.00094168, 0.0003694)]],
        512: [[(2.9485, 0.00085849, 0.0003428)], [(3.2427, 0.00090996, 0.0003648)]],
    },
    "nu-0.499-normal": {64: [[(3.5735, 0.00092912, 0.0004039)]], 512: [[(3.1688, 0.00087417, 0.0003967)]]},
    "nu-0.499-full": {
        64: [[(3.4219, 0.00091543, 0.0003994)], [(3.5735, 0.00092912, 0.0004039)]],
        512: [[(2.9558, 0.00083256, 0.0003779)], [(3.1688, 0.00087417, 0.0003967)]],
    },
    "nu-0.4999-normal": {64: [[(3.4866, 0.00089727, 0.0004077)]], 512: [[(3.4109, 0.00088404, 0.0004064)]]},
    "nu-0.4999-full": {
        64: [[(3.6213, 0.00092684, 0.0004211)], [(3.4866, 0.00089727, 0.0004077)]],
        512: [[(3.0733, 0.00080691, 0.000362)], [(3.4109, 0.00088404, 0.0004064)]],
    },
    "thin-surface-layer": {
        64: [[(3.6677, 0.0013998, 0.0005752)], [(3.6791, 0.0014026, 0.0005772)]],
        512: [[(3.5985, 0.0013935, 0.0005514)], [(3.596, 0.0013926, 0.0005508)]],
    },
    "jittered-tets": {
        384: [[(3.706, 0.0014679, 0.0005433)], [(3.6843, 0.0014638, 0.0005455)]],
        3072: [[(3.6219, 0.001414, 0.0005366)], [(3.617, 0.0014126, 0.000536)]],
    },
    "sliver-tets": {
        384: [[(3.6966, 0.0014584, 0.0005465)], [(3.6832, 0.0014562, 0.0005503)]],
        3072: [[(3.6223, 0.0014135, 0.0005363)], [(3.6224, 0.0014138, 0.0005372)]],
    },
    "tets-all-in-contact-set": {
        162: [[(3.8912, 0.0013263, 0.0003851), (4.0357, 0.0013199, 0.0003786), (3.8912, 0.0013263, 0.0003851)]],
        1296: [[(3.706, 0.0011762, 0.0003514), (3.7388, 0.0011737, 0.0003511), (3.706, 0.0011762, 0.0003514)]],
    },
    "two-cells": {
        2: [
            [(0.96398, 0.0015971, 0.0005335)],
            [(0.97412, 0.0016088, 0.0005444)],
            [(0.96523, 0.0012672, 0.0004142)],
            [(0.91908, 0.0012063, 0.0003585)],
        ]
    },
    "corner-first": {64: [[(5.5556, 0.0057073, 0.002279)]], 512: [[(5.5521, 0.0062376, 0.002156)]]},
    "edge-first": {64: [[(5.5211, 0.0025251, 0.0009652)]], 512: [[(5.4823, 0.0027371, 0.001053)]]},
    "oblique-25": {64: [[(3.3759, 0.0022955, 0.0008732)]], 512: [[(3.5837, 0.0025964, 0.001007)]]},
    "spinning-cube": {64: [[(18.109, 0.0031264, 0.0007869)]], 512: [[(18.65, 0.0030001, 0.0006503)]]},
    "two-walls": {
        128: [[(2.4965, 0.0034199, 0.002481), (1.5842, 0.0045089, 0.001799)]],
        1024: [[(2.3598, 0.0032612, 0.002441), (1.4569, 0.0043238, 0.001669)]],
    },
    "three-walls": {
        64: [[(5.3721, 0.0011105, 0.0003683), (5.3721, 0.0011105, 0.0003683), (5.3721, 0.0011105, 0.0003683)]],
        512: [[(5.0884, 0.0010175, 0.0003527), (5.0884, 0.0010175, 0.0003527), (5.0884, 0.0010175, 0.0003527)]],
    },
    "step-0.99": {
        64: [[(5.1547, 0.001327, 0.0005428)], [(5.1372, 0.0013156, 0.0005373)]],
        512: [[(5.0088, 0.0012743, 0.0005379)], [(4.9941, 0.0012639, 0.0005325)]],
    },
    "step-above-limit": {64: [[(5.1577, 0.0013277, 0.0005431)]], 512: [[(5.0088, 0.0012743, 0.0005378)]]},
    "80-bounces": {100: [[(0.70902, 0.0013039, 0.0005403)], [(0.70914, 0.0013042, 0.0005404)]]},
    "random-rotation": {64: [[(1.3008, 0.002899, 0.0008095)]], 512: [[(1.0968, 0.0029572, 0.0007664)]]},
}

STABLE = (0.97, 1.0)  # the stable step that the program states, in multiples of the true one

# by case and number of cells: the largest stable step [s], 2/omega of the free body with all its mass
STABLE_STEPS: dict[str, dict[int, float]] = {
    "step": {64: 0.0002064, 512: 0.00010377},
    "sliver-tets-extreme": {384: 1.64978e-06},
}


def figures(time: np.ndarray, force: np.ndarray, normals: list[np.ndarray], until: float) -> np.ndarray:
    """Return impulse [N s], mean time [s] and width [s] of the force on every wall [p, 3], up to the time `until` [s].

    force [s, 3]: total contact force in rows. The walls push along directions that are normal or opposite to each
    other, so the total tells them apart. Mean and width: first moment and standard deviation of the force in time.
    """
    steps, middle = np.diff(time), 0.5 * (time[1:] + time[:-1])
    found = []
    for normal in normals:
        pushed = np.maximum(force @ normal, 0.0)
        given = 0.5 * (pushed[1:] + pushed[:-1]) * steps
        moments = [np.interp(until, time, np.append(0.0, np.cumsum(given * middle**power))) for power in range(3)]
        impulse = moments[0] if moments[0] > 0.0 else np.nan  # nothing pushed: no check passes
        mean = moments[1] / impulse
        found.append((impulse, mean, np.sqrt(np.maximum(0.0, moments[2] / impulse - mean**2))))
    return np.array(found)


def against(name: str, results: list[Result]) -> list[ck.Check]:
    """Check impulse and mean time of the force on every wall against the independent figures: the worst of the runs."""
    cells = results[0].scene.bodies[0].mesh.cell_count
    wanted = np.array(IMPULSES[name][cells])
    compared = results[: RUNS.get(name)]
    assert len(compared) == len(wanted)
    found = np.array([measured(result, UNTIL.get(name)) for result in compared])
    impulse = np.abs(found[..., 0] / wanted[..., 0] - 1.0).max()
    late = (np.abs(found[..., 1] - wanted[..., 1]) / wanted[..., 2]).max()
    return [
        ck.at_most("impulse against independent code, error", impulse, TOLERANCE),
        ck.at_most("mean time of the force against independent code, error over its width", late, 2.0 * TOLERANCE),
    ]


def measured(result: Result, until: float | None = None) -> np.ndarray:
    """Return the figures of a result [p, 3], up to the end that its scene asks for if no earlier time is given."""
    history, scene = result.history, result.scene
    normals = [np.asarray(obstacle.frame[2]) for obstacle in scene.obstacles]
    return figures(history["time"], history["contact_force"], normals, until or scene.duration)


def stable_step(name: str, results: list[Result]) -> ck.Check:
    """Check the stable step that the program states for the first run, over that of the independent code."""
    first = results[0]
    wanted = STABLE_STEPS[name][first.scene.bodies[0].mesh.cell_count]
    return ck.between("stable step as stated / of independent code", first.dt_limit / wanted, *STABLE)


def against_plane_wave(results: list[Result], *gaps: float) -> list[ck.Check]:
    """Check the bar of the case bar-impact against its exact solution: impulse 2 m v, mean time L/c after the touch.

    gaps [m]: of the runs, one for all of them if only one is given. The errors are of first order in the cell size.
    """
    length, density, speed, wave = 0.1, 1000.0, 10 / 3.6, 100.0
    touch, transit = np.broadcast_to(gaps, len(results)) / speed, length / wave
    impulse = 2.0 * density * length * (length / 8.0) ** 2 * speed
    bound = 1.0 / results[0].scene.bodies[0].mesh.cell_count
    found = np.array([measured(result)[0] for result in results])
    return [
        ck.at_most("impulse against 2 m v, error", np.abs(found[:, 0] / impulse - 1.0).max(), bound),
        ck.at_most(
            "mean time of the force against L/c, error", np.abs((found[:, 1] - touch) / transit - 1.0).max(), bound
        ),
    ]
