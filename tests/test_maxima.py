"""Maxima of von Mises stress, pressure and plastic strain: equal to those of every frame, exact over all steps."""

from __future__ import annotations

import json

import numpy as np
import pytest
from stopped_runs import copied, quietly, same

import tcontact as tc
from tcontact.results.files.vtkhdf import ResultData

RUBBER = tc.NeoHookean(1e7, 0.3, 1000.0)
STIFF = tc.NeoHookean(4e7, 0.4, 1500.0)
METAL = tc.ElastoPlastic(2e11, 0.3, 7800.0, tc.LinearHardening(1e8, 1e9))


def block(kind="hex8", cells=(3, 3, 2), size=(0.06, 0.06, 0.04), origin=(0.0, 0.0, 2e-5)):
    """A block a little above the floor, its lower half a set of its own."""
    mesh = tc.box_mesh(size, cells, kind, origin)
    upper = mesh.cell_centres()[:, 2] > origin[2] + 0.5 * size[2]
    return mesh.with_sets(cell_sets={"upper": np.flatnonzero(upper), "lower": np.flatnonzero(~upper)})


def falling(material, mesh, speed=-4.0, **options):
    """One body that hits a floor, with all maxima."""
    body = tc.Body(mesh, material, (0.0, 0.0, speed), contact="zmin", **options)
    plastic = ["plastic_strain"] * any(one.plastic for one in body.materials)
    return tc.Scene(body, tc.Plane(), duration=1.0, maxima=["von_mises", "pressure", *plastic])


def two_bodies():
    """A body of two materials and one of tetrahedra, in a pair, over a floor."""
    lower = tc.Body(
        block(), {"upper": RUBBER, "lower": STIFF}, (0.0, 0.0, -3.0), contact=["zmin", "zmax"], name="lower"
    )
    mesh = block("tet4", (2, 2, 2), origin=(0.0, 0.0, 0.04003))
    upper = tc.Body(mesh, RUBBER, (0.0, 0.0, -5.0), contact="zmin", name="upper")
    return tc.Scene([lower, upper], tc.Plane(), duration=1.0, maxima=["von_mises", "pressure"])


SCENES = {
    "serial": lambda: falling(RUBBER, block()),
    "parallel": lambda: falling(RUBBER, block(cells=(17, 17, 15))),
    "two bodies, two materials": two_bodies,
    "mean dilatation": lambda: falling(STIFF, block(), formulation="mean-dilatation"),
    "node-averaged": lambda: falling(STIFF, block("tet4"), formulation="node-averaged"),
    "periodic": lambda: falling(RUBBER, block(), periodic="xy"),
    "metal": lambda: falling(METAL, block(), -60.0),
    "metal and rubber": lambda: falling({"lower": METAL, "upper": RUBBER}, block(), -60.0),
}


def short(scene, steps):
    """The scene over so many steps of .6 of the stable step, and a scheme with this step."""
    scene = tc.Scene(scene.bodies, scene.obstacles, 1.0, contact=scene.contact, maxima=scene.maxima)
    speed = max(body.wave_speed for body in scene.bodies)
    dt = 0.3 * min(body.mesh.shortest_edge for body in scene.bodies) / speed
    return tc.Scene(scene.bodies, scene.obstacles, steps * dt, maxima=scene.maxima), tc.CentralDifference(dt=dt)


