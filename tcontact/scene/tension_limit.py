"""The largest tension that the neo-Hookean law carries where Poisson's ratio is negative.

With lambda < 0 its energy W = mu/2 (I1 - 3) - mu ln J + lambda/2 (J - 1)^2 has no least value. Under equal stretches l
along all axes the nominal stress

    s = mu (l - 1/l) + lambda (l^5 - l^2)

has a maximum, beyond which a body that is pulled expands without end. The other laws have none: lambda is not negative
in `MooneyRivlin` and `Ogden`, and the energy of `LinearElastic` and `StVenantKirchhoff` is a positive square.
"""

from __future__ import annotations

from collections.abc import Iterable

from .body import Body
from .materials import Material, NeoHookean


def largest_tension(material: Material) -> tuple[float, float] | None:
    """Return the stretch and the nominal stress [Pa] of the largest tension along all axes; None without a limit."""
    lam, mu = material.lame_lambda, material.lame_mu
    if not isinstance(material, NeoHookean) or lam >= 0.0:
        return None
    low, high = 1.0, 1.0 + (mu / -lam) ** 0.25  # ds/dl is 3 bulk > 0 at l = 1, and below 2 mu + 3 lambda l^4
    for _ in range(60):
        l = 0.5 * (low + high)  # noqa: E741
        rising = mu * (1.0 + 1.0 / l**2) + lam * (5.0 * l**4 - 2.0 * l) > 0.0
        low, high = (l, high) if rising else (low, l)
    return low, mu * (low - 1.0 / low) + lam * (low**5 - low**2)


def tension_advice(bodies: Iterable[Body]) -> str:
    """Return what a failed run of these bodies may have met, with the remedy; "" where no law has such a limit."""
    for body in bodies:
        for material in body.materials:
            found = largest_tension(material)
            if found is not None:
                stretch, stress = found
                most = f"carries no more than {stress:.3g} Pa of tension along all axes, at stretches of {stretch:.4g},"
                remedy = "pull less, or take StVenantKirchhoff"
                return f"NeoHookean with poisson {material.poisson:g} {most} and expands without end beyond: {remedy}"
    return ""
