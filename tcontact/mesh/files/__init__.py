"""Mesh files: Gmsh, VTU and Abaqus, read into a `Mesh`."""
