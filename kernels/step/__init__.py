"""Kernels of whole steps: the parallel force pass with the motion of the nodes, and the serial kernel."""
