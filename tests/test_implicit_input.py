"""Implicit schemes refuse by name what they do not have, before anything is written."""

from dataclasses import replace

import pytest
from test_implicit_runs import cube, scene

import tcontact as tc


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"contact": tc.ImpulseContact()}, "Scene.contact"),
        ({"friction": tc.Coulomb(0.3)}, "Scene.friction"),
        ({"damping": tc.MassDamping(1.0)}, "Scene.damping"),
        ({"viscosity": tc.BulkViscosity(0.1, 1.0)}, "Scene.viscosity"),
        ({"obstacles": [tc.Plane(velocity=(0, 0, 1.0))]}, "Scene.obstacles[0]"),
    ],
)
def test_what_implicit_schemes_do_not_have_is_refused(change, field):
    own = replace(scene(cube(2), tc.Plane(), tc.MasslessContact(), 1e-3), **change)
    with pytest.raises(tc.InputError) as error:
        tc.simulate(own, scheme=tc.DiscreteGradient(dt=1e-4))
    assert error.value.field == field
    assert "central-difference" in str(error.value) or "Contact" in str(error.value)


def test_a_law_that_the_kernels_lack_is_refused_before_anything_is_written(tmp_path, monkeypatch):
    from tcontact.kernels.materials import LAWS

    class Foam(tc.NeoHookean):
        law = "foam"

    own = scene(cube(1, material=Foam(1e7, 0.3, 1000.0)))
    for scheme in (tc.DiscreteGradient(dt=1e-4), "central-difference"):
        with pytest.raises(tc.InputError, match=r"bodies\[0\].material.law = 'foam'"):
            tc.simulate(own, scheme, out=tmp_path / "run")
    monkeypatch.setitem(LAWS, "foam", LAWS["neo_hookean"]._replace(step=None))
    with pytest.raises(tc.InputError, match="implicit schemes have"):
        tc.simulate(own, tc.DiscreteGradient(dt=1e-4), out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_periodic_bodies_and_cells_without_heirs_are_refused():
    own = scene(cube(2))
    tied = replace(own, bodies=[replace(own.bodies[0], periodic="x")])
    with pytest.raises(tc.InputError, match="periodic"):
        tc.simulate(tied, scheme=tc.DiscreteGradient(dt=1e-4))
    corner = replace(cube(3, kind="tet4"), contact=["zmin", "xmin", "ymin", "zmax", "xmax", "ymax"])
    walls = scene(corner, tc.Plane(), tc.MasslessContact(removal="full"))
    with pytest.raises(tc.InputError, match="lumped"):
        tc.simulate(walls, scheme=tc.DiscreteGradient(dt=1e-4, mass="consistent"))
    deep = replace(walls, contact=tc.MasslessContact(depth=2))
    with pytest.raises(tc.InputError, match="depth"):
        tc.simulate(deep, scheme=tc.DiscreteGradient(dt=1e-4, mass="consistent"))


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({}, "dt"),
        ({"dt": 1e-4, "cfl": 2.0}, "dt"),
        ({"dt": -1.0}, "dt"),
        ({"dt": 1e-4, "mass": "heavy"}, "mass"),
        ({"dt": 1e-4, "rtol": 0.0}, "rtol"),
        ({"dt": 1e-4, "rtol": 0.5}, "rtol"),
        ({"dt": 1e-4, "verbose": "loud"}, "verbose"),
        ({"dt": 1e-4, "iterations": 0}, "iterations"),
        ({"dt": 1e-4, "solver": "magic"}, "solver"),
        ({"dt": 1e-4, "reproject": 3}, "reproject"),
    ],
)
def test_bad_options_of_a_scheme(options, field):
    with pytest.raises(tc.InputError) as error:
        tc.DiscreteGradient(**options)
    assert error.value.field == field


def test_bad_numbers_of_the_dissipating_schemes():
    with pytest.raises(tc.InputError):
        tc.HilberHughesTaylor(dt=1e-4, alpha=-0.5)
    with pytest.raises(tc.InputError):
        tc.Dissipative(dt=1e-4, chi=-0.1)


def test_a_name_alone_asks_for_a_step():
    with pytest.raises(tc.InputError, match="give dt"):
        tc.simulate(scene(cube(2)), scheme="discrete-gradient")
