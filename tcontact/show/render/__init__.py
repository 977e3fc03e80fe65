"""Pictures of a result: surface frames coloured by a field, an animation, the contact face where it is pressed most.

How it works. `surface` takes the faces that belong to one cell only and cuts them into triangles; `camera` places the
eye so that everything that moves, as `extent` finds it, stays in the picture; `planes` and `solids` add the obstacles.
`studio` projects and lights all triangles and hands them to a z-buffer (`kernels/pictures/raster.py`), in which the
nearer point wins pixel by pixel, so that bodies that touch never show through one another. `labels` writes title, time
and the colour bar, `bodies` the names of several bodies; `shots` draws the pictures one after another and `png` stores
them meanwhile; `animation` joins them to a GIF, and to an MP4 where imageio-ffmpeg is installed. Values are never
smoothed: cell values are one colour a face, nodal values run linearly between the nodes.

No display is needed: triangles go through `kernels/pictures/raster.py`, text through pillow.
"""

from .camera import Camera
from .series import render_frames, render_picture
from .surface import Clip

__all__ = ["Camera", "Clip", "render_frames", "render_picture"]
