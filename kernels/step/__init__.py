"""Whole steps: the force pass with the motion of the nodes, and steps of small bodies in one launch."""
