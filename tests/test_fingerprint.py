"""A resume compares everything that the motion depends on: all fields of all classes, and functions by their values."""

import dataclasses
import os
import signal
import warnings

import numpy as np
import pytest
from stopped_runs import quietly, scene

import tcontact as tc
from tcontact.friction_layer.metals import COPPER, STAINLESS_304
from tcontact.results.files.vtkhdf import ResultFile
from tcontact.run.checkpoint import fingerprint as module
from tcontact.run.checkpoint import store
from tcontact.run.checkpoint.fingerprint import compare, fingerprint
from tcontact.run.scene_files.classes import CLASSES
from tcontact.scene.call_record import MAXIMUM_CALLS, CallRecord
from tcontact.scene.obstacles.motion import Motion
from tcontact.schemes.implicit.scheme import ImplicitScheme

BOX = tc.box_mesh((0.06, 0.06, 0.04), (2, 2, 2), origin=(0.0, 0.0, 1e-3))
TETS = tc.box_mesh((0.06, 0.06, 0.04), (2, 2, 2), "tet4", origin=(0.0, 0.0, 1e-3))
ROUND = {"young": 2e7, "poisson": 0.3, "density": 1200.0}
OTHER = {"young": 2.1e7, "poisson": 0.31, "density": 1201.0}
MOTION = {
    "name": "ram",
    "velocity": (0.0, 0.0, 0.1),
    "angular_velocity": (0.0, 0.1, 0.0),
    "metal": COPPER,
    "friction": tc.Coulomb(0.1),
}
MOTION |= {name: lambda s: dataclasses.replace(s, mass=1.0, inertia=0.1) for name in ("mass", "inertia")}
IMPLICIT = {
    "dt": 1e-5, "cfl": lambda s: type(s)(cfl=2.0), "rtol": 1e-11, "iterations": 16, "mass": "consistent",
    "reproject": False, "solver": "krylov", "verbose": True, "alpha": -0.2, "chi": 0.2,
}  # fmt: skip
FAR = {"point": (0.0, 0.0, -1.0), "center": (0.0, 0.0, -3.0)}


def below(points):
    """Distance to the half-space z < 0."""
    return points[:, 2]


def taller(points):
    """Its neighbour a little lower."""
    return points[:, 2] + 1e-3


def upward(points):
    """Gradient of both."""
    return np.tile((0.0, 0.0, 1.0), (len(points), 1))


