"""Kernels for pictures: a z-buffer that draws triangles."""
