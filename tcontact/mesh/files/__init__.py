"""Meshes from files: Gmsh, VTU and Abaqus."""
