"""The surface of a run in all frames, with its fields, and its obstacles, as a page shows them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...results.stored import StoredResult
from ..render.colours import FIELDS, colour_map, colour_table
from ..render.planes import Patch
from ..render.solids import Pose
from ..render.studio import Studio
from .packed import packed, text_of

FRAMES = 60  # shown at most
ROOM = 6_000_000  # bytes of positions and fields of all frames
FACES = 250_000  # of a surface that a page can turn


def studio_of(result: StoredResult) -> Studio:
    """Return what knows surface, fields and obstacles of a run."""
    return Studio(result.frames, (160, 120), 1.0, None)


def chosen_frames(studio: Studio) -> list[int]:
    """Return the numbers of the frames that a page shows: all, or evenly spread ones, the last among them."""
    surface = studio.surface
    numbers = (3 + len(studio.data.point_fields)) * len(surface.nodes)
    size = 2 * (numbers + len(studio.data.cell_fields) * len(surface.owner))
    count = min(len(studio.data), FRAMES, max(2, ROOM // size))
    return sorted({round(number) for number in np.linspace(0, len(studio.data) - 1, count)})


def surface_of(studio: Studio, frames: list[int]) -> dict[str, Any] | None:
    """Return triangles, edges, positions and fields of the frames, and obstacles; None if there are too many faces."""
    surface = studio.surface
    if len(surface.owner) > FACES:
        return None
    quads, triangles = surface.quads, surface.triangles
    corners = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], triangles])
    faces = np.concatenate([np.tile(np.arange(len(quads)), 2), len(quads) + np.arange(len(triangles))])
    sides = [quads[:, [k, (k + 1) % 4]] for k in range(4)] + [triangles[:, [k, (k + 1) % 3]] for k in range(3)]
    edges = np.unique(np.sort(np.concatenate(sides), axis=1), axis=0)
    body = studio.extent(studio.frame(index) for index in frames)  # without frames of a body blown up
    low, high = body.min(axis=0), body.max(axis=0)
    positions = [np.nan_to_num(studio.positions(studio.frame(index))) for index in frames]
    middle, reach = 0.5 * (low + high), 0.5 * float(np.max(high - low))
    times = [float(studio.data.times[index]) for index in frames]
    return {
        "nodes": len(surface.nodes),
        "corners": text_of(corners, "i4"),
        "faces": text_of(faces, "i4"),
        "edges": text_of(edges, "i4"),
        "middle": middle.tolist(),
        "reach": reach,
        "up": (studio.scenery.planes[0][1] if studio.scenery.planes else np.array([0.0, 0.0, 1.0])).tolist(),
        "positions": [packed((x - middle) / reach, -1.0, 1.0)["data"] for x in positions],
        "fields": [_field(studio, name, frames) for name in field_names(studio)],
        "obstacles": _obstacles(studio, np.array([low, high]), middle, reach, times),
    }


def field_names(studio: Studio) -> list[str]:
    """Return the fields that can be shown, the stress first."""
    names = [*studio.data.cell_fields, *studio.data.point_fields]
    return sorted(names, key=lambda name: (name != "von_mises", name == "body", names.index(name)))


def _field(studio: Studio, name: str, frames: list[int]) -> dict[str, Any]:
    title, unit, _ = FIELDS.get(name, (name.replace("_", " ").capitalize(), "", ""))
    low, high = studio.limits(name)
    found = [studio.values(studio.frame(index), name) for index in frames]
    return {
        "name": title,
        "unit": unit,
        "nodal": found[0][1],
        "low": low,
        "high": high,
        "bodies": studio.names if name == "body" else [],
        "colours": text_of(colour_table(colour_map(name)), "u2"),
        "frames": [packed(values, low, high)["data"] for values, _ in found],
        "peaks": [float(np.max(values, initial=0.0, where=np.isfinite(values))) for values, _ in found],
    }


def _obstacles(
    studio: Studio, box: np.ndarray, middle: np.ndarray, reach: float, times: list[float]
) -> list[dict[str, Any]]:
    """Return points and triangles of each obstacle at the first frame, and where it is at each, as 4x4 matrices.

    box: lowest and highest corner of what the bodies pass through [2, 3].
    """
    body = np.array([[box[x, 0], box[y, 1], box[z, 2]] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    found = []
    for (point, normal), pose in zip(studio.scenery.planes, studio.scenery.poses, strict=True):
        patch = Patch.under(body, point, normal, shadowed=False)
        ends = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * 0.8 * patch.radius
        found.append(_obstacle(patch.at(*ends.T), np.array([[0, 1, 2], [0, 2, 3]]), pose, times, middle, reach))
    for solid in studio.scenery.solids:
        points, triangles = solid.mesh(times[0], middle, 1.5 * reach)
        found.append(_obstacle(points, triangles, solid.pose, times, middle, reach))
    return found


def _obstacle(
    points: np.ndarray, triangles: np.ndarray, pose: Pose, times: list[float], middle: np.ndarray, reach: float
) -> dict[str, Any]:
    start, axes = pose.at(times[0])
    places = []
    for time in times if pose.moves else times[:1]:
        point, frame = pose.at(time)
        turn = axes.T @ frame  # rows of vectors at the first frame to those now
        shift = (point - middle) / reach - ((start - middle) / reach) @ turn
        places.append(np.block([[turn.T, shift[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]]).ravel().tolist())
    scaled = (points - middle) / reach
    return {"points": text_of(scaled, "f8"), "corners": text_of(triangles, "i4"), "places": places}
