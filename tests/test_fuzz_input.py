"""Any value in any place of the public API: a valid object, or `InputError` with field, value and remedy."""

import contextlib
import dataclasses
import io
import os
import signal
import traceback
import warnings

import numpy as np
import pytest
import surfaces
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from odd_values import ANY, MAT, MESH, SCALARS, Speechless

import tcontact as tc
from tcontact import friction_layer
from tcontact.commands.cli import main

FEW, MANY = 12, 400
SURFACE = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1), "tet4")


def small_ring(**given):
    """A ring of few cells, whatever its sizes are."""
    return tc.ring_mesh(cells=8, across=1, layers=1, **given)


def small_cylinder(**given):
    return tc.cylinder_mesh(cells=2, layers=1, **given)


def small_ball(**given):
    return tc.ball_mesh(cells=2, **given)


GOOD = {
    tc.NeoHookean: {"young": 1e7, "poisson": 0.3, "density": 1e3},
    tc.LinearElastic: {"young": 1e7, "poisson": 0.3, "density": 1e3},
    tc.StVenantKirchhoff: {"young": 1e7, "poisson": 0.3, "density": 1e3},
    tc.box_mesh: {"size": (1, 1, 1), "cells": (1, 1, 1), "kind": "hex8", "origin": (0, 0, 0)},
    tc.Mesh: {
        "nodes": MESH.nodes, "cells": MESH.cells, "kind": "hex8",
        "node_sets": {"a": [0, 1]}, "face_sets": {"b": MESH.face_sets["zmin"]},
    },
    MESH.with_sets: {"node_sets": {"a": [0]}, "face_sets": {}},
    MESH.translated: {"offset": (1, 0, 0)},
    MESH.rotated: {"rotation": ((0, 0, 1), 0.1), "about": (0, 0, 0)},
    MESH.scaled: {"factor": 2.0},
    MESH.faces_of: {"names": "zmin"},
    MESH.nodes_of: {"names": ["zmin"]},
    tc.read_mesh: {"path": "nowhere.msh", "scale": 1.0, "kind": None},
    tc.load_scene: {"path": "nowhere.toml"},
    tc.Support: {"set": "xmin", "axes": "x", "velocity": 0.0, "displacement": None},
    tc.PointMass: {"set": "xmin", "mass": 1.0},
    tc.Load: {"set": "xmin", "pressure": 1.0, "traction": None, "force": None},
    tc.Probe: {"set": "xmin", "quantity": "velocity"},
    tc.RigidPart: {
        "set": "xmin", "mass": 1.0, "inertia": 1.0, "center": None, "velocity": None, "angular_velocity": None,
        "driven": False,
    },
    small_ring: {"inner": 1.0, "outer": 2.0, "length": 1.0, "kind": "hex8", "axis": "z", "start": 0.0},
    small_cylinder: {"radius": 1.0, "length": 1.0, "kind": "hex8", "axis": "z", "center": (0, 0, 0)},
    small_ball: {"radius": 1.0, "kind": "hex8", "center": (0, 0, 0)},
    tc.Sdf.from_function: {
        "distance": lambda points: np.linalg.norm(points, axis=1) - 0.5, "low": (-1, -1, -1), "high": (1, 1, 1),
        "cells": 8, "name": None, "mass": None,
    },
    tc.register_law: {
        "name": "Fuzzed", "energy": lambda strain, mu: mu * (strain.E**2).sum(), "parameters": {"mu": 1.0},
    },
    tc.Spring: {"set": "xmin", "stiffness": 1.0, "damping": 0.0, "to": "xmax", "axes": None, "rest_length": None},
    tc.Body: {
        "mesh": MESH, "material": MAT, "velocity": (0, 0, -1), "contact": "zmin", "supports": [tc.Support("xmin", "x")],
        "name": "a", "formulation": "full", "periodic": None, "displacement": None,
        "point_masses": [tc.PointMass("xmin", 1.0)], "springs": [tc.Spring("xmin", 1.0)],
        "loads": [tc.Load("xmax", pressure=1.0)], "probes": [tc.Probe("xmax", "stress")],
        "rigid_parts": [tc.RigidPart("xmax", mass=1.0)],
    },
    tc.Plane: {"point": (0, 0, 0), "normal": (0, 0, 1), "name": "w", "velocity": None, "angular_velocity": None,
               "friction": tc.Coulomb(0.3)},
    tc.Sphere: {"center": (0, 0, -1), "radius": 1.0, "inside": False, "name": None, "velocity": (0, 0, 1),
                "mass": 1.0, "inertia": (1.0, 1.0, 1.0)},
    tc.Cylinder: {"point": (0, 0, 0), "axis": (0, 0, 1), "radius": 1.0, "inside": False, "angular_velocity": (0, 0, 1)},
    tc.Box: {"center": (0, 0, 0), "size": (1, 1, 1), "axes": np.eye(3)},
    tc.Sdf: {
        "distance": np.ones((4, 4, 4)), "gradient": None, "origin": (0, 0, 0), "spacing": 1.0, "nodes": None,
        "center": None, "surface": None,
    },
    tc.Sdf.from_surface: {
        "surface": (MESH.nodes[:8], [[0, 1, 2]]), "cells": 4, "margin": None, "scale": 1.0, "name": None,
    },
    tc.MasslessContact: {"removal": "auto", "penalty": None, "depth": 1, "sweeps": 10, "tolerance": None},
    tc.PenaltyContact: {"stiffness": 1e9},
    tc.Coulomb: {"coefficient": 0.3, "static": None, "kinetic": None, "decay": None, "limit": None},
    tc.FrictionTable: {"speeds": (0.0, 1.0), "pressures": (0.0,), "coefficients": ((0.3,), (0.2,))},
    tc.RegularizedCoulomb: {"coefficient": 0.3, "slip_speed": 0.1},
    tc.FrictionLayer: {
        field.name: field.default for field in dataclasses.fields(tc.FrictionLayer)
    },
    friction_layer.Metal: dataclasses.asdict(friction_layer.STAINLESS_304),
    tc.MassDamping: {"rate": 1.0},
    tc.BulkViscosity: {"linear": 0.06, "quadratic": 1.2},
    tc.CentralDifference: {"cfl": 0.9, "dt": None},
    tc.Scene: {
        "bodies": [tc.Body(MESH, MAT, contact="auto", velocity=(0, 0, -1))], "obstacles": [tc.Plane()],
        "duration": 1e-3, "gravity": None, "contact": tc.MasslessContact(), "friction": None, "damping": None,
        "viscosity": None, "maxima": ("von_mises",),
    },
    tc.plan: {"scene": None},
}  # fmt: skip
SCENE = tc.Scene([tc.Body(MESH, MAT, contact="zmin")], [tc.Plane()], 1e-6)
SIMULATE = {
    "scene": None, "scheme": "none", "out": 3, "frames": -1, "threads": 0, "arch": "abacus", "progress": 2,
    "history_every": 0, "history_rows": 1, "initial": 1, "pressures": 3,
}  # fmt: skip
LAYER = {
    "material": None, "velocity": np.nan, "pressure": np.nan, "duration": -1, "dt": 0, "points": 1, "grading": -1,
    "thickness": 0, "heat_share": 2, "plastic_heat": 2, "initial_temperature": -1, "method": "none", "other": 3,
    "conductance": -1, "reload": 2, "history_every": 0, "threads": 0, "arch": "abacus",
}  # fmt: skip


