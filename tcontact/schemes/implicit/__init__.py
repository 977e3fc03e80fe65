"""Implicit schemes: what they share in `scheme`, one file each, and the `solution` of their equations by Newton's
method."""

from .scheme import ImplicitScheme

__all__ = ["ImplicitScheme"]
