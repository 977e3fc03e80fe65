"""Pictures of a result: surface frames coloured by a field, an animation, the contact face at the largest force.

Needs no display: triangles go through `kernels/raster.py`, text through pillow.
"""

from .camera import Camera
from .series import render_frames

__all__ = ["Camera", "render_frames"]
