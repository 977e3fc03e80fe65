"""Checks of a law from its energy: derived stress and tangent against the energy itself, stability without strain.

The function is called with complex numbers: Im W(H + i t e)/t is its derivative without rounding (Squire and
Trapp, SIAM Rev. 40, 110, 1998). All is compared at random displacement gradients. `formula` is a `Formula` of
kernels/language/formula.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..base.errors import InputError

SIZES = (1e-3, 0.05, 0.3)  # of the components of random displacement gradients
SAMPLES = 16  # displacement gradients of each size
STEP = 1e-30  # of complex differences
AGREE = 1e-8  # relative differences above it are errors of a law, not of rounding
NONE = 1e-8  # stress without strain, over the largest modulus, above which there is one


class Moduli(NamedTuple):
    """Stiffness at small strains [Pa]: Lame constants, and the largest modulus of a plane wave."""

    lam: float
    mu: float
    wave: float


class Rest:
    """The stiffness of a law without strain."""

    def __init__(self, formula: Any) -> None:
        self.formula = formula

    def moduli(self, name: str, given: Mapping[str, float]) -> Moduli:
        """Return the moduli of a material. Raises `InputError` if it has stress at rest or is not stable there."""
        zero = np.zeros((3, 3))
        stress = self.formula.at(self.formula.stress, zero, given)
        tangent = self.formula.at(self.formula.tangent, zero, given).reshape(3, 3, 3, 3)
        text = {one: float(value) for one, value in given.items()}
        if not (np.isfinite(stress).all() and np.isfinite(tangent).all()):
            raise InputError(name, text, "its stiffness without strain is no finite number; give other parameters")
        if not np.abs(stress).max() <= NONE * np.abs(tangent).max():
            remedy = f"it has a stress of {np.abs(stress).max():.3g} Pa without strain; the derivative of the energy"
            raise InputError(name, text, f"{remedy} must vanish there: complete the formula, or give other parameters")
        pairs = [(i, j) for i in range(3) for j in range(i, 3)]
        basis = np.array([_unit(i, j) for i, j in pairs])
        stiffness = np.einsum("aij,ijkl,bkl->ab", basis, tangent, basis)
        least = np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))[0]
        if not least > 1e-12 * np.abs(stiffness).max():
            remedy = f"a small strain has a stiffness of {least:.3g} Pa, which must be above 0: waves and the stable"
            raise InputError(name, text, f"{remedy} step need it; complete the formula, or give other parameters")
        bulk = np.einsum("iijj->", tangent) / 9.0
        mu = (np.einsum("ijij->", tangent) + np.einsum("ijji->", tangent) - 6.0 * bulk) / 20.0
        return Moduli(float(bulk - 2.0 / 3.0 * mu), float(mu), _wave_modulus(tangent))


def _unit(i: int, j: int) -> np.ndarray:
    """Return a symmetric strain of length 1."""
    one = np.zeros((3, 3))
    one[i, j] += 0.5
    one[j, i] += 0.5
    return one / np.linalg.norm(one)


def _wave_modulus(tangent: np.ndarray) -> float:
    """Return the largest p.A(n)p of unit vectors, A_ik = C_ijkl n_j n_l: n and p in turns, from many directions."""
    starts = np.random.default_rng(5).normal(size=(20, 3))
    best = 0.0
    for n in [*np.eye(3), *starts]:
        before = -1.0
        for _ in range(200):
            value, vectors = np.linalg.eigh(np.einsum("ijkl,j,l->ik", tangent, n, n) / (n @ n))
            p = vectors[:, -1]
            if value[-1] <= before * (1.0 + 1e-15):
                break
            before = float(value[-1])
            n = np.linalg.eigh(np.einsum("ijkl,i,k->jl", tangent, p, p))[1][:, -1]
        best = max(best, before)
    return best


def samples(size: float) -> np.ndarray:
    """Return random displacement gradients [SAMPLES, 3, 3] with det F > 0.1."""
    h = size * np.random.default_rng(11).normal(size=(8 * SAMPLES, 3, 3))
    return h[np.linalg.det(np.eye(3) + h) > 0.1][:SAMPLES]


def is_volumetric(formula: Any, given: Mapping[str, float], name: str) -> bool:
    """Return whether W with a parameter k is W without it and k/2 (J - 1)^2."""
    h = np.concatenate([samples(size) for size in SIZES])
    change = np.linalg.det(np.eye(3) + h) - 1.0
    what = [formula.energy]
    at = [formula.at(what, h, {**given, name: factor * given[name]})[..., 0] for factor in (0.0, 1.0, 2.0)]
    for factor in (1, 2):
        wanted = 0.5 * factor * given[name] * change**2
        scale = np.abs(at[factor]) + np.abs(at[0]) + np.abs(wanted)
        usable = np.isfinite(at[factor])
        if not (given[name] and usable.any()):
            return False
        if not (np.abs(at[factor] - at[0] - wanted)[usable] <= 1e-9 * scale[usable]).all():
            return False
    return True


def volumetric_first(formula: Any, given: Mapping[str, float]) -> list[str]:
    """Return the names of the parameters, a volumetric one first if there is one."""
    first = [name for name in given if is_volumetric(formula, given, name)][:1]
    return first + [name for name in given if name not in first]


def check(formula: Any, given: Mapping[str, float]) -> None:
    """Compare formula, derivatives and function. Raises `InputError`."""
    checked = 0
    for size in SIZES:
        h = samples(size)
        found = formula.at([formula.energy, *formula.stress, *formula.tangent], h, given)
        usable = np.isfinite(found).all(axis=1)
        h, energy, stress = h[usable], found[usable, 0], found[usable, 1:10]
        tangent = found[usable, 10:].reshape(-1, 9, 9)
        checked += len(h)
        if not len(h):
            continue
        direct = formula.direct(h, given).real
        if not np.allclose(direct, energy, AGREE, AGREE * size**2 * np.abs(energy).max(), equal_nan=False):
            _wrong(formula, "for numbers it gives other values", "make it depend on its arguments alone")
        moduli = np.abs(tangent).max()
        for column, (i, j) in enumerate(np.ndindex(3, 3)):
            step = np.zeros((3, 3), dtype=complex)
            step[i, j] = 1j * STEP
            slope = formula.direct(h + step, given).imag / STEP
            if not np.abs(slope - stress[:, column]).max() <= AGREE * size * moduli:
                _wrong(formula, "its derivative by complex steps is not that of its formula", "use smooth functions")
            bent = formula.at(formula.stress, h + step, given).imag / STEP
            if not np.abs(bent - tangent[:, :, column]).max() <= AGREE * moduli:
                _wrong(formula, "its second derivative by complex steps is another", "use smooth functions")
        turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        turned = formula.direct(turn @ (np.eye(3) + h) - np.eye(3), given).real
        if not np.abs(turned - energy).max() <= AGREE * (size**2 * moduli + np.abs(energy).max()):
            remedy = "write it in C, E, J or the invariants, which no rotation changes"
            _wrong(formula, "a rotation of the body changes it", remedy)
    if not checked:
        text = "it is no finite number even at strains of 1e-3; give parameters of a typical material"
        raise InputError("register_law.parameters", dict(given), text)


def _wrong(formula: Any, what: str, remedy: str) -> None:
    raise InputError("register_law.energy", formula.function, f"{what}: {remedy}")
