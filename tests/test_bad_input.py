"""Wrong input is refused with field, value and remedy, before Taichi starts or a file is touched."""

import dataclasses
import pickle

import numpy as np
import pytest

import tcontact as tc

NAN, INF = float("nan"), float("inf")
HEX = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
NODES, CELLS = np.array(HEX.nodes), np.array(HEX.cells)
MAT = tc.NeoHookean(young=1e7, poisson=0.3, density=1000.0)
FLOOR = tc.Plane()


def body(mesh=HEX, material=MAT, **changes):
    return tc.Body(mesh, material, **{"contact": "zmin", **changes})


def scene(**changes):
    return tc.Scene(**{"bodies": [body()], "obstacles": [FLOOR], "duration": 1e-5, **changes})


def run(what=None, **options):
    return tc.simulate(scene() if what is None else what, **options)


def mesh(nodes=NODES, cells=CELLS, kind="hex8", **sets):
    return tc.Mesh(nodes, cells, kind, **sets)


def changed(array, index, value):
    copy = array.copy()
    copy[index] = value
    return copy


def thin(removal):
    plate = tc.box_mesh((1.0, 1.0, 0.2), (2, 2, 1))
    return scene(bodies=[body(plate, contact=["zmin", "zmax"])], contact=tc.MasslessContact(removal=removal))


def boom(_nodes):
    raise RuntimeError("no")


