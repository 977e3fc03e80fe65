"""Registered laws: the built-in one by its formula, Gent's law against exact stresses, tangents, impacts, limits."""

from dataclasses import replace

import numpy as np
import pytest
from contact_stiffness import contact_stiffness, spread_of
from force_pass import Step
from implicit_parts import MATERIALS
from one_point import Force, distorted, moved
from oracle import meshes
from own_law_formulas import energy_of, fibre, gent, neo_hookean, of_gradient
from scenes import block
from test_implicit_tangents import check_cells

import tcontact as tc
from tcontact.cases import cube_impact
from tcontact.commands.cli import main

MU, LIMIT, BULK = 4e5, 30.0, 1.8e6
BUILT_IN = tc.NeoHookean(1e7, 0.3, 1000.0)


@pytest.fixture(scope="module")
def own():
    """NeoHookean by its formula, with the constants of BUILT_IN."""
    law = tc.register_law("OwnNeoHookean", neo_hookean, {"lam": 2.0, "mu": 1.0})
    return law(lam=BUILT_IN.lame_lambda, mu=BUILT_IN.lame_mu, density=1000.0)


@pytest.fixture(scope="module")
def rubber():
    """A material of Gent's law."""
    return tc.register_law("Gent", gent, {"mu": MU, "limit": LIMIT, "bulk": BULK})(MU, LIMIT, BULK, 1000.0)


def within(found, wanted, bound):
    assert np.abs(np.asarray(found) - wanted).max() <= bound * np.abs(wanted).max()


FORMULATIONS = ["full", *(pytest.param(name, marks=pytest.mark.slow) for name in ("reduced", "mean-dilatation"))]


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_built_in_law_by_its_formula(own, formulation):
    """Force, energy and stiffness of distorted cells; removal="full" has other nodes of the static solve."""
    mesh = distorted()
    bodies = [tc.Body(mesh, one, formulation=formulation, contact="zmin") for one in (BUILT_IN, own)]
    u = moved(mesh)
    old, new = map(Force, bodies)
    for scale in (1.0, 1e-3):
        within(new(scale * u), old(scale * u), 1e-12)
        assert new.energy == pytest.approx(old.energy, rel=1e-12 / scale)
        assert new.jacobian == pytest.approx(old.jacobian, rel=1e-14)
    wanted, found = (contact_stiffness(body, "full", u)[0] for body in bodies)
    within(found, wanted, 1e-12)


@pytest.mark.parametrize("options", [{}, pytest.param({"kind": "tet4", "removal": "full"}, marks=pytest.mark.slow)])
def test_an_impact_of_the_built_in_law_by_its_formula(own, options):
    scene = cube_impact.scene(cells=4, **options)
    old = tc.simulate(scene)
    new = tc.simulate(replace(scene, bodies=[replace(scene.bodies[0], material=own)]))
    assert old.steps == new.steps
    assert old.history["contact_force"].max() > 0.0
    for name in ("contact_force", "energy", "elastic", "kinetic", "momentum", "impulse", "gap_min"):
        within(new.history[name], old.history[name], 1e-12)


def pull(stretches, mu=MU, limit=LIMIT, bulk=BULK):
    """dW/dl_i of Gent's law by hand."""
    volume, first = np.prod(stretches), np.sum(stretches**2)
    change = volume ** (-2.0 / 3.0) * (stretches - first / (3.0 * stretches))
    return (
        mu / (1.0 - (volume ** (-2.0 / 3.0) * first - 3.0) / limit) * change
        + bulk * (volume - 1.0) * volume / stretches
    )


