"""Meshes: nodes, cells of one kind, named sets.

How it works. `mesh.Mesh` is plain data, checked once (`checks`) and never changed; `geometry` has what follows from
corners and nodes, `box` makes boxes, `files` reads Gmsh, VTU and Abaqus,
`triangle_distance` measures how far two surfaces are apart, `rotation` turns a mesh as a user may write it.
"""

from .mesh import Mesh

__all__ = ["Mesh"]
