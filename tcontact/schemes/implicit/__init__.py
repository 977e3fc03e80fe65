"""Implicit schemes: one file each, the `scheme` that they share, and the `solution` of their equations by Newton."""

from .scheme import ImplicitScheme

__all__ = ["ImplicitScheme"]