def pressed_cube(f, material):
    """Energy density of a unit cube of tets under a homogeneous F, and P = sum f x X over its nodes."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2), kind="tet4")
    step = Step("tet4", material.law, np.array(mesh.nodes), mesh.cells)
    step.moduli = material.parameters
    force, energy, _ = step.force(mesh.nodes @ (f - np.eye(3)).T)
    return energy, force.T @ mesh.nodes


@pytest.mark.parametrize("stretch", [0.5, 0.97, 1.3, 3.0, 5.0])
def test_simple_tension(rubber, stretch):
    """The lateral stretch is where the lateral stress vanishes, by bisection of the scalar formula."""
    low, high = 0.05, 3.0
    for _ in range(200):
        side = 0.5 * (low + high)
        low, high = (low, side) if pull(np.array([stretch, side, side]))[1] > 0.0 else (side, high)
    stretches, turn = np.array([stretch, side, side]), meshes.rotation(5)
    energy, stress = pressed_cube(turn @ np.diag(stretches) @ turn.T, rubber)
    within(turn.T @ stress @ turn, np.diag([pull(stretches)[0], 0.0, 0.0]), 1e-10)
    assert energy == pytest.approx(energy_of(gent, np.diag(stretches), mu=MU, limit=LIMIT, bulk=BULK), rel=1e-10)


@pytest.mark.parametrize("shear", [1e-6, 0.1, 1.0, 5.0])
def test_simple_shear(rubber, shear):
    """P_xy = mu shear/(1 - shear^2/limit) at constant volume, beside normal stresses."""
    f = np.eye(3)
    f[0, 1] = shear
    _, stress = pressed_cube(f, rubber)
    slope = MU / (1.0 - shear**2 / LIMIT)
    assert stress[0, 1] == pytest.approx(slope * shear, rel=1e-10)
    deviator = f - (3.0 + shear**2) / 3.0 * np.linalg.inv(f).T
    within(stress, slope * deviator, 1e-10)


def test_small_strains_keep_their_digits(rubber):
    """The formula is written in invariants of the size 3: stress and energy are those of Hooke at any small strain."""
    random = np.random.default_rng(3)
    for size, bound in ((1e-9, 5e-8), (1e-12, 1e-10), (1e-30, 1e-10)):
        h = size * random.uniform(-1.0, 1.0, (3, 3))
        h = h if size > 1e-20 else 0.5 * (h + h.T)
        strain = 0.5 * (h + h.T)
        hooke = rubber.lame_lambda * np.trace(strain) * np.eye(3) + 2.0 * rubber.lame_mu * strain
        mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2), kind="tet4")
        step = Step("tet4", "Gent", np.array(mesh.nodes), mesh.cells)
        step.moduli = rubber.parameters
        force, energy, _ = step.force(mesh.nodes @ h.T)
        within(force.T @ mesh.nodes, hooke, bound)
        assert energy == pytest.approx(0.5 * np.sum(hooke * strain), rel=bound)


@pytest.mark.parametrize(
    ("name", "kind", "formulation", "removal"),
    [
        ("Fibred", "tet4", "full", "full"),
        ("Gent", "hex8", "reduced", "normal"),
        pytest.param("Gent", "hex8", "mean-dilatation", "full", marks=pytest.mark.slow),
        pytest.param("Fibred", "hex8", "full", "normal", marks=pytest.mark.slow),
    ],
)
def test_contact_stiffness_is_the_slope_of_the_force(rubber, name, kind, formulation, removal):
    """An anisotropic law has a tangent without the symmetries of the others."""
    fibred = tc.register_law("Fibred", fibre, {"lam": 2.0, "mu": 1.0, "fibre": 3.0})
    material = rubber if name == "Gent" else fibred(lam=2e6, mu=1e6, fibre=4e6, density=1000.0)
    mesh = block(kind, 2, shake=0.15)
    body = tc.Body(mesh, material, formulation=formulation, contact="zmin")
    force, nodes = Force(body), np.array(mesh.nodes)
    for u in (0.02 * np.random.default_rng(1).uniform(-1, 1, nodes.shape), 0.0 * nodes, 0.3 * nodes):
        found, places, basis = contact_stiffness(body, removal, u)
        dofs, spread = spread_of(places, basis)
        slope = spread.T @ force.stiffness(u, 3e-7, dofs)[dofs] @ spread
        assert np.abs(found - slope).max() <= 1e-7 * np.abs(slope).max()


def impact(material, friction=None, speed=10 / 3.6, **options):
    """The soft cube of 4^3 boxes with another material."""
    scene = cube_impact.scene(cells=4, duration=0.004, **options)
    body = replace(scene.bodies[0], material=material, velocity=(0.3 * speed if friction else 0.0, 0.0, -speed))
    return replace(scene, bodies=[body], friction=friction)


@pytest.mark.parametrize(
    "options",
    [
        {"kind": "tet4", "removal": "full", "friction": tc.Coulomb(0.3)},
        pytest.param({"friction": tc.Coulomb(0.3)}, marks=pytest.mark.slow),
        pytest.param({"removal": "full"}, marks=pytest.mark.slow),
        pytest.param({"formulation": "reduced", "removal": "full"}, marks=pytest.mark.slow),
        pytest.param({"formulation": "mean-dilatation"}, marks=pytest.mark.slow),
    ],
)
def test_impacts_meet_the_static_residual(rubber, options):
    """A wrong tangent would not."""
    result = tc.simulate(impact(rubber, **options))
    assert result.ok
    assert result.history["contact_force"][:, 2].max() > 0.0
    assert result.history["static_residual"].max() <= 1e-4
    assert np.abs(result.history["energy_error"]).max() < 0.06


def test_a_run_stops_where_the_law_ends(rubber):
    """Chains are stretched out at I1_bar = 3 + limit, where no cell is inverted yet: it counts as one that is."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2), kind="tet4")
    step = Step("tet4", "Gent", np.array(mesh.nodes), mesh.cells)
    step.moduli = rubber.parameters
    for stretch, inverted in ((5.7, False), (5.8, True)):  # l^2 + 2/l is 32.8 and 34.0
        along = mesh.nodes * (np.array([stretch, stretch**-0.5, stretch**-0.5]) - 1.0)
        assert (step.force(along)[2] < 0.0) == inverted
    stiff = replace(rubber, limit=0.02)
    result = tc.simulate(impact(stiff, friction=tc.Coulomb(0.3), kind="tet4", removal="full", speed=6.0))
    assert result.reason in ("inverted-cell", "not-converged")
    assert "the law 'Gent' ends" in result.message


