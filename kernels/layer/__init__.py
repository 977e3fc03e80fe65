"""Kernels of friction layers: implicit steps of many layers at once."""