GRID = tc.Sdf(below, origin=(-0.1, -0.1, -0.1), spacing=0.05, nodes=(6, 6, 6))
SURFACE = (np.eye(3), np.array([[0, 1, 2]]))
# an instance of every class, and another value for every one of its fields: a value, or a function of the instance
GUINAN = STAINLESS_304.hardening_law
COOK = tc.JohnsonCook(1e8, 2e8, 0.3, 0.02, 1.1, 1500.0)
METAL = tc.ElastoPlastic(2e11, 0.3, 7.85e3, tc.LinearHardening(3e8), specific_heat=500.0)
CHANGES = {
    tc.NeoHookean: (tc.NeoHookean(**ROUND), OTHER),
    tc.StVenantKirchhoff: (tc.StVenantKirchhoff(**ROUND), OTHER),
    tc.LinearElastic: (tc.LinearElastic(**ROUND), OTHER),
    tc.MooneyRivlin: (
        tc.MooneyRivlin(1e6, 2e6, 3e7, 1200.0),
        {"c1": 1.1e6, "c2": 2.1e6, "bulk": 3.1e7, "density": 1e3},
    ),
    tc.Ogden: (
        tc.Ogden((1e6, -1e3), (1.3, -2.0), 0.4, 1200.0),
        {"mu": (1e6, -1.1e3), "alpha": (1.3, -2.1), "poisson": 0.41, "density": 1e3},
    ),
    tc.LinearHardening: (tc.LinearHardening(1e6, 1e5), {"yield_stress": 1.1e6, "modulus": 1.1e5}),
    tc.SteinbergGuinan: (
        GUINAN,
        {field.name: 1.01 * (getattr(GUINAN, field.name) or 2e9) for field in dataclasses.fields(GUINAN)},
    ),
    tc.JohnsonCook: (COOK, {field.name: 1.01 * getattr(COOK, field.name) for field in dataclasses.fields(COOK)}),
    tc.MieGrueneisen: (tc.MieGrueneisen(1.5, 2.0, 4e3), {"slope": 1.6, "gamma": 2.1, "sound_speed": 4.1e3}),
    tc.ElastoPlastic: (
        METAL,
        {"young": 2.1e11, "poisson": 0.31, "density": 7.9e3, "hardening": GUINAN, "heat_share": 0.8,
         "specific_heat": 501.0, "initial_temperature": 301.0, "pressure": "barrier"},
    ),
    tc.Plane: (tc.Plane(), FAR | MOTION | {"normal": (0.0, 1e-3, 1.0)}),
    tc.Sphere: (
        tc.Sphere((0.0, 0.0, -2.0)),
        FAR | MOTION | {"radius": 1.1, "inside": lambda s: tc.Sphere(inside=True)},
    ),
    tc.Cylinder: (
        tc.Cylinder((0.0, 0.0, -2.0), (1.0, 0.0, 0.0)),
        FAR | MOTION | {"axis": (1.0, 0.1, 0.0), "radius": 1.1, "inside": lambda s: tc.Cylinder(inside=True)},
    ),
    tc.Box: (
        tc.Box((0.0, 0.0, -2.0)),
        FAR | MOTION | {"size": (1.0, 1.1, 1.0), "axes": np.array([[0, 1.0, 0], [-1.0, 0, 0], [0, 0, 1.0]])},
    ),
    tc.Sdf: (
        GRID,
        MOTION
        | {"distance": taller, "gradient": upward, "origin": (-0.1, -0.1, -0.11), "spacing": 0.051, "nodes": (6, 6, 7)}
        | {"center": (0.0, 0.0, 0.3), "surface": SURFACE},
    ),
    tc.MasslessContact: (
        tc.MasslessContact("full"),
        {"removal": "normal", "penalty": 1e9, "depth": 2, "sweeps": 11, "tolerance": 1e-9, "cell_viscosity": 0.1,
         "solver": "gauss-seidel"},
    ),
    tc.PenaltyContact: (tc.PenaltyContact(3e10), {"stiffness": 3.1e10}),
    tc.ImpulseContact: (tc.ImpulseContact(), {}),
    tc.Coulomb: (
        tc.Coulomb(static=0.4, kinetic=0.2, decay=1.0, limit=1e6),
        {"coefficient": lambda c: tc.Coulomb(0.3, limit=1e6), "static": 0.41, "kinetic": 0.21, "decay": 1.1,
         "limit": 2e6},
    ),
    tc.FrictionTable: (
        tc.FrictionTable((0.0, 1.0), (0.0, 1e5), ((0.4, 0.3), (0.2, 0.1))),
        {"speeds": (0.0, 1.1), "pressures": (0.0, 2e5), "coefficients": ((0.4, 0.3), (0.2, 0.11))},
    ),
    tc.NoFriction: (tc.NoFriction(), {}),
    tc.RegularizedCoulomb: (tc.RegularizedCoulomb(0.3, 0.1), {"coefficient": 0.31, "slip_speed": 0.11}),
    tc.FrictionLayer: (
        tc.FrictionLayer(),
        {
            "material": dataclasses.replace(STAINLESS_304, density=7901.0), "coefficient": 0.31, "points": 41,
            "grading": 31.0, "thickness": 1.1e-5, "heat_share": 0.51, "plastic_heat": 0.1,
            "initial_temperature": 301.0, "method": "stress-secant", "reload": False, "tolerance": 2e-2, "substeps": 65,
        },
    ),
    tc.MassDamping: (tc.MassDamping(40.0), {"rate": 41.0}),
    tc.BulkViscosity: (tc.BulkViscosity(), {"linear": 0.07, "quadratic": 1.3}),
    type(STAINLESS_304): (
        STAINLESS_304,
        {field.name: 1.01 * getattr(STAINLESS_304, field.name) for field in dataclasses.fields(STAINLESS_304)},
    ),
    tc.CentralDifference: (tc.CentralDifference(), {"cfl": 0.5, "dt": 1e-6}),
    tc.Scene: (
        tc.Scene([tc.Body(BOX, tc.NeoHookean(**ROUND))], [tc.Plane()], 1e-3),
        {
            "bodies": lambda s: _with(s, "bodies", [*s.bodies, tc.Body(BOX, tc.NeoHookean(**ROUND))]),
            "obstacles": [], "duration": 1.1e-3, "gravity": (0.0, 0.0, -9.81), "contact": tc.PenaltyContact(3e10),
            "friction": tc.Coulomb(0.1), "damping": tc.MassDamping(1.0), "viscosity": tc.BulkViscosity(),
            "pairs": lambda s: _with(s, "pairs", None), "maxima": ("pressure",),
        },
    ),
    tc.Body: (
        tc.Body(BOX, tc.NeoHookean(**ROUND)),
        {
            "mesh": tc.box_mesh((0.06, 0.06, 0.05), (2, 2, 2), origin=(0, 0, 1e-3)),
            "material": tc.LinearElastic(**ROUND), "velocity": lambda b: _with(b, "velocity", 0.1 * b.mesh.nodes),
            "contact": "zmin", "supports": [tc.Support("zmax", "z")], "name": "cube", "formulation": "reduced",
            "periodic": "x", "displacement": (0.0, 0.0, 1e-3), "metal": COPPER,
            "loads": [tc.Load("zmax", pressure=1e3)],
            "point_masses": [tc.PointMass("zmax", 0.1)], "springs": [tc.Spring("zmax", 1e3)],
            "probes": [tc.Probe("zmax", "stress")],
            "rigid_parts": [tc.RigidPart("zmax", mass=1.0)],
        },
    ),
    tc.RigidPart: (
        tc.RigidPart("zmax", mass=1.0, inertia=1.0),
        {
            "set": "xmax", "mass": 1.1, "inertia": 1.1, "center": (0.0, 0.0, 0.1), "velocity": (0.0, 0.0, 1.0),
            "angular_velocity": (0.0, 0.0, 1.0), "driven": lambda part: tc.RigidPart(part.set, driven=True),
        },
    ),
    tc.Load: (
        tc.Load("zmax", pressure=1e3),
        {"set": "xmax", "pressure": 1.1e3, "traction": lambda s: tc.Load("zmax", traction=(0.0, 0.0, 1e3)),
         "force": lambda s: tc.Load("zmax", force=(0.0, 0.0, 1e3))},
    ),
    tc.Support: (tc.Support("zmax", "z"), {"set": "xmax", "axes": "xz", "velocity": 0.1, "displacement": 1e-3}),
    tc.PointMass: (tc.PointMass("zmax", 0.1), {"set": "xmax", "mass": 0.11}),
    tc.Probe: (tc.Probe("zmax", "velocity"), {"set": "xmax", "quantity": "position"}),
    tc.Spring: (
        tc.Spring("zmax", 1e3, to="zmin"),
        {"set": "xmax", "stiffness": 1.1e3, "damping": 1.0, "to": (0.0, 0.0, 1.0), "axes": "z", "rest_length": 0.1},
    ),
    tc.Mesh: (
        BOX,
        {
            "nodes": lambda m: tc.Mesh(1.01 * m.nodes, m.cells, m.kind, face_sets=m.face_sets),
            "cells": lambda m: tc.Mesh(m.nodes, m.cells[::-1], m.kind, face_sets=m.face_sets),
            "cell_sets": lambda m: m.with_sets(cell_sets={"half": [0, 1]}),
            "kind": TETS, "node_sets": {"some": [0, 1]},
            "face_sets": lambda m: _with(m, "face_sets", {**m.face_sets, "zmin": m.face_sets["zmax"]}),
        },
    ),
}  # fmt: skip


