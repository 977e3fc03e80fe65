"""Meshes: nodes, cells of one or several kinds, named sets.

How it works. `mesh.Mesh` is plain data, checked once (`checks`) and never changed. `elements` holds one record with all
facts of a kind of cell; `geometry` computes what follows from corners and nodes, `box` makes boxes (`box_arrays`),
`round` makes rings, cylinders and balls of `mapped` blocks, `files` reads Gmsh, VTU and Abaqus, `triangle_distance`
measures how far two surfaces are apart, `hull_overlap` how deep cells overlap, `rotation` turns a mesh as a user may
write it, and `mixed_cells` puts cells of several kinds into rows of one length.
"""

from .mesh import Mesh

__all__ = ["Mesh"]
