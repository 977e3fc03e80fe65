"""Passes over cells: the force pass of the explicit step, points and tangents of implicit steps, von Mises stress."""
