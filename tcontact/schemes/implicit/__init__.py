"""Implicit schemes: one file each, their base class in `scheme`, their equations in `solution` (Newton's method)."""

from .scheme import ImplicitScheme

__all__ = ["ImplicitScheme"]