class Hung(BaseException):
    """A call took too long."""


@contextlib.contextmanager
def limited(seconds=10):
    """An end to a call that hangs, by processor time: much more than the second that it may take on an idle machine."""

    def stop(*_):
        raise Hung

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def called(build, values):
    """Valid or refused as it should be; True if it was refused."""
    try:
        with limited():
            build(**values)
    except tc.InputError as error:
        refusal = error
    else:
        return False
    assert isinstance(refusal.field, str)
    assert refusal.field
    assert len(refusal.remedy.split()) >= 2
    assert len(str(refusal)) < 2000
    return True


def spoiled(good):
    """Keywords of which one, sometimes two, are anything."""
    names = st.lists(st.sampled_from(sorted(good)), min_size=1, max_size=2, unique=True)
    return names.flatmap(lambda some: st.fixed_dictionaries(dict.fromkeys(some, ANY)))


def fuzz(examples):
    quick = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.function_scoped_fixture]
    return settings(max_examples=examples, deadline=None, derandomize=True, database=None, suppress_health_check=quick)


def in_any_place(build, good, examples):
    @fuzz(examples)
    @given(spoiled(good))
    def run(changes):
        called(build, {**good, **changes})

    run()


def name_of(build):
    return getattr(build, "__qualname__", str(build))


@pytest.mark.parametrize("build", GOOD, ids=name_of)
def test_anything_in_a_place_is_taken_or_refused(build):
    in_any_place(build, GOOD[build], FEW)


