"""Scenes as TOML: what is written and read again gives the same run, bit for bit; refusals name the place."""

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
import surfaces
from mesh_files import box
from scenes import block, material

import tcontact as tc
from tcontact import friction_layer
from tcontact.commands.cli import main
from tcontact.commands.run_scene import read_scene
from tcontact.run.scene_files.classes import RUN, SURFACE, keys_of, words_of
from tcontact.run.scene_files.read import ARRAYS, FILE, ROUND
from tcontact.run.scene_files.read import BOX as BOX_KEYS
from tcontact.run.scene_files.toml import to_toml
from tcontact.scene.own_laws import OWN

MAT = material()
BOX = tc.box_mesh((0.1, 0.2, 0.1), (2, 3, 2), origin=(0.1, -0.3, 1 / 3))
ROOT = Path(__file__).resolve().parents[1]


def scene(**changes):
    body = changes.pop("body", None) or tc.Body(BOX, MAT, velocity=(0, 0, -3.0), contact="zmin", name='a "b" \\')
    given = {"bodies": [body], "obstacles": [tc.Plane(point=(0, 0, 0.33))], "duration": 2e-4}
    return tc.Scene(**{**given, **changes})


def bodies_of_all_kinds():
    hexes = block("hex8", 2)
    tets = block("tet4", 2, shift=(2.0, 0, 0)).with_sets(node_sets={"some of [them]": [0, 3, 4]})
    bar = tc.box_mesh((0.1, 0.1, 0.3), (2, 2, 3), origin=(5.0, 0, 0))
    moving = np.random.default_rng(1).normal(size=(tets.node_count, 3))
    return [
        tc.Body(hexes, MAT, velocity=lambda x: x * [0, 0, -1.0], contact=["zmin", "xmin"], formulation="reduced"),
        tc.Body(
            tets, material("linear"), velocity=moving, displacement=(0, 0, 1e-5), contact="zmin",
            supports=[tc.Support("xmax", "xy", velocity=(0.5, 1 / 3)), tc.Support("some of [them]", "z")],
            probes=[tc.Probe("some of [them]", "velocity"), tc.Probe("xmax", "stress")],
        ),
        tc.Body(bar, material("svk"), velocity=(0, 0, -1), contact="auto", periodic="xy", name="bar"),
    ]  # fmt: skip