SLOW = ("periodic", "metal and rubber")


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in SCENES])
def test_every_frame_has_the_same_maxima(name, tmp_path):
    """A frame at every step: the largest of its cells is the column, to the bit, and that of all steps the result."""
    parallel = name == "parallel"
    scene, scheme = short(SCENES[name](), 8 if parallel else 30)
    assert tc.plan(scene).domains[0].small == (not parallel)
    steps = round(scene.duration / scheme.dt)
    result = quietly(
        tc.simulate, scene, scheme, out=tmp_path / "run", frames=steps + 1, fields=["von_mises", "pressure"]
    )
    data = ResultData.open(tmp_path / "run" / "result.vtkhdf")
    times = result.history["time"]
    assert result.ok
    assert np.array_equal(data.times, times)
    frames = [data.frame(index).cell_data for index in range(len(data))]
    starts = np.concatenate([[0], np.cumsum([body.mesh.cell_count for body in scene.bodies])])
    for quantity in ("von_mises", "pressure"):
        table = np.array([frame[quantity] for frame in frames])
        assert np.array_equal(result.history[f"{quantity}_max"], table.max(axis=1))
        found = result.maxima[quantity]
        assert found.value == table.max() > 0.0
        labels = [scene.label(index) for index in range(len(scene.bodies))]
        assert (
            table[np.flatnonzero(times == found.time)[0], starts[labels.index(found.body)] + found.cell] == found.value
        )
    assert result.maxima["pressure"].time > 0.0
    if "plastic_strain" in result.maxima:
        found, column = result.maxima["plastic_strain"], result.history["plastic_strain_max"]
        assert found.value == column.max() > 0.0
        strains = result.points[0][0][..., strain_place()].max(axis=1)
        number = scene.bodies[0].blocks[0].numbers
        cells = np.arange(scene.bodies[0].mesh.cell_count)[number]
        assert strains[np.flatnonzero(cells == found.cell)[0]] == found.value


def strain_place():
    """Place of the plastic strain in the state of a point."""
    from tcontact.kernels.materials import LAWS

    return LAWS[METAL.law].plastic.strain


def test_they_are_those_of_all_steps_with_a_thinned_history_or_without_frames(tmp_path):
    """Rows of many steps in a launch, every step, and every 7th row give the same; summary.json has them."""
    scene, scheme = short(SCENES["serial"](), 100)
    whole = tc.simulate(scene, scheme)
    thin = tc.simulate(scene, scheme, history_every=7, out=tmp_path / "run")
    assert thin.maxima == whole.maxima
    assert len(thin.history["time"]) < len(whole.history["time"]) / 5
    assert thin.history["von_mises_max"].max() < whole.history["von_mises_max"].max() == whole.maxima["von_mises"].value
    stored = json.loads((tmp_path / "run" / "summary.json").read_text())["maxima"]
    assert stored["pressure"] == vars(whole.maxima["pressure"])
    single = tc.simulate(scene, scheme, pressures=True)  # one row a launch
    assert single.maxima == whole.maxima
    for name in ("von_mises_max", "pressure_max"):
        assert np.array_equal(single.history[name], whole.history[name])


def test_the_motion_is_that_of_the_scene_without_them():
    scene, scheme = short(SCENES["metal"](), 20)
    bare = tc.Scene(scene.bodies, scene.obstacles, scene.duration)
    one, other = (quietly(tc.simulate, each, scheme) for each in (scene, bare))
    assert np.array_equal(one.position, other.position)
    assert all(np.array_equal(column, one.history[name]) for name, column in other.history.items())
    assert other.maxima == {}
    assert not {"von_mises_max", "pressure_max"} & other.history.keys()


def test_a_probe_of_a_metal_is_the_mean_of_its_cells_and_a_split_run_has_the_same_bits(monkeypatch, tmp_path):
    mesh = block()
    quantities = ("plastic_strain", "temperature", "stress", "acceleration")
    probes = [tc.Probe("lower", quantity) for quantity in quantities]
    body = tc.Body(mesh, METAL, (0.0, 0.0, -60.0), contact="zmin", probes=probes, name="bar")
    scene = tc.Scene(body, tc.Plane(), duration=1.0, maxima=["plastic_strain", "von_mises"])
    scene, scheme = short(scene, 30)
    whole, copies = copied(monkeypatch, tmp_path, scene, scheme, 9, frames=3)
    inside = mesh.cell_sets["lower"]
    volumes = mesh.cell_volumes()[inside]
    for name in ("plastic_strain", "temperature"):
        mean = (whole.metals[name][inside] * volumes).sum() / volumes.sum()
        assert whole.probes[f"bar_lower_{name}"][-1] == pytest.approx(mean, rel=1e-12)
    assert whole.probes["bar_lower_plastic_strain"][-1] > 0.0
    row = sorted(copies)[1]
    same(quietly(tc.resume, copies[row], scene, scheme), whole)
