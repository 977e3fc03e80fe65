"""Friction layers: the implicit step of many layers at once."""