SWAPPED = changed(CELLS, 0, CELLS[0][[0, 1, 3, 2, 4, 5, 7, 6]])
SIDES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")
WRONG = {
    # materials
    "density < 0": lambda: tc.NeoHookean(1e7, 0.3, -1.0),
    "density 0": lambda: tc.LinearElastic(1e7, 0.3, 0.0),
    "density none": lambda: tc.LinearElastic(1e7, 0.3, None),
    "young 0": lambda: tc.StVenantKirchhoff(0.0, 0.3, 1.0),
    "young nan": lambda: tc.NeoHookean(NAN, 0.3, 1.0),
    "young text": lambda: tc.NeoHookean("soft", 0.3, 1.0),
    "young true": lambda: tc.NeoHookean(True, 0.3, 1.0),
    "poisson 0.5": lambda: tc.StVenantKirchhoff(1e7, 0.5, 1.0),
    "poisson -1": lambda: tc.NeoHookean(1e7, -1.0, 1.0),
    "poisson inf": lambda: tc.NeoHookean(1e7, INF, 1.0),
    "c1 0": lambda: tc.MooneyRivlin(0.0, 1.0, 1.0, 1.0),
    "c2 < 0": lambda: tc.MooneyRivlin(1.0, -1.0, 1.0, 1.0),
    "bulk 0": lambda: tc.MooneyRivlin(1.0, 1.0, 0.0, 1.0),
    "rubber nan": lambda: tc.MooneyRivlin(1.0, NAN, 1.0, 1.0),
    "rubber density": lambda: tc.MooneyRivlin(1.0, 1.0, 1.0, 0.0),
    "rubber share 1": lambda: tc.MooneyRivlin.of(1e7, 0.4, 1.0, second=1.0),
    "rubber poisson": lambda: tc.MooneyRivlin.of(1e7, 0.1, 1.0),
    "replaced density": lambda: dataclasses.replace(MAT, density=-3.0),
    # meshes
    "box cells 0": lambda: tc.box_mesh((1, 1, 1), (0, 1, 1)),
    "box cells float": lambda: tc.box_mesh((1, 1, 1), (1.5, 1, 1)),
    "box two counts": lambda: tc.box_mesh((1, 1, 1), (1, 1)),
    "box size < 0": lambda: tc.box_mesh((-1, 1, 1), (1, 1, 1)),
    "box size nan": lambda: tc.box_mesh((1, NAN, 1), (1, 1, 1)),
    "box kind": lambda: tc.box_mesh((1, 1, 1), (1, 1, 1), "hex20"),
    "box origin": lambda: tc.box_mesh((1, 1, 1), (1, 1, 1), origin=(INF, 0, 0)),
    "box too many cells": lambda: tc.box_mesh((1, 1, 1), (10**4, 10**4, 10**4)),
    "inverted cell": lambda: mesh(cells=SWAPPED),
    "flat mesh": lambda: mesh(nodes=NODES * [1, 1, 0]),
    "nan node": lambda: mesh(nodes=changed(NODES, (3, 1), NAN)),
    "2-D nodes": lambda: mesh(nodes=NODES[:, :2]),
    "node id too large": lambda: mesh(cells=changed(CELLS, (0, 0), 999)),
    "node id < 0": lambda: mesh(cells=changed(CELLS, (0, 0), -1)),
    "node twice in a cell": lambda: mesh(cells=changed(CELLS, (0, 1), CELLS[0, 0])),
    "double cell": lambda: mesh(cells=np.vstack([CELLS, CELLS[:1]])),
    "orphan node": lambda: mesh(nodes=np.vstack([NODES, [[9.0, 9, 9]]])),
    "no cells": lambda: mesh(cells=CELLS[:0]),
    "cells of other kind": lambda: mesh(kind="tet4"),
    "mesh kind": lambda: mesh(kind="brick"),
    "float cells": lambda: mesh(cells=CELLS + 0.5),
    "node set out of range": lambda: mesh(node_sets={"a": [1000]}),
    "empty node set": lambda: mesh(node_sets={"a": []}),
    "face of no cell": lambda: mesh(face_sets={"a": [[0, 1, 2, 26]]}),
    "sets not a dict": lambda: mesh(face_sets=[("a", [[0, 1, 4, 3]])]),
    "scale 0": lambda: HEX.scaled(0.0),
    "no rotation": lambda: HEX.rotated(np.ones((3, 3))),
    "missing file": lambda: tc.read_mesh("/nowhere/part.msh"),
    "file scale": lambda: tc.read_mesh("/nowhere/part.msh", scale=-1.0),
    # bodies and supports
    "body mesh": lambda: tc.Body(None, MAT),
    "body material": lambda: tc.Body(HEX, "steel"),
    "unknown contact set": lambda: body(contact="bottom"),
    "contact set number": lambda: body(contact=3),
    "no contact set": lambda: body(contact=[]),
    "contact set inside": lambda: body(mesh(face_sets={"a": [CELLS[0][[4, 5, 6, 7]]]}), contact="a"),
    "contact set on no face": lambda: body(mesh(node_sets={"a": [0, 1]}), contact="a"),
    "unknown support set": lambda: body(supports=[tc.Support("nowhere", "x")]),
    "support type": lambda: body(supports=["xmin"]),
    "support axes": lambda: tc.Support("xmin", "w"),
    "support no axes": lambda: tc.Support("xmin", ""),
    "support axes twice": lambda: tc.Support("xmin", "xx"),
    "support velocity": lambda: tc.Support("xmin", "x", velocity=NAN),
    "support velocities": lambda: tc.Support("xmin", "xy", velocity=(1.0, 2.0, 3.0)),
    "support set type": lambda: tc.Support(3, "x"),
    "supports disagree": lambda: body(supports=[tc.Support("xmin", "x"), tc.Support("zmin", "x", velocity=1.0)]),
    "all supported": lambda: body(tc.box_mesh((1, 1, 1), (1, 1, 1)), supports=[tc.Support(s, "xyz") for s in SIDES]),
    "velocity nan": lambda: body(velocity=(NAN, 0, 0)),
    "velocity of two": lambda: body(velocity=(1.0, 0)),
    "velocity of others": lambda: body(velocity=np.zeros((5, 3))),
    "velocity callable shape": lambda: body(velocity=lambda nodes: nodes[:, 0]),
    "velocity callable fails": lambda: body(velocity=boom),
    "displacement nan": lambda: body(displacement=(NAN, 0, 0)),
    "displacement of others": lambda: body(displacement=np.zeros((5, 3))),
    "displacement callable fails": lambda: body(displacement=boom),
    "displaced into the wall": lambda: scene(bodies=[body(displacement=(0, 0, -1e-3))]),
    "formulation": lambda: body(formulation="magic"),
    "reduced tets": lambda: body(tc.box_mesh((1, 1, 1), (1, 1, 1), "tet4"), formulation="reduced"),
    "periodic": lambda: body(periodic="w"),
    "empty name": lambda: body(name=""),
    # obstacles
    "normal 0": lambda: tc.Plane(normal=(0, 0, 0)),
    "normal of two": lambda: tc.Plane(normal=(0, 1)),
    "point nan": lambda: tc.Plane(point=(0, NAN, 0)),
    "plane name": lambda: tc.Plane(name=3),
    # scenes
    "no bodies": lambda: scene(bodies=[]),
    "body type": lambda: scene(bodies=[HEX]),
    "obstacle type": lambda: scene(obstacles=["wall"]),
    "duration 0": lambda: scene(duration=0.0),
    "duration < 0": lambda: scene(duration=-1.0),
    "duration inf": lambda: scene(duration=INF),
    "gravity number": lambda: scene(gravity=9.81),
    "gravity nan": lambda: scene(gravity=(0, 0, NAN)),
    "contact word": lambda: scene(contact="massless"),
    "friction": lambda: scene(friction=0.3),
    "damping": lambda: scene(damping=0.1),
    "same names": lambda: scene(bodies=[body(name="a"), body(HEX.translated((9, 0, 0)), name="a")]),
    "starts in the wall": lambda: scene(bodies=[body(HEX.translated((0, 0, -2e-6)))]),
    # contact models and schemes
    "removal": lambda: tc.MasslessContact(removal="half"),
    "penalty < 0": lambda: tc.MasslessContact(penalty=-1.0),
    "depth 0": lambda: tc.MasslessContact(depth=0),
    "depth 1.5": lambda: tc.MasslessContact(depth=1.5),
    "sweeps 0": lambda: tc.MasslessContact(sweeps=0),
    "tolerance 0": lambda: tc.MasslessContact(tolerance=0.0),
    "tolerance nan": lambda: tc.MasslessContact(tolerance=NAN),
    "stiffness 0": lambda: tc.PenaltyContact(0.0),
    "cfl 0": lambda: tc.CentralDifference(cfl=0.0),
    "cfl text": lambda: tc.CentralDifference(cfl="fast"),
    "dt < 0": lambda: tc.CentralDifference(dt=-1.0),
    "dt inf": lambda: tc.CentralDifference(dt=INF),
    "cfl and dt": lambda: tc.CentralDifference(cfl=0.5, dt=1e-5),
}
RUNS = {
    "scene type": lambda out: tc.simulate("scene", out=out),
    "scheme word": lambda out: run(scheme="leapfrog", out=out),
    "scheme type": lambda out: run(scheme=0.9, out=out),
    "arch": lambda out: run(arch="abacus", out=out),
    "threads 0": lambda out: run(threads=0, out=out),
    "threads 1.5": lambda out: run(threads=1.5, out=out),
    "frames < 0": lambda out: run(frames=-1, out=out),
    "frames 2.5": lambda out: run(frames=2.5, out=out),
    "history_every 0": lambda out: run(history_every=0, out=out),
    "initial type": lambda out: run(initial="start", out=out),
    "initial of other cells": lambda out: run(
        initial=run(scene(bodies=[body(tc.box_mesh((1, 1, 1), (2, 2, 3)))])), out=out
    ),
    "thin body": lambda out: run(thin("normal"), out=out),
    "thin body, full": lambda out: run(thin("full"), out=out),
    "out number": lambda out: run(out=3),
}