@pytest.mark.parametrize(
    ("rule", "kind", "formulation"),
    [
        ("gonzalez", "tet4", "full"),
        pytest.param("mean", "hex8", "mean-dilatation", marks=pytest.mark.slow),
        pytest.param("transport", "hex8", "reduced", marks=pytest.mark.slow),
        pytest.param("end", "hex8", "full", marks=pytest.mark.slow),
    ],
)
def test_tangent_of_implicit_steps(rubber, rule, kind, formulation, monkeypatch):
    monkeypatch.setitem(MATERIALS, "gent", replace(rubber, mu=100.0, bulk=500.0, limit=3.0))
    check_cells(rule, "gent", kind, formulation)


def test_what_a_law_does_not_have_is_refused_by_name(rubber):
    """Discrete stresses; implicit steps of an energy of F; one volume change per cell without bulk/2 (J - 1)^2."""
    with pytest.raises(tc.InputError, match=r"law = 'Gent': .* takes Gent: Gonzalez"):
        tc.simulate(impact(rubber), tc.DiscreteGradient(dt=1e-5))
    material = tc.register_law("OfGradient", of_gradient, {"lam": 2.0, "mu": 1.0})(lam=2e6, mu=1e6, density=1e3)
    with pytest.raises(tc.InputError, match=r"law = 'OfGradient': .* takes OfGradient: CentralDifference"):
        tc.simulate(impact(material), tc.Gonzalez(dt=1e-5))
    with pytest.raises(tc.InputError, match="OfGradient has no part that is of the volume change alone"):
        tc.Body(tc.box_mesh((1, 1, 1), (2, 2, 2)), material, formulation="mean-dilatation")


LAWS_FILE = """
import numpy as np
import tcontact as tc

def gent(strain, mu, limit, bulk):
    return -0.5 * mu * limit * np.log(1.0 - (strain.I1_bar - 3.0) / limit) + 0.5 * bulk * (strain.J - 1.0) ** 2

tc.register_law("Gent", gent, {"mu": 4e5, "limit": 30.0, "bulk": 8e6})
"""


def test_a_scene_file_on_the_command_line(rubber, tmp_path):
    """--import registers the same law again, which is no other one."""
    file = tmp_path / "drop.toml"
    scene = impact(rubber, friction=tc.Coulomb(0.3), kind="tet4", removal="full")
    tc.save_scene(replace(scene, duration=2e-4), file)
    (tmp_path / "laws.py").write_text(LAWS_FILE, encoding="utf-8")
    words = ["run", str(file), "--import", str(tmp_path / "laws.py"), "--out", str(tmp_path / "out"), "--quiet"]
    assert main([*words, "--frames", "0"]) == 0
    (tmp_path / "laws.py").write_text(LAWS_FILE.replace("0.5 * bulk", "0.25 * bulk"), encoding="utf-8")
    assert main([*words, "--force"]) == 2


def test_the_type_for_annotations_names_all_that_an_energy_is_given():
    """`tc.Strain` stands for the class of the kernels, which a scene without own laws does not load."""
    from tcontact.kernels.language.traced_energy import Strain

    named, given = ({name for name in vars(kind) if name[0] != "_"} for kind in (tc.Strain, Strain))
    assert named == given == {"H", "F", "C", "E", "J", "I1", "I2", "I1_bar", "I2_bar"}