@pytest.mark.slow
@pytest.mark.parametrize("build", GOOD, ids=name_of)
def test_anything_in_a_place_is_taken_or_refused_many_times(build):
    in_any_place(build, GOOD[build], MANY)


def test_a_value_that_cannot_be_shown_is_refused_all_the_same():
    assert called(tc.NeoHookean, {"young": Speechless(), "poisson": 0.3, "density": 1.0})
    assert called(tc.NeoHookean, {"young": 10**10000, "poisson": 0.3, "density": 1.0})


@pytest.mark.parametrize("build", GOOD, ids=name_of)
def test_every_listed_value_in_every_place(build):
    """Each argument with each awkward value, one at a time."""
    good, wrong = GOOD[build], []
    for key in good:
        for value in SCALARS:
            try:
                called(build, {**good, key: value})
            except (Exception, Hung) as error:
                last = traceback.extract_tb(error.__traceback__)[-1]
                wrong.append(
                    f"{key} = {value!r:.60}: {type(error).__name__} {error!s:.80} ({last.filename}:{last.lineno})"
                )
    assert not wrong, "\n" + "\n".join(wrong)


def refused_runs(build, wrong, good, examples):
    """One argument is surely wrong, so nothing is ever run; others are anything."""

    @fuzz(examples)
    @given(st.sampled_from(sorted(wrong)), spoiled(wrong))
    def run(key, changes):
        assert called(build, {**good, **changes, key: wrong[key]})

    run()