def _with(thing, name, value):
    return dataclasses.replace(thing, **{name: value})


def scheme_sample(kind):
    """An implicit scheme."""
    return kind(dt=2e-5), {field.name: IMPLICIT.get(field.name) for field in dataclasses.fields(kind)}


def classes():
    """Every class that a scene or a scheme consists of."""
    named = {kind for kinds in CLASSES.values() for kind in kinds.values()}
    return sorted({*named, tc.Scene, tc.Body, tc.Support, tc.Load, tc.Probe, tc.Mesh}, key=lambda kind: kind.__name__)


def placed(thing):
    """A scene that holds the thing, a scheme, and the name of its place."""
    body, bodies, obstacles, scheme, place = tc.Body(BOX, tc.NeoHookean(**ROUND)), None, [tc.Plane()], None, ""
    options = {}
    if isinstance(thing, tc.Scene):
        return thing, tc.CentralDifference(), ""
    if isinstance(thing, tc.Body):
        bodies, place = [thing], "bodies[0]."
    elif isinstance(thing, tc.Mesh):
        bodies, place = [_with(body, "mesh", thing)], "bodies[0].mesh."
    elif isinstance(thing, tc.Support):
        bodies, place = [_with(body, "supports", [thing])], "bodies[0].supports[0]."
    elif isinstance(thing, tc.Load):
        bodies, place = [_with(body, "loads", [thing])], "bodies[0].loads[0]."
    elif isinstance(thing, tc.Probe):
        bodies, place = [_with(body, "probes", [thing])], "bodies[0].probes[0]."
    elif isinstance(thing, tc.RigidPart):
        bodies, place = [_with(body, "rigid_parts", [thing])], "bodies[0].rigid_parts[0]."
    elif type(thing).__name__ in CLASSES["material"]:
        bodies, place = [_with(body, "material", thing)], "bodies[0].material."
    elif type(thing).__name__ in CLASSES["hardening"]:
        bodies, place = [_with(body, "material", _with(METAL, "hardening", thing))], "bodies[0].material.hardening."
    elif type(thing).__name__ in CLASSES["pressure"]:
        bodies, place = [_with(body, "material", _with(METAL, "pressure", thing))], "bodies[0].material.pressure."
    elif type(thing).__name__ in CLASSES["obstacles"]:
        obstacles, place = [thing], "obstacles[0]."
    elif type(thing).__name__ in CLASSES["metal"]:
        options, place = {"friction": tc.FrictionLayer(thing)}, "friction.material."
    elif type(thing) in CLASSES["scheme"].values():
        scheme, place = thing, "scheme."
    else:
        part = next(part for part in ("contact", "friction", "damping", "viscosity") if word(part, thing))
        options, place = {part: thing}, f"{part}."
    return tc.Scene(bodies or [body], obstacles, 1e-3, **options), scheme or tc.CentralDifference(), place