WARM = dataclasses.replace(friction_layer.COPPER, density=8900.0)
FLOOR = tc.Plane(point=(0, 0, -1e-3), normal=(0, 0, 1 / 3), velocity=(0, 0, 0.1), name="floor")
SCENES = {
    "least": lambda: scene(),
    "bodies": lambda: scene(
        bodies=bodies_of_all_kinds(),
        obstacles=[FLOOR],
        gravity=(0, 0, -1 / 3),
        damping=tc.MassDamping(0.3),
        viscosity=tc.BulkViscosity(linear=0.1),
        maxima=["pressure"],
        contact=tc.MasslessContact(removal="full", sweeps=12, tolerance=1e-5),
    ),
    "shapes": lambda: scene(
        obstacles=[
            tc.Sphere(center=(0, 0, -3.0), radius=0.4, angular_velocity=(0, 1, 0)),
            tc.Cylinder(axis=(1, 1, 0), radius=20, inside=True),
            tc.Box(center=(0, 0, -2), axes=np.eye(3)[[1, 2, 0]]),
            tc.Sdf.from_surface(surfaces.sphere(8, 8, 0.2), cells=8, name="ball"),
        ],
        friction=tc.Coulomb(0.3),
        duration=1e-5,
    ),
    "penalty": lambda: scene(contact=tc.PenaltyContact(1e9), friction=tc.RegularizedCoulomb(0.2, 0.1)),
    "impulse": lambda: scene(contact=tc.ImpulseContact()),
    "friction by partner": lambda: scene(
        obstacles=[
            tc.Plane((0, 0, -1), friction=tc.Coulomb(static=0.4, kinetic=0.2, decay=3.0, limit=1e6)),
            tc.Sphere((0, 0, -3.0), friction=tc.FrictionTable([0, 0.5], [0, 1e5, 2e5], [[0.4, 0.3, 0.2], [0.1] * 3])),
            tc.Box((0, 0, -3.0), friction=tc.NoFriction()),
            tc.Sdf.from_surface(surfaces.sphere(8, 8, 0.2), cells=8, friction=tc.Coulomb(0.1)),
        ],
        duration=1e-5,
    ),
    "nothing": lambda: scene(contact=None, obstacles=[]),
    "rubber": lambda: scene(body=tc.Body(BOX, material("mooney"), contact="zmin")),
    "metals": lambda: scene(
        body=tc.Body(BOX, MAT, velocity=(0, 0, -3.0), contact="zmin", metal=friction_layer.COPPER),
        obstacles=[
            tc.Plane(point=(0, 0, 0.33), metal=friction_layer.STAINLESS_304),
            tc.Sdf.from_surface(surfaces.sphere(8, 8, 0.2), cells=8, metal=WARM),
        ],
        friction=tc.FrictionLayer(),
        duration=1e-5,
    ),
    "layer": lambda: scene(friction=tc.FrictionLayer(friction_layer.COPPER, points=8, reload=False), duration=1e-5),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_comes_back_as_it_was(name, tmp_path):
    """Written again it gives the same files; its plan and its fields are the same to the bit."""
    first = SCENES[name]()
    scheme = tc.CentralDifference(cfl=0.7)
    tc.save_scene(first, tmp_path / "one.toml", scheme=scheme, frames=3, threads=None)
    second, options = tc.load_scene(tmp_path / "one.toml")
    assert options == {"scheme": scheme, "frames": 3}
    assert tc.plan(second).describe() == tc.plan(first).describe()
    for a, b in zip(first.bodies, second.bodies, strict=True):
        assert np.array_equal(a.initial_nodes, b.initial_nodes)
        assert np.array_equal(a.initial_velocity, b.initial_velocity)
        assert np.array_equal(a.prescribed, b.prescribed, equal_nan=True)
        assert np.array_equal(a.contact_faces, b.contact_faces)
        assert (a.material, a.name, a.formulation, a.periodic) == (b.material, b.name, b.formulation, b.periodic)
        assert (a.metal, a.probes) == (b.metal, b.probes)
        for ours, theirs in ((a.mesh.node_sets, b.mesh.node_sets), (a.mesh.face_sets, b.mesh.face_sets)):
            assert {k: v.tolist() for k, v in ours.items()} == {k: v.tolist() for k, v in theirs.items()}
    for part in ("contact", "friction", "damping", "viscosity", "duration", "maxima"):
        assert getattr(second, part) == getattr(first, part)
    points = np.random.default_rng(2).normal(size=(50, 3))
    for a, b in zip(first.obstacles, second.obstacles, strict=True):
        assert np.array_equal(a.gap(points), b.gap(points))
        assert np.array_equal(a.normal_at(points), b.normal_at(points))
        assert (a.name, a.moves, a.metal, a.friction) == (b.name, b.moves, b.metal, b.friction)


def test_it_runs_to_the_same_bits(tmp_path):
    shaken = block("hex8", 3, shift=(0, 0, 1e-4))
    speeds = np.random.default_rng(3).normal(size=(shaken.node_count, 3)) - [0, 0, 5.0]
    body = tc.Body(shaken, MAT, velocity=speeds, contact="auto", supports=[tc.Support("zmax", "x", velocity=1 / 3)])
    first = scene(body=body, obstacles=[tc.Plane()], duration=1e-3, contact=tc.MasslessContact(removal="full"))
    tc.save_scene(first, tmp_path / "scene.toml")
    runs = [tc.simulate(one) for one in (first, tc.load_scene(tmp_path / "scene.toml")[0])]
    assert runs[0].history["contact_nodes"].max() > 0
    assert np.array_equal(runs[0].position, runs[1].position)
    assert np.array_equal(runs[0].velocity, runs[1].velocity)


GOOD = """
duration = 1e-5
[[bodies]]
mesh = { box = [1, 1, 1], cells = [2, 2, 2] }
material = { type = "NeoHookean", young = 1e7, poisson = 0.3, density = 1e3 }
contact = "zmin"
[[obstacles]]
type = "Plane"
"""
BAD = {
    "typo": ("young", "yuong", "did you mean 'young'"),
    "key": ("duration", "span = 1\nduration", "span = 1: unknown key; known are "),
    "near key": ("duration", "frictoin = 1\nduration", "unknown key; did you mean 'friction'? Known are "),
    "law": ('"NeoHookean"', '"Rubber"', "NeoHookean"),
    "no type": ('type = "Plane"', "", "obstacles[0].type = (missing): use one of"),
    "no duration": ("duration = 1e-5", "", "duration"),
    "no material": ("material", "name", "bodies[0].material"),
    "number": ("young = 1e7", "young = -1", "bodies[0].material: young"),
    "nan": ("young = 1e7", "young = nan", "bodies[0].material: young"),
    "set": ('"zmin"', '"bottom"', "bodies[0]: set"),
    "mesh file": ("box = [1, 1, 1], cells = [2, 2, 2]", 'file = "part.msh"', "no such file"),
    "mesh npz": ("box = [1, 1, 1], cells = [2, 2, 2]", 'file = "part.npz"', "no such file"),
    "mesh number": ("box = [1, 1, 1], cells = [2, 2, 2]", "file = 3", "bodies[0].mesh"),
    "mesh missing": ("box = [1, 1, 1], cells = [2, 2, 2]", "size = 3", "bodies[0].mesh"),
    "box missing": (", cells = [2, 2, 2]", "", "bodies[0].mesh"),
    "bodies": ("[[bodies]]", "[bodies]", "list of tables"),
    "run": ("duration", "run = { color = 3 }\nduration", "run.color"),
    "scheme": ("duration", "run = { scheme = { cfl = -3 } }\nduration", "run.scheme: cfl"),
    "velocity": ("contact =", 'velocity = { file = "none.npz", array = "v" }\ncontact =', "none.npz"),
    "velocity number": ("contact =", "velocity = 3\ncontact =", "bodies[0]: Body.velocity"),
    "supports": ("contact =", "supports = [3]\ncontact =", "bodies[0].supports"),
    "support": ("contact =", 'supports = [{ set = "xmin" }]\ncontact =', "bodies[0].supports[0]"),
    "friction": ("duration", 'friction = "much"\nduration', "friction"),
    "metal of an obstacle": ("[[obstacles]]", '[[obstacles]]\nmetal = "WOOD"', "obstacles[0].metal"),
    "metal of a body": ("[[bodies]]", "[[bodies]]\nmetal = 3", "bodies[0].metal"),
    "metal": ("duration", 'friction = { type = "FrictionLayer", material = "WOOD" }\nduration', "friction.material"),
    "syntax": ("[[bodies]]", "[[bodies", "TOML"),
    "twice": ("duration = 1e-5", "duration = 1\nduration = 2", "TOML"),
}


@pytest.mark.parametrize("name", BAD)
def test_refusals_name_the_place_in_the_file(name, tmp_path, capsys):
    old, new, said = BAD[name]
    file = tmp_path / "scene.toml"
    assert old in GOOD
    file.write_text(GOOD.replace(old, new))
    with pytest.raises(tc.InputError) as caught:
        tc.load_scene(file)
    assert said in str(caught.value)
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"\xff\xfe", b"\0", b"[" * 5000, b""])
def test_what_is_no_toml_is_refused(content, tmp_path):
    (tmp_path / "a.toml").write_bytes(content)
    with pytest.raises(tc.InputError):
        tc.load_scene(tmp_path / "a.toml")