def refused(call, *arguments):
    with pytest.raises(tc.InputError) as caught:
        call(*arguments)
    error = caught.value
    assert isinstance(error, ValueError)
    assert isinstance(error.field, str)
    assert error.field
    assert len(error.remedy.split()) >= 2
    assert str(error).startswith(f"{error.field} = ")
    assert str(error).endswith(f": {error.remedy}")


@pytest.mark.parametrize("name", WRONG)
def test_wrong_values_are_refused_where_they_are_given(name):
    refused(WRONG[name])


@pytest.mark.parametrize("name", RUNS)
def test_wrong_runs_are_refused_and_write_nothing(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused(RUNS[name], tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_there_are_many_and_the_right_values_pass(tmp_path):
    assert len(WRONG) + len(RUNS) >= 100
    assert run(out=tmp_path / "out").ok


def test_a_folder_with_another_run_and_a_file_are_refused(tmp_path):
    run(out=tmp_path / "one")
    before = {path: path.read_bytes() for path in (tmp_path / "one").iterdir()}
    refused(lambda: run(out=tmp_path / "one"))
    assert {path: path.read_bytes() for path in (tmp_path / "one").iterdir()} == before
    (tmp_path / "file").write_text("mine")
    refused(lambda: run(out=tmp_path / "file"))
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("name", ["file/below", "null\0byte"])
def test_a_folder_that_cannot_be_made_is_refused(tmp_path, name):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(tc.InputError) as caught:
        run(out=str(tmp_path / name), frames=2)
    assert caught.value.field == "out"
    assert caught.value.remedy
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_what_is_no_scene_is_refused_by_the_plan_too():
    with pytest.raises(tc.InputError, match=r"tcontact\.Scene"):
        tc.plan("scene")


def test_progress_is_true_or_false():
    with pytest.raises(tc.InputError, match="progress"):
        run(progress="bar")


@pytest.mark.parametrize(
    ("contact", "options", "text"),
    [
        ("zmin", {"obstacles": tc.Plane((0, 0, -1)), "contact": None}, "contact=None"),
        (None, {"obstacles": tc.Plane((0, 0, -1))}, "no Body.contact"),
        ("zmin", {"friction": tc.Coulomb(0.3)}, "no obstacles"),
    ],
)
def test_what_cannot_act_is_warned_about(contact, options, text):
    body = tc.Body(tc.box_mesh((1, 1, 1), (2, 2, 2)), tc.NeoHookean(1e6, 0.3, 1000.0), contact=contact)
    with pytest.warns(UserWarning, match=text):
        tc.Scene(body, duration=1e-3, **options)


def test_messages_show_numbers_as_they_are_written():
    """Not np.float64(0.5): what a user reads is what a user may type."""
    for value, shown in (
        (np.float64(-1.0), "-1.0"),
        ((np.float64("nan"), 0, np.int64(3)), "(nan, 0, 3)"),
        ({"a": np.bool_(True)}, "{'a': True}"),
    ):
        assert str(tc.InputError("field", value, "remedy")) == f"field = {shown}: remedy"


def test_an_empty_folder_name_is_not_this_folder():
    with pytest.raises(tc.InputError, match="give a folder name"):
        run(out="")


def test_errors_come_back_from_other_processes():
    """A value that cannot be pickled arrives as its text."""
    for value in (3.5, lambda t: t):
        error = tc.InputError("Scene.gravity", value, "use three numbers")
        again = pickle.loads(pickle.dumps(error))
        assert isinstance(again, tc.InputError)
        assert (str(again), again.field, again.remedy) == (str(error), error.field, error.remedy)


def test_a_name_ends_where_its_text_ends():
    """Files would keep what is before a null character, or could not hold it; pictures could not draw it."""
    for name in ("a\nb", "caf\udce9"):
        with pytest.raises(tc.InputError, match="cannot be printed"):
            body(name=name)
    with pytest.raises(tc.InputError, match="null character"):
        body(name="lower\0upper")


def test_bodies_of_any_stiffness_have_an_order():
    """The ratio of these two is beyond the largest number."""
    low = tc.box_mesh((1.0, 1.0, 1.0), (1, 1, 1), origin=(0.0, 0.0, -1.5))
    for young in (1e-320, 1e-305):
        bodies = [body(HEX, tc.LinearElastic(young, 0.3, 1.0)), body(low, contact="zmax")]
        assert scene(bodies=bodies, obstacles=[]).body_pairs[0].slave == 0


def test_masked_values_are_refused_and_an_array_of_no_dimension_gets_its_remedy():
    with pytest.raises(tc.InputError, match="normal"):
        tc.Plane(normal=np.ma.array([0.0, 0.0, 1.0], mask=[1, 0, 0]))
    with pytest.raises(tc.InputError, match=r"young.*float\(\.\.\) makes one"):
        tc.NeoHookean(young=np.array(1e6), poisson=0.3, density=1e3)
    with pytest.raises(tc.InputError, match="leave it out for all cores"):
        run(threads=np.float64(1.0))
