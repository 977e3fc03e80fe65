"""Gap queries: an obstacle sampled from a closed surface of five thousand triangles against the exact shape."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from ...contact.obstacles import Obstacles
from ...device import arrays, runtime
from ...device.launch import Prepared
from ...scene.obstacles import Obstacle, Sdf, Sphere
from ...scene.scene import Scene
from . import blocks, timing

RADIUS, CELLS, POINTS, ROUNDS = 0.5, 64, 200_000, 7
RINGS = 51  # rings of triangles, 2 (RINGS - 1) RINGS triangles in all


def queries(arch: str, threads: int) -> dict[str, Any]:
    """Return nanoseconds per query of a sphere and of its sampled surface, and the gap error over the size near it."""
    runtime.start(arch, threads)
    load, surface = timing.load(), triangles()
    started = perf_counter()
    sampled = Sdf.from_surface(surface, cells=CELLS)
    build = perf_counter() - started
    random = np.random.default_rng(1)
    away = random.normal(size=(POINTS, 3))
    away *= (RADIUS * random.uniform(0.9, 1.1, POINTS) / np.linalg.norm(away, axis=1))[:, None]
    rows = []
    for name, obstacle in (("sphere", Sphere(radius=RADIUS)), ("sdf", sampled)):
        seconds, gaps = _timed(obstacle, away)
        exact = np.linalg.norm(away, axis=1) - RADIUS
        rows.append(
            {
                "obstacle": name,
                "ns": timing.spread(1e9 * seconds / POINTS),
                "gap_error": float(np.abs(gaps - exact).max() / (2.0 * RADIUS)),
            }
        )
    return {"triangles": len(surface[1]), "build_s": build, "rows": rows, "load": [load, timing.load()]}


def _timed(obstacle: Obstacle, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the seconds of all queries, by round, and the gaps."""
    from ...kernels.contact.obstacle_queries import make_gaps

    body = blocks.block("hex8", "linear", 2).bodies[0]
    records = Obstacles(Scene([body], [obstacle], duration=1.0), np.zeros(3), 1)
    points, gaps = arrays.put(positions), arrays.zeros(len(positions))
    launch = Prepared(make_gaps(records.shapes))
    taken = []
    for _ in range(ROUNDS + 1):
        started = perf_counter()
        launch(records.records, records.motion, points, gaps)
        runtime.load().sync()
        taken.append(perf_counter() - started)
    return np.array(taken[1:]), np.array(arrays.get(gaps))


def triangles() -> tuple[np.ndarray, np.ndarray]:
    """Return a sphere as points [k, 3] and triangles [m, 3]: rings of halved quads with fans at the poles."""
    polar, turn = np.pi * np.arange(1, RINGS) / RINGS, 2 * np.pi * np.arange(RINGS) / RINGS
    a, b = (part.ravel() for part in np.meshgrid(polar, turn, indexing="ij"))
    around = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=1)
    points = RADIUS * np.concatenate([[[0, 0, 1.0]], around, [[0, 0, -1.0]]])
    ids = 1 + np.arange(len(around)).reshape(RINGS - 1, RINGS)
    after = np.roll(ids, -1, axis=1)
    top = [[0, i, j] for i, j in zip(ids[0], after[0], strict=True)]
    bottom = [[len(points) - 1, j, i] for i, j in zip(ids[-1], after[-1], strict=True)]
    quads = np.stack([ids[:-1], ids[1:], after[1:], after[:-1]], axis=-1).reshape(-1, 4)
    return points, np.concatenate([top, quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], bottom])


def lines(found: list[dict[str, Any]]) -> list[str]:
    """Return the rows of all thread counts as text."""
    text = []
    for part in found:
        if not part["ok"]:
            text.append(f"gap queries, {part['threads']} threads: FAILED: {part['reason']}")
            continue
        for row in part["rows"]:
            text.append(
                f"gap query, {row['obstacle']}, {part['threads']} threads: {row['ns']['median']:.0f} ns, gap error"
                f" {row['gap_error']:.1e} of the size"
                + (
                    f"; {part['triangles']} triangles built in {part['build_s']:.1f} s"
                    if row["obstacle"] == "sdf"
                    else ""
                )
            )
    return text
