"""Passes over cells: forces, stresses, points of implicit schemes."""
