"""Whole steps: the force pass with the motion of the nodes, and everything else of a step in one launch."""
