"""Strain energies for the tests of registered laws."""

from math import factorial

import numpy as np

from tcontact.kernels.language.expressions import VALUES
from tcontact.kernels.language.traced_energy import Strain

ALONG = np.array([0.6, 0.0, 0.8])  # direction of fibres


def neo_hookean(strain, lam, mu):
    return mu / 2 * (strain.I1 - 3) - mu * np.log(strain.J) + lam / 2 * (strain.J - 1) ** 2


def gent(strain, mu, limit, bulk):
    return -0.5 * mu * limit * np.log(1.0 - (strain.I1_bar - 3.0) / limit) + 0.5 * bulk * (strain.J - 1.0) ** 2


def fibre(strain, lam, mu, fibre):
    """Fibres of exponential stiffness in a neo-Hookean matrix (Holzapfel, Gasser and Ogden 2000)."""
    square = ALONG @ strain.C @ ALONG
    return neo_hookean(strain, lam, mu) + fibre / 2 * np.expm1((square - 1) ** 2)


def of_matrices(strain, lam, mu):
    """St Venant-Kirchhoff with the square of ln J."""
    return mu * np.trace(strain.E @ strain.E) + lam / 2 * np.log(strain.J) ** 2


def of_powers(strain, bulk, mu, power):
    """Every operation there is: Ogden's volume function, Fung's and Arruda's kinds of terms, roots, quotients."""
    stretch = 1.0 + (strain.I1_bar - 3.0) / 2.0
    shape = mu / (2 * power) * (stretch**power - 1.0) + 0.1 * mu * (np.sqrt(strain.I2_bar / 3.0) - 1.0)
    shape = shape + 0.05 * mu * (np.cosh(strain.I1_bar - 3.0) - 1.0) + 0.1 * mu * (1.0 - 1.0 / (strain.I2_bar - 2.0))
    return shape + bulk / 4 * (strain.J**2 - 1.0 - 2.0 * np.log(strain.J))


def of_gradient(strain, lam, mu):
    """An energy of F, with no part that is a parameter times (J - 1)^2."""
    return mu / 2 * ((strain.F**2).sum() - 3.0) - mu * np.log(strain.J) + lam / 2 * np.log(strain.J) ** 2


FORMULAS = {
    neo_hookean: {"lam": 2.0, "mu": 1.0},
    gent: {"mu": 1.0, "limit": 30.0, "bulk": 20.0},
    fibre: {"lam": 2.0, "mu": 1.0, "fibre": 3.0},
    of_matrices: {"lam": 2.0, "mu": 1.0},
    of_powers: {"bulk": 5.0, "mu": 1.0, "power": 2.7},
    of_gradient: {"lam": 2.0, "mu": 1.0},
}


def log_split(x):
    """[x - ln(1 + x), 1/(1 + x)] with all digits, as the kernels have it."""
    terms = [(-x) ** k / k for k in range(2, 14)]
    return [sum(reversed(terms)) if abs(x) < 0.01 else x - np.log1p(x), 1.0 / (1.0 + x)]


def exponential_split(x):
    """[exp(x) - 1, exp(x) - 1 - x] with all digits, as the kernels have it."""
    terms = [x**k / factorial(k) for k in range(2, 14)]
    return [np.expm1(x), sum(reversed(terms)) if abs(x) < 0.01 else np.expm1(x) - x]


SPLITS = {
    "log_split": log_split,
    "exponential_split": exponential_split,
    "first": lambda pair: pair[0],
    "second": lambda pair: pair[1],
}


def numbers(graph, roots, symbols):
    """Values of expressions as the kernels compute them, for values of the symbols."""
    found = {}
    for a in graph.reachable(roots):
        parts = [found[part.place] for part in a.parts if hasattr(part, "place")]
        if a.operation == "number":
            found[a.place] = a.parts[0]
        else:
            found[a.place] = symbols[a.parts[0]] if a.operation == "symbol" else (VALUES | SPLITS)[a.operation](*parts)
    return [found[root.place] for root in roots]


def energy_of(formula, f, **parameters):
    """The energy of a deformation gradient [3, 3], by numbers."""
    return formula(Strain(gradient=f - np.eye(3)), **parameters)
