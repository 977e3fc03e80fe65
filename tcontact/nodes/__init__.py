"""Boundary nodes, which have a mass tensor, supports or contact (`boundary_nodes`), and the images of periodic nodes.

How it works. Boundary nodes move by matrices instead of one number; what supports prescribe is taken from their motion,
and its reaction is measured. `images` lets periodic nodes follow their masters.
"""
