"""Scenes: plain data that checks itself. Nothing is allocated or started here.

How it works. A `Body` (`body`) has a mesh, one of the `materials` or several by region (`cell_blocks`), supports, a
start and contact faces; a `Scene` (`scene`) has bodies, `obstacles`, a way to resolve contact (`contact_models`),
friction (`friction_models`) and dissipation (`dissipation`). `own_laws` makes materials of energies of users.
`periodic` finds the images of periodic bodies, `reach` the faces that may meet an obstacle.
"""

from .body import Body, Support
from .scene import OverlapWarning, Scene

__all__ = ["Body", "OverlapWarning", "Scene", "Support"]
