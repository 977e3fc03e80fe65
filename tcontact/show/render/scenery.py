"""The scenery of a series of pictures: its obstacles around the bodies, where they are at a time, and their names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .camera import Eye, Signs
from .planes import Patch, read_planes
from .solids import Pose, hides, outlined, read_solids, shaded
from .triangles import Triangles


class Scenery:
    """The obstacles of a series as its file describes them: planes (point, normal), their poses, and solids."""

    def __init__(self, described: Sequence[Mapping[str, Any]]) -> None:
        self.planes, self.solids = read_planes(described), read_solids(described)
        flat = [one.get("kind") == "plane" for one in described]
        self.poses = [Pose.read(one, index) for index, one in enumerate(described) if flat[index]]
        names = names_of_obstacles(described)
        self.plane_names = [name for name, plane in zip(names, flat, strict=True) if plane]
        self.solid_names = [name for name, plane in zip(names, flat, strict=True) if not plane]

    def around(self, body: np.ndarray, back: np.ndarray, times: np.ndarray) -> Placed:
        """Return the parts that are drawn around points of the bodies [k,3]; back [3]: direction to the eye."""
        patches, in_front = [], []
        for number, (point, normal) in enumerate(self.planes):
            patches.append(Patch.under(body, point, normal, shadowed=number == 0))
            in_front.append(bool(normal @ back > 0))
        return Placed(self, body, patches, in_front, (times[0], times[-1]) if len(times) else (0.0, 0.0))


@dataclass(frozen=True)
class Placed:
    """The scenery around the bodies: a disc of each plane, which is in front of the eye or seen from behind.

    times [s]: first and last of the series.
    """

    scenery: Scenery
    body: np.ndarray
    patches: list[Patch]
    in_front: list[bool]
    times: tuple[float, float]

    @property
    def centre(self) -> np.ndarray:
        """Middle of the bodies [m]."""
        return np.asarray(0.5 * (self.body.min(axis=0) + self.body.max(axis=0)))

    @property
    def radius(self) -> float:
        """Half the diagonal of a box around the bodies [m]."""
        return 0.5 * float(np.linalg.norm(np.ptp(self.body, axis=0)))

    def shown(self) -> np.ndarray:
        """Return points [k,3] that the picture must hold: those of the bodies and of the scenery near them."""
        points = [self.body]
        points += [disc.rim(0.72 if front else 0.8) for disc, front in zip(self.patches, self.in_front, strict=True)]
        for solid in self.scenery.solids:
            for time in self.times:
                found, _ = solid.mesh(time, self.centre, self.radius)
                points.append(found[np.linalg.norm(found - self.centre, axis=1) < 1.3 * self.radius])
        return np.concatenate(points)

    def before(self, eye: Eye, unit: float) -> Eye:
        """Return the eye with this scenery, which follows the time where obstacles move; unit: of the layout [pixel].

        The eye's own scenery, which is no obstacle, stays.
        """
        solids, fixed, body = self.scenery.solids, eye.fixed, eye.project(self.body)
        centre, radius = self.centre, self.radius
        hiding = [hides(solid.mesh(self.times[0], centre, radius), eye, self.body) for solid in solids]
        every = (*self.scenery.plane_names, *self.scenery.solid_names)

        def at(eye: Eye, time: float) -> Eye:
            parts, shadow, places = [fixed], None, []
            for number, (disc, front, pose) in enumerate(
                zip(self.patches, self.in_front, self.scenery.poses, strict=True)
            ):
                there = disc.carried(pose, time)
                places.append(there.tiles(eye))
                parts.append(places[-1] if front else there.outline(eye, unit))
                if number == 0 and front:
                    shadow = there.centre, np.cross(there.first, there.second)
            for solid, hidden in zip(solids, hiding, strict=True):
                mesh = solid.mesh(time, centre, radius)
                places.append(shaded(mesh, eye))
                parts.append(outlined(mesh, eye, unit) if hidden else places[-1])
            signs = Signs(every, tuple(places), body) if any(every) else None
            return replace(eye, fixed=Triangles.joined(parts), shadow=shadow, moving=None, signs=signs)

        moving = any(pose.moves for pose in (*(solid.pose for solid in solids), *self.scenery.poses))
        return replace(eye, moving=at) if moving else at(eye, 0.0)


def names_of_obstacles(described: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what is written on each obstacle: its name; of several without one the label of its history; else ""."""
    return [
        str(one.get("name") or (f"obstacle-{number}" if len(described) > 1 else ""))
        for number, one in enumerate(described)
    ]
