"""Hourglass stiffness of one-point hexes of registered laws: the same in explicit and implicit steps, in any order."""

import numpy as np
import pytest
from implicit_parts import cells_of
from one_point import Force, distorted, moved
from own_law_formulas import fibre, gent

import tcontact as tc

FIBRE = {"lam": 6e5, "mu": 4e5, "fibre": 2e6}
GENT = {"mu": 4e5, "limit": 30.0, "bulk": 2e6}


def material(name, energy, values, backwards=False):
    """A material of an energy whose parameters are named in this order, or backwards."""
    law = tc.register_law(name, energy, dict(reversed(values.items())) if backwards else values)
    return law(**values, density=1000.0)


@pytest.mark.filterwarnings("ignore::tcontact.HourglassWarning")
def test_explicit_and_implicit_steps_store_the_same_energy():
    """Elastic and hourglass energy of one displacement; a fibre makes one direction stiffer than the mean of all."""
    for name, energy, values in (("HourglassFibre", fibre, FIBRE), ("HourglassGent", gent, GENT)):
        body = tc.Body(distorted(), material(name, energy, values), formulation="reduced")
        u = moved(body.mesh)
        explicit, implicit = Force(body), cells_of(body)
        explicit(u)
        implicit.evaluate("gonzalez", np.zeros_like(u), u)
        elastic, _smallest, hourglass = implicit.energy(u)
        assert hourglass > 0.1 * elastic, name
        assert hourglass == pytest.approx(explicit.hourglass, rel=1e-12), name
        assert elastic == pytest.approx(explicit.energy, rel=1e-11), name


@pytest.mark.filterwarnings("ignore::tcontact.HourglassWarning")
def test_an_implicit_run_does_not_depend_on_the_order_of_the_parameters():
    """One energy whose parameters are named in two orders gives one run.

    The first two of them would give the moduli lam + 2 mu and lam + 2 fibre, which are 3.3 times apart.
    """
    found = []
    for name, backwards in (("HourglassFibre", False), ("HourglassFibreBackwards", True)):
        body = tc.Body(
            distorted(), material(name, fibre, FIBRE, backwards), formulation="reduced", displacement=moved(distorted())
        )
        found.append(tc.simulate(tc.Scene([body], duration=1e-3), scheme=tc.Gonzalez(dt=2e-4)))
    first, second = found
    assert all(result.ok for result in found)
    assert np.abs(first.position - second.position).max() < 1e-11
    for column in ("elastic", "hourglass"):
        assert second.history[column] == pytest.approx(first.history[column], rel=1e-9)