@pytest.mark.parametrize("examples", [80, pytest.param(1000, marks=pytest.mark.slow)])
def test_simulate_refuses_what_is_wrong(examples, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused_runs(tc.simulate, SIMULATE, {"scene": SCENE}, examples)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("examples", [80, pytest.param(1000, marks=pytest.mark.slow)])
def test_the_layer_refuses_what_is_wrong(examples):
    refused_runs(friction_layer.solve, LAYER, {}, examples)


COMMANDS = ["list", "run", "study", "info", "render", "bench", "doctor", "resume", "export"]
JUNK = [
    "",
    "-1",
    "nan",
    "1e999",
    "none",
    "../..",
    "junk.vtkhdf",
    "junk.json",
    "junk.toml",
    "folder",
    "a" * 300,
    "\u00e9",
    "--",
    "cube-impact",
]
OPTIONS = [
    "--set", "--out", "--frames", "--arch", "--threads", "--quiet", "--force", "--field", "--size", "--view",
    "--methods", "--sizes", "--steps", "--nonsense", "-v", "-x", "cells=0", "cells=nan", "cells=-3", "speed=inf",
    "dt=-1", "cfl=0", "kind=hex20", "removal=half", "scheme=none", "=", "cells", "young=-1", "poisson=0.5", "a=b=c",
]  # fmt: skip
ARGUMENTS = st.tuples(
    st.sampled_from(["run", "run", "info", "render", "study", "export", "resume", "nothing"]),
    st.lists(st.one_of(st.sampled_from(JUNK[:-1] + OPTIONS), st.text(max_size=4)), max_size=4),
)


@pytest.mark.parametrize("examples", [60, pytest.param(1000, marks=pytest.mark.slow)])
def test_the_command_line_ends_with_2(examples, tmp_path, monkeypatch):
    """No case is named, so nothing can run: bad usage, and no file is left."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    for name in ("junk.vtkhdf", "junk.json", "junk.toml"):
        (tmp_path / name).write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(range(256)))
    before = sorted(os.listdir(tmp_path))

    @fuzz(examples)
    @given(ARGUMENTS)
    def run(words):
        command, rest = words
        if command == "study" and "-" not in "".join(rest[:1]):
            rest = ["no-such-study", *rest]
        said = io.StringIO()
        with limited(), contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            code = main([command, *rest])
        asked = any("-h" in word or "--h" in word for word in rest)
        assert code == 2 or asked, (words, code, said.getvalue())
        assert asked or said.getvalue()

    run()
    assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.parametrize("examples", [40, pytest.param(600, marks=pytest.mark.slow)])
def test_wrong_settings_of_a_case_end_with_2(examples, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    wrong = [
        "young=-1",
        "poisson=0.5",
        "cells=0",
        "cells=two",
        "speed=nan",
        "density=0",
        "kind=x",
        "cfl=0",
        "dt=-1",
        "no=1",
    ]
    names = ["cube-impact", "bar-impact", "bouncing-bar", "wall-shock"]
    value = st.one_of(st.sampled_from(["", "nan", "inf", "-1", "0", "1e999", "x", "none"]), st.text(max_size=3))

    @fuzz(examples)
    @given(
        st.sampled_from(names),
        st.sampled_from(["nonsense=1", "cfl=0", "dt=-1", "cells=0", "="]),
        st.sampled_from(wrong),
        value,
    )
    def run(case, bad, other, text):
        said = io.StringIO()
        key = other.partition("=")[0]
        with limited(), contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            code = main(["run", case, "--set", bad, "--set", f"{key}={text}", "--frames", "0"])
        assert code == 2, (case, bad, key, text, said.getvalue())

    run()
    assert list(tmp_path.iterdir()) == []


BALL = surfaces.box()
HUGE = {
    "grid of a surface": lambda: tc.Sdf.from_surface(BALL, cells=5000),
    "cells of a surface": lambda: tc.Sdf.from_surface(BALL, cells=2**40),
    "margin of a surface": lambda: tc.Sdf.from_surface(BALL, cells=8, margin=1e300),
    "grid": lambda: tc.Sdf(lambda x: x[:, 0], spacing=1.0, nodes=(10**5,) * 3),
    "sweeps": lambda: tc.MasslessContact(sweeps=2**63),
    "depth": lambda: tc.MasslessContact(depth=2**63),
    "points": lambda: tc.FrictionLayer(points=2**31),
    "substeps": lambda: tc.FrictionLayer(substeps=2**63),
    "damping": lambda: tc.MassDamping(1e308),
    "steps": lambda: tc.simulate(SCENE, scheme=tc.CentralDifference(dt=1e-300)),
    "frames": lambda: tc.simulate(SCENE, frames=2**63),
    "history": lambda: tc.simulate(SCENE, history_every=2**63),
    "layer steps": lambda: friction_layer.solve(dt=5e-324),
    "layer duration": lambda: friction_layer.solve(duration=1e300),
    "layer points": lambda: friction_layer.solve(points=2**40),
    "layer thickness": lambda: friction_layer.solve(thickness=1e-300),
    "center": lambda: tc.simulate(tc.Scene(rigid(center=(1e200, 0.0, 0.0), inertia=1.0), duration=1e-6)),
    "stiffness of a pair": lambda: tc.Scene([of_law(1e308, 0.0), of_law(1e5, 3.0)], duration=1e-6).pairs,
}


def rigid(**options):
    """A body with a rigid part."""
    part = tc.RigidPart("zmax", mass=1.0, **options)
    return tc.Body(MESH, tc.NeoHookean(1e6, 0.3, 1e3), rigid_parts=[part])


def of_law(first, height):
    """A body that can touch another."""
    mesh = tc.Mesh(np.add(MESH.nodes, (0.0, 0.0, height)), MESH.cells, kind=MESH.kind, face_sets=MESH.face_sets)
    return tc.Body(mesh, tc.MooneyRivlin(first, 1e5, 1e7, 1e3), contact="zmin")


@pytest.mark.parametrize("value", [(True, 0.0, 1.0), [1, False, 0]])
def test_truth_values_among_numbers_are_refused(value):
    """NumPy would make numbers of them."""
    with pytest.raises(tc.InputError, match="finite numbers"):
        tc.Body(MESH, tc.NeoHookean(1e6, 0.3, 1e3), velocity=value)


def test_a_spring_to_a_set_without_name_is_refused():
    body = tc.Body(MESH, tc.NeoHookean(1e6, 0.3, 1e3), springs=[tc.Spring("zmax", stiffness=1.0, to="")])
    with pytest.raises(tc.InputError, match="use one of"):
        tc.simulate(tc.Scene(body, duration=1e-6))


@pytest.mark.parametrize("name", HUGE)
def test_what_would_take_all_memory_or_for_ever_is_refused_at_once(name):
    assert called(lambda: HUGE[name](), {})


@pytest.mark.parametrize("young", [1e308, 5e-324])
def test_forces_that_overflow_are_refused(young):
    stiff = tc.Body(MESH, tc.NeoHookean(young, 0.3, 1e3 if young > 1 else 5e-324), contact="zmin")
    assert called(tc.simulate, {"scene": tc.Scene([stiff], [tc.Plane()], 1e-6)})


def test_directions_of_any_length_are_unit_vectors():
    for length in (5e-324, 1e-200, 1e200, 1e308):
        assert np.linalg.norm(tc.Plane(normal=(length, length, 0)).normal) == pytest.approx(1.0)
