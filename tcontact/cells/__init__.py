"""Cells: their internal force, the viscosity of contact cells, their stress.

How it works. `internal_force` is one pass over the packed cells of a domain, in blocks of one element and one law;
ordinary nodes are kicked and drift in the same launch. `device_force` does the same on a GPU. `cell_viscosity` damps
the mesh-scale flutter of contact cells, `stress` evaluates von Mises stresses for frames and pictures. Where several
ranks share nodes at which volume changes are averaged, `shared_volumes` adds up their parts. The formulas stand in the
kernels (`kernels.cells`, `kernels.elements`, `kernels.materials`).
"""
