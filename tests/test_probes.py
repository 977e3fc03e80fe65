"""Probes: means over sets in the history, equal to positions, their differences and stresses; bad ones are refused."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from oracle import meshes
from stopped_runs import copied, quietly, same, same_files
from stopped_runs import scene as stopped_scene

import tcontact as tc
from tcontact.planning.probe_places import ProbePlace
from tcontact.results.files.vtkhdf import ResultData

RUBBER = tc.NeoHookean(1e7, 0.3, 1000.0)
MOTION = ("displacement", "velocity", "acceleration")


def probes(*sets, quantities=MOTION):
    """A probe of every quantity on every set."""
    return [tc.Probe(name, quantity) for name in sets for quantity in quantities]


def columns(result, name):
    """Displacement, velocity, acceleration of a set "<body>_<set>", and the times."""
    return [result.probes[f"{name}_{quantity}"] for quantity in MOTION] + [result.history["time"]]


def check_differences(result, name):
    """Velocity and acceleration are the central differences of the displacement, to rounding."""
    u, v, a, t = columns(result, name)
    steps = np.diff(t)[:, None]
    rates = np.diff(u, axis=0) / steps
    mean, total = 0.5 * (steps[1:] + steps[:-1]), steps[1:] + steps[:-1]
    middle = (steps[:-1] * rates[1:] + steps[1:] * rates[:-1]) / total
    assert len(t) > 4
    np.testing.assert_allclose(v[1:-1], middle, rtol=0, atol=1e-12 * np.abs(v).max())
    noise = 1e-14 * np.abs(u).max() / steps.min() ** 2  # of a second difference of means
    exact = np.diff(rates, axis=0) / mean
    np.testing.assert_allclose(a[1:-1], exact, rtol=0, atol=1e-12 * np.abs(a).max() + noise)


def test_free_fall_is_exact():
    """u = v0 t + g t^2/2 and x = X + u on every row of the leapfrog; other rows of a thinned history are the same."""
    start, gravity = np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.5, -9.81])
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    mesh = mesh.with_sets(cell_sets={"half": [0, 1, 2, 3]}, node_sets={"tip": [26]})
    body = tc.Body(mesh, RUBBER, start, probes=[*probes("zmax", "tip", "half"), tc.Probe("tip", "position")])
    scene = tc.Scene(body, duration=0.05, gravity=gravity)
    result = tc.simulate(scene)
    for name in ("body-0_zmax", "body-0_tip", "body-0_half"):
        u, v, a, t = columns(result, name)
        np.testing.assert_allclose(u, t[:, None] * start + 0.5 * t[:, None] ** 2 * gravity, rtol=0, atol=1e-14)
        np.testing.assert_allclose(v, start + t[:, None] * gravity, rtol=0, atol=1e-13)
        np.testing.assert_allclose(a, np.tile(gravity, (len(t), 1)), rtol=0, atol=1e-11)
    position = result.probes["body-0_tip_position"]
    assert np.array_equal(position, mesh.nodes[26] + result.probes["body-0_tip_displacement"])
    thinned = tc.simulate(scene, history_every=3)
    assert np.array_equal(
        thinned.probes["body-0_zmax_velocity"][:-1],
        result.probes["body-0_zmax_velocity"][::3][: len(thinned.history["time"]) - 1],
    )


def test_single_rows_are_sampled_where_a_kernel_takes_no_further_array(monkeypatch, tmp_path):
    """Taichi limits the arrays of a kernel; then every row is a launch and the host samples, to the same bits. A set
    may have a name with "/", which the result file reads as a folder."""
    from tcontact.kernels.language import signatures
    from tcontact.schemes.explicit.serial_step import SerialStep

    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)).with_sets(node_sets={"a/b": [0, 1]})
    body = tc.Body(mesh, RUBBER, lambda x: 0.1 * x, probes=probes("a/b"))
    scene = tc.Scene(body, duration=0.05)
    many = tc.simulate(scene, out=tmp_path / "run")
    launched, run = [], SerialStep.run
    monkeypatch.setattr(signatures, "MAXIMUM_ARGUMENTS", 16)  # as many as the kernel has without samples

    def counted(self, *arguments, **options):
        launched.append(self.samples() is None)
        return run(self, *arguments, **options)

    monkeypatch.setattr(SerialStep, "run", counted)
    single = tc.simulate(scene)
    assert len(launched) == len(single.history["time"])
    assert all(launched)
    assert single.probes.keys() == {f"body-0_a-b_{quantity}" for quantity in MOTION}
    for name, column in many.probes.items():
        assert np.array_equal(column, single.probes[name])
    stored = ResultData.open(tmp_path / "run" / "result.vtkhdf").history
    assert np.array_equal(stored["probe_body-0_a-b_velocity"], many.probes["body-0_a-b_velocity"])


def test_harmonic_motion_of_a_spring_and_a_mass():
    """A column held at the sides and at the foot is one mass m/2 on a spring (lambda + 2 mu) A/L: a = -k/m u, and its
    stress is uniaxial strain's, on every row."""
    steel = tc.LinearElastic(2e11, 0.3, 7800.0)
    mesh = tc.box_mesh((0.1, 0.1, 0.2), (1, 1, 1)).with_sets(cell_sets={"all": [0]})
    sides = [tc.Support(f"{axis}{end}", axis) for axis in "xy" for end in ("min", "max")]
    body = tc.Body(
        mesh, steel, displacement=mesh.nodes * (0.0, 0.0, 1e-3), supports=[tc.Support("zmin", "z"), *sides],
        probes=[*probes("zmax"), *probes("all", quantities=("stress", "von_mises", "pressure"))], name="column",
    )  # fmt: skip
    result = tc.simulate(tc.Scene(body, duration=2e-4), tc.CentralDifference(cfl=0.2))
    u, _v, a, t = columns(result, "column_zmax")
    modulus = steel.lame_lambda + 2.0 * steel.lame_mu
    square = modulus / 0.2**2 * 2.0 / steel.density
    np.testing.assert_allclose(a, -square * u, rtol=0, atol=1e-12 * np.abs(a).max())
    assert len(t) > 30
    assert u[:, 2].min() < -0.9 * 2e-4 < 0.9 * 2e-4 < u[:, 2].max()
    strain = u[:, 2] / 0.2
    stress = np.outer(strain, [steel.lame_lambda, steel.lame_lambda, modulus, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(result.probes["column_all_stress"], stress, rtol=0, atol=1e-12 * np.abs(stress).max())
    np.testing.assert_allclose(
        result.probes["column_all_von_mises"],
        2.0 * steel.lame_mu * np.abs(strain),
        rtol=0,
        atol=1e-12 * np.abs(stress).max(),
    )
    np.testing.assert_allclose(
        result.probes["column_all_pressure"], -stress[:, :3].mean(axis=1), rtol=0, atol=1e-12 * np.abs(stress).max()
    )


@pytest.mark.parametrize(
    ("kind", "formulation", "tolerance"),
    [
        ("hex8", "full", 1e-12),
        ("hex8", "reduced", 1e-12),
        ("hex8", "mean-dilatation", 1e-12),
        ("tet4", "node-averaged", 1e-12),
    ],
)
def test_the_stress_turns_with_the_body_and_follows_the_formula(kind, formulation, tolerance):
    """A rotation R of the deformed body gives R sigma R^t; it has the stress of the definition, and its own norms."""
    mesh = tc.box_mesh((1.0, 0.8, 0.6), (2, 2, 2), kind).with_sets(cell_sets={"part": [0, 3]})
    stretch = np.eye(3) + np.array([[0.02, 0.01, 0.0], [0.0, -0.03, 0.02], [0.01, 0.0, 0.01]])
    turn = meshes.rotation(3)
    found = []
    for motion in (stretch, turn @ stretch):
        body = tc.Body(
            mesh, RUBBER, displacement=mesh.nodes @ (motion - np.eye(3)).T, formulation=formulation, name="b",
            probes=probes("part", "zmax", quantities=("stress", "von_mises", "pressure")),
        )  # fmt: skip
        result = quietly(tc.simulate, tc.Scene(body, duration=1e-6))
        assert np.allclose(result.probes["b_part_stress"][0], result.probes["b_zmax_stress"][0], rtol=1e-9)
        xx, yy, zz, xy, yz, xz = result.probes["b_part_stress"][0]
        stress = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        deviator = stress - np.trace(stress) / 3.0 * np.eye(3)
        size = np.abs(stress).max()
        assert abs(result.probes["b_part_von_mises"][0] - np.sqrt(1.5 * (deviator**2).sum())) < 1e-12 * size
        assert abs(result.probes["b_part_pressure"][0] + np.trace(stress) / 3.0) < 1e-12 * size
        found.append(stress)
    size = np.abs(found[0]).max()
    np.testing.assert_allclose(found[1], turn @ found[0] @ turn.T, rtol=0, atol=tolerance * size)
    mu, lame, jacobian = RUBBER.lame_mu, RUBBER.lame_lambda, np.linalg.det(stretch)
    exact = mu / jacobian * (stretch @ stretch.T - np.eye(3)) + lame * (jacobian - 1.0) * np.eye(3)
    np.testing.assert_allclose(found[0], exact, rtol=0, atol=tolerance * size)


@pytest.mark.parametrize(("removal", "cells"), [("normal", 17), ("full", 3)], ids=["normal-parallel", "full-serial"])
def test_contact_nodes_without_mass_have_the_differences_of_their_positions(cells, removal):
    """Also those that rub; the ends of the run agree with the result."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (cells, cells, min(cells, 15)), origin=(0.0, 0.0, 1e-5))
    body = tc.Body(mesh, RUBBER, (0.3, 0.0, -2.0), contact="zmin", name="block",
                   probes=[*probes("zmin", "zmax"), tc.Probe("zmin", "position")])  # fmt: skip
    steps, dt = 6.5 if cells > 3 else 40.0, 0.5 * 0.1 / cells / RUBBER.wave_speed
    contact = tc.MasslessContact(removal=removal)
    physics = tc.Scene(body, tc.Plane(), duration=steps * dt, contact=contact, friction=tc.Coulomb(0.3))
    assert tc.plan(physics).domains[0].small == (cells == 3)
    result = quietly(tc.simulate, physics, tc.CentralDifference(dt=dt))
    assert result.history["contact_nodes"].max() > 0
    for name in ("block_zmin", "block_zmax"):
        check_differences(result, name)
    nodes = mesh.nodes_of("zmin")
    ends = result.probes["block_zmin_position"][-1], result.probes["block_zmin_velocity"][-1]
    np.testing.assert_allclose(ends[0], result.position[nodes].mean(axis=0), rtol=0, atol=1e-15)
    np.testing.assert_allclose(ends[1], result.velocity[nodes].mean(axis=0), rtol=0, atol=1e-12)


def test_implicit_schemes_record_motion_and_stress():
    """Their velocity is the one at the row, their acceleration its change in the step before."""
    mesh = tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2), origin=(0.0, 0.0, 1e-4))
    body = tc.Body(
        mesh, RUBBER, (0.0, 0.0, -2.0), contact="zmin", probes=[*probes("zmax", "zmin"), tc.Probe("zmin", "stress")]
    )
    scene = tc.Scene(body, tc.Plane(), duration=6e-4, maxima=("von_mises",))
    result = tc.simulate(scene, tc.Gonzalez(dt=2e-5))
    for name in ("body-0_zmax", "body-0_zmin"):
        u, v, a, t = columns(result, name)
        np.testing.assert_allclose(
            a[1:], np.diff(v, axis=0) / np.diff(t)[:, None], rtol=0, atol=1e-12 * np.abs(a).max()
        )
    u, v, _, t = columns(result, "body-0_zmax")  # with mass: v1 = 2 d/dt - v0
    np.testing.assert_allclose(0.5 * (v[1:] + v[:-1]), np.diff(u, axis=0) / np.diff(t)[:, None], rtol=0, atol=1e-10)
    assert result.probes["body-0_zmin_stress"][-1, 2] < 0.0
    assert result.maxima["von_mises"].value == result.history["von_mises_max"].max() > 0.0


def watched(**options):
    """A scene of two sliding blocks with probes and maxima."""
    scene = stopped_scene(bodies=2, **options)
    bodies = [
        tc.Body(body.mesh, body.material, body.velocity, contact="zmin",
                probes=probes("zmin", "zmax", quantities=(*MOTION, "stress", "pressure")))
        for body in scene.bodies
    ]  # fmt: skip
    return tc.Scene(
        bodies,
        scene.obstacles,
        scene.duration,
        scene.gravity,
        scene.contact,
        scene.friction,
        maxima=("von_mises", "pressure"),
    )


@pytest.mark.parametrize("scheme", [tc.CentralDifference(cfl=0.3), tc.Gonzalez(dt=4e-5)], ids=lambda one: one.name)
def test_a_split_run_has_the_same_bits(scheme, monkeypatch, tmp_path):
    physics = watched(friction=None if scheme.implicit else tc.Coulomb(0.3))
    fields = {} if scheme.implicit else {"fields": "all"}
    whole, copies = copied(monkeypatch, tmp_path, physics, scheme, 7, frames=4, **fields)
    assert whole.ok
    assert len(whole.probes) == 20
    for row in sorted(copies)[1:3]:
        same(quietly(tc.resume, copies[row], physics, scheme), whole)
        same_files(copies[row], tmp_path / "whole")
    with open(tmp_path / "whole" / "history.csv", encoding="utf-8") as file:
        names = next(csv.reader(file))
    assert {"probe_body-1_zmin_stress_xy", "probe_body-0_zmin_velocity_z", "probe_body-1_zmax_pressure"} <= {*names}


def test_a_scene_without_them_has_nothing_of_them():
    from tcontact.schemes.explicit.state import DomainState

    plain = stopped_scene()
    planned = tc.plan(plain)
    assert not {"probes", "maxima"} & {*planned.terms}
    assert planned.columns == ()
    parts = [[np.zeros_like(body.mesh.nodes)] for body in plain.bodies]
    state = DomainState(plain, planned.domains[0], *[[values[0] for values in parts]] * 2, planned.layout)
    assert state.sensors is None
    assert state.serial is not None
    assert state.serial.samples() is None
    assert "sensors" not in state.memory()
    assert {"probes", "maxima"} <= {*tc.plan(watched()).terms}


BOX = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1))
METAL = tc.ElastoPlastic(2e11, 0.3, 7800.0, tc.LinearHardening(3e8))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: tc.Probe("zmax", "heat"), r"Probe.quantity = 'heat'.*'acceleration'"),
        (lambda: tc.Probe(3, "stress"), r"Probe.set = 3"),
        (lambda: tc.Body(BOX, RUBBER, probes=[tc.Probe("tip", "stress")]), r"Body.probes\[0\].set = 'tip'.*zmin"),
        (lambda: tc.Body(BOX, RUBBER, probes=[tc.Probe("zmax", "plastic_strain")]), r"plastic_strain.*no metal"),
        (lambda: tc.Body(BOX, RUBBER, probes=[tc.Probe("zmax", "stress")] * 2), r"probes\[1\].*twice"),
        (lambda: tc.Body(BOX, RUBBER, probes=["zmax"]), r"Body.probes.*list of tcontact.Probe"),
        (lambda: tc.Scene(tc.Body(BOX, RUBBER), duration=1.0, maxima=("heat",)), r"Scene.maxima = 'heat'.*von_mises"),
        (lambda: tc.Scene(tc.Body(BOX, RUBBER), duration=1.0, maxima="mises"), r"Scene.maxima = 'mises'"),
        (lambda: tc.Scene(tc.Body(BOX, RUBBER), duration=1.0, maxima=["plastic_strain"]), r"plastic_strain.*no metal"),
        (lambda: tc.Scene(tc.Body(BOX, METAL), duration=1.0, maxima=["pressure"] * 2), r"Scene.maxima.*twice"),
    ],
)  # fmt: skip
def test_bad_probes_and_maxima_are_refused_by_name(make, said):
    with pytest.raises(tc.InputError, match=said):
        make()


def test_two_probes_with_one_column_are_refused():
    there = BOX.translated((2.0, 0.0, 0.0)).with_sets(node_sets={"c": [0]})
    here = BOX.with_sets(node_sets={"b_c": [0]})
    pair = [
        tc.Body(here, RUBBER, name="a", probes=[tc.Probe("b_c", "velocity")]),
        tc.Body(there, RUBBER, name="a_b", probes=tc.Probe("c", "velocity")),
    ]
    with pytest.raises(tc.InputError, match=r"Scene.bodies\[1\].probes = 'probe_a_b_c_velocity'.*rename"):
        tc.Scene(pair, duration=1.0)


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_the_cells_of_a_set(kind):
    """Those of a face set have one of its faces, those of a node set one of its nodes."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (3, 3, 3), kind)
    top = mesh.nodes_of("zmax")
    low = mesh.nodes[mesh.cells][..., 2].min(axis=1)
    on_top = np.isin(mesh.cells, top).sum(axis=1)
    whole = {"hex8": on_top == 4, "tet4": on_top == 3, "wedge6": on_top >= 3}[kind]
    assert np.array_equal(tc.Probe("zmax", "stress").cells(mesh), np.flatnonzero(whole))
    assert (low[whole] > 0.6).all()
    mesh = mesh.with_sets(node_sets={"some": top})
    assert np.array_equal(tc.Probe("some", "stress").cells(mesh), np.flatnonzero(on_top > 0))


def test_the_mean_of_a_row_has_the_same_bits_however_many_rows_are_measured_at_once():
    """Frames and checkpoints end a launch; the stress of the cells of a probe stands in one of several columns."""
    random = np.random.default_rng(3)
    weights, fields = random.random(48), random.normal(size=(32, 60, 7))
    place = ProbePlace(tc.Probe("zmin", "von_mises"), random.permutation(60)[:48], weights / weights.sum())
    whole, stress = (place.mean(values[:, place.items]) for values in (fields[..., 6], fields[..., :6]))
    for rows in (1, 2, 5):
        np.testing.assert_array_equal(place.mean(fields[:rows, :, 6][:, place.items]), whole[:rows])
        np.testing.assert_array_equal(place.mean(fields[:rows, :, :6][:, place.items]), stress[:rows])
