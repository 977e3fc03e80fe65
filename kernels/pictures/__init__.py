"""Kernels of the pictures: they turn triangles into pixels."""