def word(part, thing):
    """Whether a class stands at this place."""
    return type(thing) in CLASSES[part].values()


@pytest.mark.parametrize("kind", classes(), ids=lambda kind: kind.__name__)
def test_a_change_of_any_field_of_any_class_is_refused_by_name(kind, tmp_path):
    """The base scene leaves a checkpoint, and every scene with one other field is refused by a resume from it."""
    sample = scheme_sample(kind) if issubclass(kind, ImplicitScheme) else CHANGES.get(kind)
    assert sample is not None, f"give an instance of {kind.__name__} and another value for each field in CHANGES"
    base, changes = sample
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        physics, scheme, place = placed(base)
        stopped(tmp_path, fingerprint(physics, scheme))
        compare(fingerprint(physics, scheme), fingerprint(*placed(base)[:2]))  # as it was: no complaint
        for field in (field for field in dataclasses.fields(kind) if field.init):
            changed = changes.get(field.name)
            assert changed is not None, f"give another value for {kind.__name__}.{field.name} in CHANGES"
            other = changed(base) if callable(changed) and field.name not in ("distance", "gradient") else changed
            other = other if isinstance(other, kind) else _with(base, field.name, other)
            with pytest.raises(tc.InputError, match="the run that is to go on had") as caught:
                tc.resume(tmp_path, *placed(other)[:2])
            assert f"{place}{field.name}" in str(caught.value), field.name


def stopped(folder, physics):
    """A folder with a checkpoint of a run with this fingerprint."""
    cells = np.arange(8).reshape(1, 8)
    ResultFile.create(folder / "result.vtkhdf", np.random.default_rng(1).random((8, 3)), [("hex8", cells)]).close()
    head = {"physics": physics, "row": 0, "frames": 0, "origin": {}}
    store.write(folder, head, {}, {})


def pulse(start, length, height=0.2):
    """A velocity that is zero but for a pulse."""
    return lambda t: np.array([0.0, 0.0, height if start < t < start + length else 0.0])


def wall(velocity):
    """A scene whose wall moves."""
    return scene(wall=tc.Plane(velocity=velocity))


@pytest.mark.parametrize("start", np.random.default_rng(4).uniform(0.0, 1.19e-3, 5))
def test_a_pulse_as_long_as_a_sample_is_found_anywhere(start):
    length = 1.2e-3 / module.SAMPLES * 1.0001
    with pytest.raises(tc.InputError) as caught:
        compare(fingerprint(wall(pulse(0, 0)), "x"), fingerprint(wall(pulse(start, length)), "x"))
    assert caught.value.field == "obstacles[0].velocity.function"


def test_spin_functions_are_compared_too():
    one, other = (tc.Sphere((0, 0, -2.0), angular_velocity=pulse(1e-4, 1e-5, height)) for height in (1.0, 1.1))
    with pytest.raises(tc.InputError, match="angular_velocity"):
        compare(fingerprint(scene(wall=one), "x"), fingerprint(scene(wall=other), "x"))


