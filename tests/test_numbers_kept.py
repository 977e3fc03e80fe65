"""Numbers of scenes are kept as floats, whatever kind is given: whole ones beyond NumPy's, single precision."""

from dataclasses import fields, is_dataclass
from fractions import Fraction
from numbers import Real

import numpy as np
import pytest

import tcontact as tc
from tcontact.run.checkpoint.fingerprint import differences, fingerprint

HUGE = 2**64  # NumPy has no whole number for it
METAL = {"young": 2e11, "poisson": 0.3, "density": 8000}
MESH = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2), "hex8")
IMPLICIT = (tc.DiscreteGradient, tc.Gonzalez, tc.Midpoint, tc.Trapezoidal, tc.HilberHughesTaylor, tc.Dissipative)
MADE = {
    "cfl": lambda x: tc.CentralDifference(cfl=x),
    "dt": lambda x: tc.CentralDifference(dt=x),
    **{scheme.__name__: lambda x, scheme=scheme: scheme(dt=x) for scheme in IMPLICIT},
    "hookean": lambda x: tc.NeoHookean(x, 0, x),
    "mooney": lambda x: tc.MooneyRivlin(x, x, x, x),
    "ogden": lambda x: tc.Ogden((x,), (2,), 0, x),
    "metal": lambda x: tc.ElastoPlastic(**METAL, hardening=tc.LinearHardening(1, x), specific_heat=x),
    "johnson-cook": lambda x: tc.JohnsonCook(x, x, 1, x, x, x, 1, x),
    "steinberg-guinan": lambda x: tc.SteinbergGuinan(x, x, 1, x, x, x, x, 1, x),
    "shock curve": lambda x: tc.MieGrueneisen(x, x, x),
    "coulomb": lambda x: tc.Coulomb(x, limit=x),
    "falling": lambda x: tc.Coulomb(static=x, kinetic=x, decay=x),
    "regularized": lambda x: tc.RegularizedCoulomb(x, x),
    "layer": lambda x: tc.FrictionLayer(coefficient=x, tolerance=x),
    "massless": lambda x: tc.MasslessContact(penalty=x, tolerance=x),
    "penalty": lambda x: tc.PenaltyContact(x),
    "damping": lambda x: tc.MassDamping(x),
    "viscosity": lambda x: tc.BulkViscosity(x, x),
    "spring": lambda x: tc.Spring("xmax", x, x, to=(1, 0, 0), rest_length=x),
    "point mass": lambda x: tc.PointMass("xmax", x),
    "pressure": lambda x: tc.Load("xmax", pressure=x),
    "support": lambda x: tc.Support("xmax", "x", velocity=x),
    "support along two axes": lambda x: tc.Support("xmax", "xy", velocity=(x, 0)),
    "displacement": lambda x: tc.Support("xmax", "x", displacement=x),
    "sphere": lambda x: tc.Sphere(radius=x, mass=x),
    "scene": lambda x: tc.Scene([tc.Body(MESH, tc.NeoHookean(1e6, 0.3, 1e3))], duration=x),
}
WHOLE = {"depth", "sweeps", "iterations", "points", "substeps"}


def numbers_of(thing):
    """Names and values of the numbers of a dataclass, those in tuples too, but for counts."""
    for field in fields(thing):
        value = getattr(thing, field.name)
        for one in value if isinstance(value, tuple) else (value,):
            if is_dataclass(one) and field.name == "hardening":
                yield from numbers_of(one)
            elif field.name not in WHOLE and not isinstance(one, bool) and isinstance(one, Real):
                yield field.name, one


@pytest.mark.parametrize("name", MADE)
def test_numbers_are_floats(name):
    """A number too large for NumPy's whole ones, one of single precision, and a fraction."""
    for given in (HUGE, np.float32(3.0), Fraction(3)):
        found = list(numbers_of(MADE[name](given)))
        assert [(key, type(value)) for key, value in found] == [(key, float) for key, _ in found]
        assert float(given) in [value for _, value in found]


@pytest.mark.parametrize("scheme", [tc.CentralDifference, tc.DiscreteGradient, tc.HilberHughesTaylor])
@pytest.mark.parametrize("dt", [HUGE, 1e200])
def test_a_run_with_a_huge_step_ends_as_a_result(scheme, dt):
    """It ended in a `TypeError` of NumPy, or in an `OverflowError` of its square."""
    scene = tc.Scene([tc.Body(MESH, tc.NeoHookean(1e6, 0.3, 1e3))], duration=1e-3)
    with (
        pytest.warns(RuntimeWarning, match="above the stable step") if scheme is tc.CentralDifference else no_warning()
    ):
        assert tc.simulate(scene, scheme=scheme(dt=dt)).ok


def no_warning():
    """A context without a check."""
    return np.errstate()


@pytest.mark.parametrize("made", [lambda: tc.Sphere(radius=1e300, mass=1), lambda: tc.Box(size=(1e300, 1, 1), mass=1)])
def test_a_moment_of_inertia_beyond_numbers_is_refused(made):
    with pytest.raises(tc.InputError, match=r"\.mass = 1\.0: its moment of inertia is too large"):
        made()


def test_a_run_from_before_with_a_whole_number_goes_on():
    """The fingerprint in its checkpoint has "1000" for a density that is 1000.0 now; 1001 is another one."""
    scene = tc.Scene([tc.Body(MESH, tc.NeoHookean(1e6, 0.3, 1000))], duration=1)
    present = fingerprint(scene, tc.CentralDifference())
    name = next(name for name, text in present.items() if name.endswith("density") and text == "1000.0")
    assert differences(present | {name: "1000", "duration": "1"}, present) == []
    assert differences(present | {name: "1001"}, present) == [name]
    assert differences(present | {name: "function f"}, present) == [name]
