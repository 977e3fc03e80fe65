"""Rigid obstacles. The gap is the signed distance to them, open positive; the normal points into the body."""

from .base import Obstacle
from .box import Box
from .cylinder import Cylinder
from .plane import Plane
from .sdf import Sdf
from .sphere import Sphere

__all__ = ["Box", "Cylinder", "Obstacle", "Plane", "Sdf", "Sphere"]