@pytest.mark.parametrize("path", [None, 3, "nowhere.toml", "a\0b.toml"])
def test_what_is_no_file_is_refused(path):
    with pytest.raises(tc.InputError, match="path"):
        tc.load_scene(path)


def test_an_error_of_a_box_names_the_key_of_the_file(tmp_path):
    (tmp_path / "scene.toml").write_text(
        """duration = 1.0
        [[bodies]]
        mesh = { box = [1.0, -1.0, 1.0], cells = [1, 1, 1] }
        material = { type = "LinearElastic", young = 1.0, poisson = 0.0, density = 1.0 }
        """
    )
    with pytest.raises(tc.InputError) as caught:
        tc.load_scene(tmp_path / "scene.toml")
    assert caught.value.field == "bodies[0].mesh: box"


def test_a_motion_that_is_a_function_is_refused():
    with pytest.raises(tc.InputError, match="function of time"):
        tc.save_scene(scene(obstacles=[tc.Plane(point=(0, 0, -1), velocity=lambda t: (0, 0, t))]), "never.toml")


def test_numbers_of_numpy_are_numbers(tmp_path):
    parts = {
        "point_masses": [tc.PointMass("zmax", np.float64(0.2)), tc.PointMass("zmin", np.int64(2))],
        "springs": [tc.Spring("zmax", np.float64(5.0), to=(0.0, 0.0, 3.0), rest_length=np.float64(1.5))],
    }
    body = tc.Body(box("hex8"), tc.NeoHookean(1e7, 0.3, 1e3), **parts)
    tc.save_scene(tc.Scene([body], duration=1e-5), tmp_path / "scene.toml", history_every=np.int64(2))
    loaded, options = tc.load_scene(tmp_path / "scene.toml")
    assert options == {"history_every": 2}
    assert (loaded.bodies[0].point_masses, loaded.bodies[0].springs) == (body.point_masses, body.springs)


