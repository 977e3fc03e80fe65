"""Names that are nearly right, texts and pictures of scenes and meshes, meshes of other packages, types of a script."""

from __future__ import annotations

import importlib.util
import io
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

import tcontact as tc
from tcontact.base.errors import hint
from tcontact.commands.cli import main

mpl.use("Agg")
ROOT = Path(__file__).resolve().parent.parent
LAW = tc.NeoHookean(1e6, 0.3, 1000.0)


def scene(bodies=1):
    parts = [
        tc.Body(tc.box_mesh((1, 1, 1), (3, 3, 3), origin=(1.5 * k, 0, 0)), LAW, contact="zmin", name=f"block-{k}")
        for k in range(bodies)
    ]
    return tc.Scene(parts, [tc.Plane(name="floor")], 1e-3, gravity=(0, 0, -9.81), friction=tc.Coulomb(0.3))


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (["run", "cube_impact"], "'cube-impact'"),
        (["run", "cubeimpact"], "'cube-impact'"),
        (["run", "Cube-Impact"], "'cube-impact'"),
        (["run", "cube-impact", "--set", "cell=3"], "'cells'"),
        (["run", "cube-impact", "--set", "scheme=discrete_gradient"], "'discrete-gradient'"),
        (["study", "bar_impact"], "'bar-impact'"),
    ],
)
def test_a_name_that_is_nearly_right_gets_the_right_one(words, wanted, capsys):
    assert main(words) == 2
    assert f"did you mean {wanted}?" in capsys.readouterr().err


def test_so_do_names_in_python():
    mesh = tc.box_mesh((1, 1, 1), (1, 1, 1))
    for call, wanted in (
        (lambda: tc.NeoHooken, "NeoHookean"),
        (lambda: mesh.faces_of("z_min"), "zmin"),
        (lambda: tc.metal("steel4340"), "steel-4340"),
        (lambda: tc.simulate(scene(), "discrete_gradient"), "discrete-gradient"),
        (lambda: tc.simulate(scene(), out="x", fields=["von_mise"]), "von_mises"),
    ):
        with pytest.raises((tc.InputError, AttributeError), match=f"did you mean '{wanted}'"):
            call()
    assert hint("banana", ["zmin", "zmax"]) == hint(3, ["zmin"]) == hint("zmin", []) == ""


def test_texts_are_a_few_lines():
    several = scene(9)
    assert len(repr(several).splitlines()) <= 12
    assert "and 3 more bodies" in repr(several)
    assert "floor Plane" in repr(several)
    assert repr(scene().bodies[0]) == "Body(27 hex8 cells, 64 nodes; NeoHookean; contact zmin)"
    plan = repr(tc.plan(scene()))
    assert len(plan) < 2000
    assert "massless-contact" in plan
    assert len(repr(tc.simulate(scene()))) < 200


def picture(data: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(data)))


def test_scenes_and_meshes_have_pictures_for_a_notebook():
    one, two = picture(scene()._repr_png_()), picture(scene(2)._repr_png_())
    assert one.shape == two.shape == (480, 640, 3)
    orange = np.abs(two.astype(int) - (240, 160, 75)).sum(axis=2) < 90
    assert orange.sum() > 1000  # the second body has a colour of its own
    assert not (np.abs(one[:, :500].astype(int) - (240, 160, 75)).sum(axis=2) < 90).any()
    assert picture(tc.ball_mesh(0.1, 2)._repr_png_()).std() > 5.0


def test_a_mesh_is_plotted_with_its_sets():
    mesh = tc.box_mesh((2, 1, 1), (4, 2, 2))
    axes = mesh.plot("zmin")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["zmin"]
    assert axes.get_xlim() == (0.0, 2.0)
    assert len(axes.collections) == 2
    assert mesh.plot(axes=axes) is axes
    with pytest.raises(tc.InputError, match="zmin"):
        mesh.plot("bottom")
    for wrong in (3, mpl.pyplot.figure().add_subplot()):
        with pytest.raises(tc.InputError, match=r"axes = .* in three dimensions"):
            mesh.plot(axes=wrong)
    mpl.pyplot.close("all")


