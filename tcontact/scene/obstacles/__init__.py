"""Rigid obstacles. The gap is the signed distance to them, open positive; the normal points into the body.

How it works. An obstacle is a shape in a frame of its own: `gap` and `normal_at` on the host are the formulas that
`kernels/contact/obstacle_shapes.py` evaluates for every contact node. A `Sdf` holds distances on a grid, sampled from a
formula or from a closed surface (`surface`, read by `wavefront` and `polygons`; `surface_distance`, `winding`), and
interpolates between them. `motion` turns velocity and angular velocity, numbers or functions of time, into poses. The
bodies feel the surface speed of moving obstacles, and the history has force, moment and power of each of them.
"""

from .base import Obstacle
from .box import Box
from .cylinder import Cylinder
from .plane import Plane
from .sdf import Sdf
from .sphere import Sphere

__all__ = ["Box", "Cylinder", "Obstacle", "Plane", "Sdf", "Sphere"]