def test_a_scene_replaces_no_arrays_that_are_not_its_own(tmp_path):
    block = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
    shaken = tc.Mesh(block.nodes + 0.01 * np.random.default_rng(0).random(block.nodes.shape), block.cells, "hex8")
    own = tc.Scene([tc.Body(shaken, tc.NeoHookean(1e7, 0.3, 1e3))], duration=1e-5)
    with pytest.raises(tc.InputError, match="TOML file"):
        tc.save_scene(own, tmp_path / "scene.npz")
    with pytest.raises(tc.InputError, match="scenes are written as TOML"):
        tc.save_scene(own, tmp_path / "scene.json")
    (tmp_path / "part-mesh-0.npz").write_bytes(b"of somebody")
    with pytest.raises(tc.InputError, match=r"part-mesh-0\.npz is there already"):
        tc.save_scene(own, tmp_path / "part.toml")
    assert [path.name for path in tmp_path.iterdir()] == ["part-mesh-0.npz"]
    for _ in range(2):  # its own are replaced
        tc.save_scene(own, tmp_path / "scene.toml")
    assert np.array_equal(tc.load_scene(tmp_path / "scene.toml")[0].bodies[0].mesh.nodes, shaken.nodes)


@pytest.mark.parametrize(("other", "name"), [("run.2", "run.1"), ("stem.toml", "stem.txt")])
def test_a_scene_replaces_no_arrays_of_another_scene_of_its_stem(other, name, tmp_path):
    """The file that is replaced must refer to the arrays; that it is there does not make them its own."""
    block, law = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)), tc.NeoHookean(1e7, 0.3, 1e3)

    def scene(speed):
        velocity = None if speed is None else np.full((block.node_count, 3), speed)
        return tc.Scene([tc.Body(block, law, **({} if speed is None else {"velocity": velocity}))], duration=1e-5)

    tc.save_scene(scene(None), tmp_path / name)
    for speed in (1.0, 2.0):  # its own arrays are replaced
        tc.save_scene(scene(speed), tmp_path / other)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(tc.InputError, match=r"\.npz is there already, .* remove it if no other scene needs it"):
        tc.save_scene(scene(5.0), tmp_path / name)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    assert tc.load_scene(tmp_path / other)[0].bodies[0].initial_velocity[0, 0] == 2.0


