"""Elastic laws as functions of the displacement gradient H = F - I [..., 3, 3].

energy_density [J/m^3], first Piola-Kirchhoff stress P = dW/dF [Pa] and the moduli A = dP/dF [..., 3, 3, 3, 3] [Pa],
A[i, k, j, l] = dP[i, k] / dF[j, l]. Written in H so that small strains are not lost in the rounding of 1 + small.
"""

from dataclasses import dataclass

import numpy as np

IDENTITY = np.eye(3)


def outer(subscripts, left, right):
    """The fourth-order product of two tensors, e.g. "il,jk" -> [..., i, k, j, l]."""
    a, b = subscripts.split(",")
    return np.einsum(f"...{a},...{b}->...ikjl", left, right)


def transposed(tensor):
    return np.swapaxes(tensor, -1, -2)


def trace(tensor):
    return np.trace(tensor, axis1=-2, axis2=-1)


def green_strain(H):
    """E = (F^T F - I)/2 = (H + H^T + H^T H)/2."""
    return (H + transposed(H) + transposed(H) @ H) / 2


def volume_change(H):
    """J - 1 = tr H + second invariant + det H."""
    return trace(H) + (trace(H) ** 2 - trace(H @ H)) / 2 + np.linalg.det(H)


@dataclass(frozen=True)
class Elastic:
    """Young's modulus [Pa] and Poisson's ratio [-]; lam and mu are Lame's parameters [Pa]."""

    young: float
    poisson: float

    @property
    def lam(self):
        return self.young * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))

    @property
    def mu(self):
        return self.young / (2 * (1 + self.poisson))

    @property
    def is_linear(self):
        return False

    def cauchy(self, H):
        """Cauchy stress P F^T / J [Pa]."""
        return self.stress(H) @ transposed(IDENTITY + H) / (1 + volume_change(H))[..., None, None]

    def quadratic(self, strain):
        """mu e:e + lam/2 (tr e)^2."""
        return self.mu * np.sum(strain**2, axis=(-2, -1)) + self.lam / 2 * trace(strain) ** 2

    def hooke(self, strain):
        """2 mu e + lam tr(e) I."""
        return 2 * self.mu * strain + self.lam * trace(strain)[..., None, None] * IDENTITY


class LinearElastic(Elastic):
    """W = mu e:e + lam/2 (tr e)^2 with e = sym H; Cauchy and Piola stress are the same here."""

    @property
    def is_linear(self):
        return True

    def energy_density(self, H):
        return self.quadratic((H + transposed(H)) / 2)

    def stress(self, H):
        return self.hooke((H + transposed(H)) / 2)

    def moduli(self, H):
        one = np.broadcast_to(IDENTITY, H.shape)
        return self.mu * (outer("ij,kl", one, one) + outer("il,jk", one, one)) + self.lam * outer("ik,jl", one, one)

    def cauchy(self, H):
        return self.stress(H)


class StVenantKirchhoff(Elastic):
    """W = mu E:E + lam/2 (tr E)^2 with E = (F^T F - I)/2."""

    def energy_density(self, H):
        return self.quadratic(green_strain(H))

    def stress(self, H):
        return (IDENTITY + H) @ self.hooke(green_strain(H))

    def moduli(self, H):
        one = np.broadcast_to(IDENTITY, H.shape)
        F = one + H
        return (
            outer("ij,kl", one, self.hooke(green_strain(H)))
            + self.lam * outer("ik,jl", F, F)
            + self.mu * (outer("il,jk", F, F) + outer("ij,kl", F @ transposed(F), one))
        )


class NeoHookean(Elastic):
    """W = mu/2 (I1 - 3) - mu ln J + lam/2 (J - 1)^2."""

    def energy_density(self, H):
        change = volume_change(H)
        return self.mu * (trace(green_strain(H)) - np.log1p(change)) + self.lam / 2 * change**2

    def stress(self, H):
        change = volume_change(H)[..., None, None]
        G = transposed(np.linalg.inv(IDENTITY + H))
        # F - F^-T = 2 F^-T E for the symmetric E = (F^T F - I)/2
        return 2 * self.mu * G @ green_strain(H) + self.lam * change * (1 + change) * G

    def moduli(self, H):
        change = volume_change(H)[..., None, None, None, None]
        G = transposed(np.linalg.inv(IDENTITY + H))
        one = np.broadcast_to(IDENTITY, H.shape)
        return (
            self.mu * (outer("ij,kl", one, one) + outer("il,jk", G, G))
            + self.lam * (1 + 2 * change) * (1 + change) * outer("ik,jl", G, G)
            - self.lam * change * (1 + change) * outer("il,jk", G, G)
        )


@dataclass(frozen=True)
class MooneyRivlin(Elastic):
    """W = c1 (I1 - 3) + c2 (I2 - 3) - 2 (c1 + 2 c2) ln J + bulk/2 (J - 1)^2; second = c2/(c1 + c2) at small strains.

    I1 = tr C, I2 = ((tr C)^2 - tr C^2)/2 of C = F^T F.
    """

    second: float = 0.2

    @property
    def c1(self):
        return (1 - self.second) * self.mu / 2

    @property
    def c2(self):
        return self.second * self.mu / 2

    @property
    def bulk(self):
        return self.lam - 4 * self.c2

    def energy_density(self, H):
        E, change = green_strain(H), volume_change(H)
        first = 2 * trace(E)
        second = 4 * trace(E) + 2 * (trace(E) ** 2 - trace(E @ E))
        log = 2 * (self.c1 + 2 * self.c2) * np.log1p(change)
        return self.c1 * first + self.c2 * second - log + self.bulk / 2 * change**2

    def stress(self, H):
        change = volume_change(H)[..., None, None]
        F, E = IDENTITY + H, green_strain(H)
        G = transposed(np.linalg.inv(F))
        # 2 c1 F + 2 c2 (I1 F - F C) - 2 (c1 + 2 c2) F^-T without the parts that cancel
        tension = 4 * (self.c1 + 2 * self.c2) * G @ E
        return (
            tension
            + 4 * self.c2 * F @ (trace(E)[..., None, None] * IDENTITY - E)
            + self.bulk * change * (1 + change) * G
        )

    def moduli(self, H):
        change = volume_change(H)[..., None, None, None, None]
        one = np.broadcast_to(IDENTITY, H.shape)
        F = one + H
        C, B = transposed(F) @ F, F @ transposed(F)
        G = transposed(np.linalg.inv(F))
        first = trace(C)[..., None, None, None, None]
        spread = first * outer("ij,kl", one, one) + 2 * outer("ik,jl", F, F)
        spread = spread - outer("ij,kl", one, C) - outer("il,jk", F, F) - outer("ij,kl", B, one)
        return (
            2 * self.c1 * outer("ij,kl", one, one)
            + 2 * self.c2 * spread
            + (2 * (self.c1 + 2 * self.c2) - self.bulk * change * (1 + change)) * outer("il,jk", G, G)
            + self.bulk * (1 + 2 * change) * (1 + change) * outer("ik,jl", G, G)
        )