@pytest.mark.parametrize("number", range(4))
def test_functions_of_loads_and_gravity_are_compared_by_their_values(number):
    """Those of place at the faces of the set, own forces on the nodes at rest; not by name."""

    def physics(height):
        f = pulse(1e-4, 1e-5, height)
        load = [
            lambda: tc.Load("zmax", pressure=lambda t: f(t)[2]),
            lambda: tc.Load("zmax", traction=lambda t, x: f(t) + x),
            lambda: tc.Load("zmax", force=lambda x, v, t: f(t) + x),
            lambda: None,
        ][number]()
        gravity = f if load is None else None
        body = tc.Body(BOX, tc.NeoHookean(**ROUND), loads=[load] if load else [])
        return fingerprint(tc.Scene([body], duration=1e-3, gravity=gravity), "x")

    compare(physics(1.0), physics(1.0))
    with pytest.raises(tc.InputError, match="function"):
        compare(physics(1.0), physics(1.1))


def test_a_function_with_two_values_at_one_time_is_refused_by_name():
    generator = np.random.default_rng(1)
    with pytest.raises(tc.InputError, match=r"no run with it can be resumed.*function of the time alone") as caught:
        fingerprint(wall(lambda t: generator.normal(size=3)), "x")
    assert caught.value.field == "obstacles[0].velocity"


@pytest.mark.parametrize("wrong", [lambda t: 1 / 0, lambda t: [np.nan] * 3, lambda t: "x", lambda t: [1j, 0, 0]])
def test_a_function_that_fails_has_a_fingerprint_all_the_same(wrong):
    """The run ends where it fails and says so; a fingerprint has only to tell it from others."""
    found = fingerprint(wall(wrong), "x")
    assert found == fingerprint(wall(wrong), "x")
    assert found != fingerprint(wall(pulse(0, 0)), "x")


def test_another_value_at_one_time_that_the_run_asked_for_is_found(tmp_path):
    """A spike between all samples, at a step that is done: found before anything is written."""

    def velocity(t, spike=None):
        return np.array([0.1, 0.0, 5.0 if t == spike else 0.0])

    fine = tc.CentralDifference(cfl=0.3)
    place, times = interrupted_run(wall(velocity), fine, tmp_path)
    spike = times[len(times) // 2]
    before = {path.name: path.read_bytes() for path in place.iterdir()}
    with pytest.raises(
        tc.InputError, match=r"Plane.velocity.*gives \[0.1, 0.0, 5.0\] at t = .* and gave \[0.1, 0.0, 0.0\]"
    ):
        quietly(tc.resume, place, wall(lambda t: velocity(t, spike)), fine)
    assert {path.name: path.read_bytes() for path in place.iterdir()} == before
    assert quietly(tc.resume, place, wall(velocity), fine).ok


def interrupted_run(physics, scheme, folder):
    """The folder of a run that Ctrl-C stopped, and the times of its rows."""
    append = ResultFile.append

    def pressed(self, moment, *fields):
        if len(self) == 2:
            os.kill(os.getpid(), signal.SIGINT)
        append(self, moment, *fields)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ResultFile, "append", pressed)
        result = quietly(tc.simulate, physics, scheme, out=folder / "run", frames=5, checkpoint=3600.0)
    assert result.reason == "interrupted"
    return folder / "run", result.history["time"]


def test_a_record_keeps_all_calls_and_of_very_many_an_even_share():
    record = CallRecord()
    times = np.arange(5.0 * MAXIMUM_CALLS)
    for start in range(0, len(times), 3):
        record.add(times[start : start + 3], np.repeat(times[start : start + 3, None], 3, axis=1))
        if start + 3 <= MAXIMUM_CALLS:
            assert len(record.times) == start + 3
    assert MAXIMUM_CALLS / 2 <= len(record.times) <= MAXIMUM_CALLS
    np.testing.assert_array_equal(np.diff(record.times), np.full(len(record.times) - 1, 8.0))
    np.testing.assert_array_equal(record.values[:, 2], record.times)
    again = CallRecord()
    again.restore(record.checkpoint())
    for one in (record, again):
        one.add(times[:99], np.zeros((99, 3)))
    np.testing.assert_array_equal(again.times, record.times)


def test_a_motion_goes_on_with_the_bits_of_its_record():
    ball = tc.Sphere(velocity=lambda t: np.array([np.cos(t), 0, 0]), angular_velocity=lambda t: np.array([0, t, 0]))
    first, second = Motion(ball), Motion(ball)
    first.poses(np.linspace(0.0, 1.0, 50))
    second.restore(first.checkpoint())
    for part in zip(first.poses([1.02, 1.03]), second.poses([1.02, 1.03]), strict=True):
        np.testing.assert_array_equal(*part)
    assert np.array_equal(first.spin.record.times, second.spin.record.times)
