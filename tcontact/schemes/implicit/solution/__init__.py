"""Implicit time steps: cells, contact, Newton's method and linear solvers shared by the implicit schemes (METHOD 4)."""