def test_a_scene_that_cannot_be_written_leaves_the_one_before(tmp_path, monkeypatch):
    """Text and arrays of the old file stay together, and no part of the new one; a symbolic link is followed."""
    block, file, link = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2)), tmp_path / "scene.toml", tmp_path / "link.toml"
    law, random = tc.NeoHookean(1e7, 0.3, 1e3), np.random.default_rng(0)
    shaken = [tc.Mesh(block.nodes + 0.01 * random.random(block.nodes.shape), block.cells, "hex8") for _ in range(2)]
    before, after = (tc.Scene([tc.Body(mesh, law)], duration=1e-5) for mesh in shaken)
    tc.save_scene(before, file)
    names, write = sorted(path.name for path in tmp_path.iterdir()), np.savez_compressed

    def fail(stream, **arrays):
        write(stream, **arrays)
        raise OSError("No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(np, "savez_compressed", fail)
        with pytest.raises(tc.InputError, match=r"cannot be written \(No space left"):
            tc.save_scene(after, file)
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    assert np.array_equal(tc.load_scene(file)[0].bodies[0].mesh.nodes, shaken[0].nodes)
    link.symlink_to(file)
    tc.save_scene(tc.Scene([tc.Body(block, law)], duration=2e-5), link)
    assert link.is_symlink()
    assert tc.load_scene(file)[0].duration == 2e-5
    with pytest.raises(tc.InputError, match="path = '/dev/null'"):
        tc.save_scene(before, "/dev/null")


def test_a_mark_of_the_byte_order_is_no_part_of_the_text(tmp_path):
    (tmp_path / "scene.toml").write_bytes(b"\xef\xbb\xbf" + GOOD.encode())
    assert tc.load_scene(tmp_path / "scene.toml")[0].duration == 1e-5


def test_the_scene_file_of_the_page_on_scenes_is_a_scene(tmp_path):
    """It is read and planned with every term that it names, and its keys are all of those of the scene and of [run]."""
    page = (ROOT / "docs/SCENES.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, flags=re.DOTALL)
    points, triangles = surfaces.sphere(8, 8, 10.0)
    corners = np.add(points, (50.0, 50.0, -12.0))[triangles]
    facet = "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n"
    body = "".join(facet.format("".join("vertex {} {} {}\n".format(*corner) for corner in three)) for three in corners)
    (tmp_path / "die.stl").write_text(f"solid die\n{body}endsolid die\n")
    (tmp_path / "scene.toml").write_text(text)
    found, options = tc.load_scene(tmp_path / "scene.toml")
    assert set(options) == set(RUN)
    assert all(re.search(rf"^(\[\[)?{key}\b", text, flags=re.MULTILINE) for key in keys_of(tc.Scene))
    assert (found.friction, found.obstacles[0].friction) == (tc.Coulomb(0.2), tc.Coulomb(0.4))
    assert np.ptp(found.obstacles[1].surface[0], axis=0).max() == pytest.approx(0.02)
    terms = tc.plan(found).terms
    assert {"coulomb-friction", "mass-damping", "bulk-viscosity", "gravity", "loads", "probes", "maxima"} <= set(terms)
    assert [pair.name for pair in found.body_pairs] == ["block-ball"]


def test_the_keys_in_the_tables_of_the_page_on_scenes_are_those_of_the_reader():
    """Kinds of meshes, options of a box, a file and a surface, arguments of bodies, obstacles and pairs are named."""
    page = (ROOT / "docs/SCENES.md").read_text(encoding="utf-8").partition("## Keys of a scene file")[2]
    names = {*BOX_KEYS, *FILE, *ARRAYS, *ROUND, *SURFACE}
    names |= {word for place in ("material", "obstacles", "contact", "scheme") for word in words_of(place)}
    for kind in (tc.Body, tc.Pair, tc.Plane, tc.Sphere, tc.Cylinder, tc.Box):
        names |= {*keys_of(kind)}
    assert {name for name in names if not re.search(rf"\b{name}\b", page)} <= set(OWN)


SURFACES = {
    '{ file = "die.stl" }': 'write surface = "die.stl" and scale = 1e-3 beside it',
    "{ }": "give its points too",
    "{ points = [[0, 0, 0]] }": "give its triangles too",
    "{ points = [[0, 0], [1]], triangles = [[0, 0, 0]] }": "surface points",
    "{ points = [[0, 0, nan]], triangles = [[0, 0, 0]] }": "surface points",
    "{ points = [[0, 0, 0]], triangles = [[0, 0, 1]] }": "surface triangles",
    "{ points = [[0, 0, 0]], triangles = [0, 0, 0] }": "surface triangles",
    "{ points = [[0, 0, 0]], triangles = [[0.5, 0, 0]] }": "surface triangles",
}


@pytest.mark.parametrize("surface", SURFACES)
def test_the_surface_of_a_sampled_distance_is_checked(surface, tmp_path):
    np.savez(tmp_path / "grid.npz", distance=np.indices((4, 4, 4))[2] - 1.5)
    grid = 'origin = [0, 0, -3]\nspacing = 1.0\ndistance = { file = "grid.npz", array = "distance" }\n'
    (tmp_path / "scene.toml").write_text(GOOD.replace('"Plane"', f'"Sdf"\n{grid}surface = {surface}'))
    with pytest.raises(tc.InputError, match=SURFACES[surface]) as caught:
        tc.load_scene(tmp_path / "scene.toml")
    assert caught.value.field.startswith("obstacles[0]")


def test_a_sampled_distance_that_is_missing_is_asked_for(tmp_path):
    """Without a file of triangles, which most have, and beside triangles of pictures."""
    surface = "surface = { points = [[0, 0, 0]], triangles = [[0, 0, 0]] }\n"
    for lines, key in (("", "surface"), ("spacing = 0.1\n", "surface"), (surface, "distance")):
        (tmp_path / "scene.toml").write_text(GOOD.replace('"Plane"', f'"Sdf"\n{lines}'))
        with pytest.raises(tc.InputError, match=r'give a file of triangles, such as surface = "die.stl"') as caught:
            tc.load_scene(tmp_path / "scene.toml")
        assert caught.value.field == f"obstacles[0].{key}"


def test_mesh_files_lie_beside_the_scene(tmp_path):
    import meshio

    part = box("tet4")
    meshio.Mesh(part.nodes, [("tetra", part.cells)]).write(tmp_path / "part.vtu")
    old = "box = [1, 1, 1], cells = [2, 2, 2]"
    text = (
        GOOD.replace(old, 'file = "part.vtu", scale = 1e-3')
        .replace('"zmin"', '"auto"')
        .replace("Plane", 'Plane"\npoint = [0, 0, -1e-6]\nname = "f')
    )
    (tmp_path / "scene.toml").write_text(text)
    loaded, _ = tc.load_scene(tmp_path / "scene.toml")
    assert np.allclose(loaded.bodies[0].mesh.nodes, part.nodes * 1e-3)


def test_the_command_writes_the_files_of_a_run_and_the_readme_shows_how(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (text,) = re.findall(r"```toml\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL)
    smaller = text.replace("[16, 16, 16]", "[3, 3, 3]")
    assert smaller != text
    Path("drop.toml").write_text(smaller)
    assert main(["run", "drop.toml", "--frames", "2", "--set", "cfl=0.8"]) == 0
    written = {path.name for path in Path("runs/drop").iterdir()}
    assert written >= {"summary.json", "history.csv", "result.vtkhdf", "contact-force.png", "gap.png", "energy.png"}
    summary = json.loads(Path("runs/drop/summary.json").read_text())
    assert summary["passed"]
    assert summary["dt"] == pytest.approx(0.8 * summary["dt_limit"], rel=1e-2)
    assert "files in runs/drop" in capsys.readouterr().out
    Path("drop.toml").write_text(smaller.replace("[run]", '[run]\narch = "cuda"\nframes = 9'))
    over = ["--frames", "2", "--arch", "cpu", "--quiet", "--force"]
    assert main(["run", "drop.toml", *over]) == 0, "options of the command line go before those of the file"
    assert len(list(Path("runs/drop/frames").iterdir())) == 2
    assert main(["run", "drop.toml", "--frames", "0"]) == 2
    assert main(["run", "drop.toml", "--set", "cells=3", "--force"]) == 2


def test_a_setting_changes_the_scheme_of_the_file(tmp_path):
    scheme = '{ type = "hilber-hughes-taylor", dt = 1e-4, alpha = -0.2 }'
    (tmp_path / "scene.toml").write_text(GOOD + f"\n[run]\nscheme = {scheme}\n")
    found = read_scene(tmp_path / "scene.toml", ["dt=5e-5"])[1]
    assert found == tc.HilberHughesTaylor(dt=5e-5, alpha=-0.2)


def test_text_is_escaped_as_toml_wants_it():
    from tcontact.run.scene_files.read import tomllib

    data = {
        "a b": 'x"\\\n\t\r\x01\x7fé',
        "n": [1, 2.5, float("inf"), True],
        "t": {"k": {"deep": ["é"]}},
        "l": [{"x": -0.0}],
    }
    assert tomllib.loads(to_toml(data)) == data