def test_a_mesh_comes_from_meshio_with_its_sets():
    import meshio

    box = tc.box_mesh((1, 1, 2), (2, 2, 2))
    faces = box.faces_of("zmin")
    other = meshio.Mesh(
        1e3 * box.nodes,
        [("hexahedron", box.cells), ("quad", faces)],
        cell_data={"region": [np.repeat([1, 2], 4), np.zeros(len(faces), int)]},
        point_sets={"corner": np.array([0])},
        cell_sets={"bottom": [None, np.arange(len(faces))], "half": [np.arange(4), None]},
    )
    mesh = tc.Mesh.from_meshio(other, scale=1e-3)
    np.testing.assert_allclose(mesh.nodes, box.nodes)
    np.testing.assert_array_equal(mesh.cells, box.cells)
    assert {frozenset(face) for face in mesh.faces_of("bottom")} == {frozenset(face) for face in faces}
    np.testing.assert_array_equal(mesh.nodes_of("corner"), [0])
    np.testing.assert_array_equal(mesh.cell_sets["half"], np.arange(4))
    np.testing.assert_array_equal(mesh.cell_sets["region-2"], np.arange(4, 8))
    assert tc.plan(tc.Scene([tc.Body(mesh, LAW, contact="bottom")], [tc.Plane()], 1e-3)).terms


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_a_mesh_goes_to_pyvista_and_back(kind):
    pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed")
    mesh = tc.box_mesh((1, 1, 1), (2, 2, 2), kind) if kind != "wedge6" else tc.cylinder_mesh(0.1, 0.2, 2)
    grid = tc.simulate(tc.Scene([tc.Body(mesh, LAW)], duration=1e-6)).to_pyvista()
    grid.cell_data["region"] = np.arange(mesh.cell_count) % 2
    back = tc.Mesh.from_pyvista(grid)
    assert back.kind == mesh.kind
    np.testing.assert_allclose(np.sort(back.cell_volumes()), np.sort(mesh.cell_volumes()), rtol=1e-9)
    assert set(back.cell_sets) == {"region-0", "region-1"}
    assert sum(len(cells) for cells in back.cell_sets.values()) == mesh.cell_count
    solid = tc.Mesh.from_pyvista(pyvista.ImageData(dimensions=(3, 3, 3)), scale=2.0)
    assert (solid.cell_count, solid.size) == (8, 4.0)
    with pytest.raises(tc.InputError, match="grid"):
        tc.Mesh.from_pyvista(pyvista.Sphere())


@pytest.mark.parametrize("wrong", [3, None, "mesh.vtu", np.zeros((4, 3))])
def test_what_is_no_mesh_is_refused(wrong):
    with pytest.raises(tc.InputError, match="mesh"):
        tc.Mesh.from_meshio(wrong)
    with pytest.raises(tc.InputError, match="grid"):
        tc.Mesh.from_pyvista(wrong)


SCRIPT = """
import numpy as np

import tcontact as tc


def bounce(cells: int) -> float:
    mesh: tc.Mesh = tc.box_mesh((0.1, 0.1, 0.1), (cells, cells, cells), origin=(0.0, 0.0, 1e-4))
    body = tc.Body(mesh, tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0), (0.0, 0.0, -1.0), contact="zmin")
    scene = tc.Scene([body], [tc.Plane()], duration=1e-3, gravity=(0.0, 0.0, -9.81), friction=tc.Coulomb(0.3))
    print(tc.plan(scene).describe())
    result: tc.Result = tc.simulate(scene, scheme=tc.CentralDifference(cfl=0.5), out="run", frames=3)
    stored: tc.StoredResult = tc.open_result("run", scene=scene)
    picture: np.ndarray = stored.render("end.png")
    axes = result.plot("energy")
    axes.set_title("energy")
    return float(result.history["contact_force"][:, 2].max()) + float(picture.mean())


def energy(strain: tc.Strain, mu: float, bulk: float) -> float:
    fibre: np.ndarray = np.array([1.0, 0.0, 0.0])
    stretch: float = fibre @ strain.C @ fibre
    return 0.5 * mu * (strain.I1_bar - 3.0) + 0.5 * bulk * (strain.J - 1.0) ** 2 + 0.1 * mu * (stretch - 1.0) ** 2


Fibred = tc.register_law("Fibred", energy, {"mu": 1e6, "bulk": 2e6})
material: tc.Material = Fibred(mu=1e6, bulk=2e6, density=1000.0)

try:
    bounce(3)
except tc.InputError as error:
    print(error.field, error.remedy)
"""


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_a_script_of_a_user_passes_strict_mypy(tmp_path):
    assert (ROOT / "tcontact" / "py.typed").exists()
    (tmp_path / "script.py").write_text(SCRIPT)
    (tmp_path / "wrong.py").write_text(SCRIPT.replace("bounce(3)", "bounce('3')"))
    (tmp_path / "no_number.py").write_text(SCRIPT.replace("strain.I1_bar - 3.0", "strain.C"))
    words = ["--strict", "--follow-imports=silent", "--config-file=", "--cache-dir", str(tmp_path / "cache")]
    for name, passes in (("script.py", True), ("wrong.py", False), ("no_number.py", False)):
        command = [sys.executable, "-m", "mypy", *words, str(tmp_path / name)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=None)
        assert (done.returncode == 0) == passes, done.stdout
