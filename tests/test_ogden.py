"""Ogden's law: exact stresses, small strains, tangents where stretches coincide, impacts, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from contact_stiffness import contact_stiffness, spread_of
from force_pass import Step
from implicit_parts import MATERIALS
from one_point import Force
from oracle import meshes
from scenes import block, wall
from test_implicit_tangents import check_cells

import tcontact as tc
from tcontact.cases import cube_impact
from tcontact.schemes import IMPLICIT

MU, ALPHA = (6.3e5, 1.2e3, -1e4), (1.3, 5.0, -2.0)
RUBBER = tc.Ogden(MU, ALPHA, 0.4, 1000.0)
LAM = RUBBER.lame_lambda


def pull(stretches):
    """dW/dl_i of three principal stretches, by the derivative of the energy of the docstring."""
    volume = np.prod(stretches)
    power = sum(mu * (stretches**alpha - 1.0) for mu, alpha in zip(MU, ALPHA, strict=True))
    return (power + LAM * (volume - 1.0) * volume) / stretches


def energy_density(stretches):
    """W word for word as in the docstring of the material."""
    powers = sum(mu / alpha * (stretches**alpha - 1.0).sum() for mu, alpha in zip(MU, ALPHA, strict=True))
    volume = np.prod(stretches)
    return powers - sum(MU) * np.log(volume) + LAM / 2.0 * (volume - 1.0) ** 2


def pressed_cube(f, material=RUBBER, kind="tet4"):
    """Energy density of a unit cube of cells under a homogeneous F, and P = sum f x X over its nodes (virtual work)."""
    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2), kind=kind)
    step = Step(kind, material.law, np.array(mesh.nodes), mesh.cells)
    step.moduli = material.parameters
    force, energy, _ = step.force(mesh.nodes @ (f - np.eye(3)).T)
    return energy, force.T @ mesh.nodes


def within(found, wanted, bound, scale):
    assert np.abs(np.asarray(found) - wanted).max() <= bound * scale


@pytest.mark.parametrize("stretch", [0.4, 0.97, 1.3, 4.0, 7.0])
def test_simple_tension(stretch):
    """The lateral stretch is where the lateral stress vanishes, by bisection of the scalar formula."""
    low, high = 0.05, 3.0
    for _ in range(200):
        side = 0.5 * (low + high)
        low, high = (low, side) if pull(np.array([stretch, side, side]))[1] > 0.0 else (side, high)
    exact = pull(np.array([stretch, side, side]))
    turn = meshes.rotation(5)
    stretches = np.array([stretch, side, side])
    energy, stress = pressed_cube(turn @ np.diag(stretches) @ turn.T)
    within(turn.T @ stress @ turn, np.diag([exact[0], 0.0, 0.0]), 1e-10, abs(exact[0]))
    assert energy == pytest.approx(energy_density(stretches), rel=1e-10)


@pytest.mark.parametrize("shear", [1e-6, 0.1, 1.0, 3.0])
def test_simple_shear(shear):
    """P_xy = dW/d(shear) = sum mu_p (l^a - l^-a)/(l + 1/l) with l - 1/l = shear; J = 1."""
    log = np.arcsinh(0.5 * shear)
    large = np.exp(log)
    wanted = sum(m * np.sinh(a * log) / np.cosh(log) for m, a in zip(MU, ALPHA, strict=True))
    f = np.eye(3)
    f[0, 1] = shear
    energy, stress = pressed_cube(f)
    within(stress[0, 1], wanted, 1e-10, abs(wanted))
    within(stress[[0, 1], [2, 2]], 0.0, 1e-10, abs(wanted))
    if shear >= 0.1:
        assert energy == pytest.approx(energy_density(np.array([large, 1.0 / large, 1.0])), rel=1e-10)


@pytest.mark.parametrize("kind", ["tet4", "hex8-reduced"])
@pytest.mark.parametrize("stretch", [0.6, 1.5, 3.0])
def test_equibiaxial_stretch(stretch, kind):
    """Two stretches coincide: the frame of their plane is arbitrary, the stress is not."""
    stretches = np.array([stretch, stretch, 0.9])
    turn = meshes.rotation(9)
    if kind == "tet4":
        _, stress = pressed_cube(turn @ np.diag(stretches) @ turn.T)
    else:
        mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2))
        force = Force(tc.Body(mesh, RUBBER, formulation="reduced"))
        stress = force(mesh.nodes @ (turn @ np.diag(stretches - 1.0) @ turn.T).T).T @ mesh.nodes
    exact = pull(stretches)
    within(turn.T @ stress @ turn, np.diag(exact), 1e-10, np.abs(exact).max())


@pytest.mark.parametrize("kind", ["hex8", "wedge6"])
def test_equibiaxial_tension(kind):
    """Two sides are pulled and the thickness is where its stress vanishes, by bisection of the scalar formula."""
    for stretch in (0.7, 1.2, 2.5, 6.0):
        low, high = 0.01, 3.0
        for _ in range(200):
            thickness = 0.5 * (low + high)
            pulled = pull(np.array([stretch, stretch, thickness]))[2] > 0.0
            low, high = (low, thickness) if pulled else (thickness, high)
        stretches = np.array([stretch, stretch, thickness])
        exact, turn = pull(stretches), meshes.rotation(4)
        energy, stress = pressed_cube(turn @ np.diag(stretches) @ turn.T, kind=kind)
        within(turn.T @ stress @ turn, np.diag([exact[0], exact[0], 0.0]), 1e-10, abs(exact[0]))
        assert energy == pytest.approx(energy_density(stretches), rel=1e-10)


@pytest.mark.parametrize(("kind", "formulation"), [("tet4", "full"), ("hex8", "reduced")])
def test_the_von_mises_stress_is_that_of_the_principal_stresses(kind, formulation):
    """sigma_i = l_i dW/dl_i / J, also where two stretches coincide or all do; a rotation changes nothing."""
    from tcontact.cells.stress import VonMises

    mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2), kind=kind)
    found = VonMises(tc.Body(mesh, RUBBER, formulation=formulation))
    turn, back = meshes.rotation(6), meshes.rotation(7)
    for stretches in np.array([(0.6, 1.1, 2.0), (1.8, 1.8, 0.5), (0.4, 0.4, 1.3), (1.5, 1.5, 1.5)]):
        sigma = stretches * pull(stretches) / np.prod(stretches)
        exact = np.sqrt(0.5 * ((sigma - np.roll(sigma, 1)) ** 2).sum())
        stress = found(mesh.nodes @ (turn @ np.diag(stretches) @ back.T - np.eye(3)).T)
        assert stress.shape == (mesh.cell_count,)
        within(stress, exact, 1e-10, np.abs(sigma).max())


def test_small_strains_are_those_of_hooke_and_keep_their_digits():
    random = np.random.default_rng(3)
    for size, bound in ((1e-9, 2e-8), (1e-12, 1e-10), (1e-30, 1e-10)):
        h = size * random.uniform(-1.0, 1.0, (3, 3))
        h = h if size > 1e-20 else 0.5 * (h + h.T)
        strain = 0.5 * (h + h.T)
        hooke = LAM * np.trace(strain) * np.eye(3) + 2.0 * RUBBER.lame_mu * strain
        mesh = tc.box_mesh((1.0, 1.0, 1.0), (2, 2, 2), kind="tet4")
        step = Step("tet4", "ogden", np.array(mesh.nodes), mesh.cells)
        step.moduli = RUBBER.parameters
        force, energy, _ = step.force(mesh.nodes @ h.T)
        within(force.T @ mesh.nodes, hooke, bound, np.abs(hooke).max())
        assert energy == pytest.approx(0.5 * np.sum(hooke * strain), rel=bound)
    assert (RUBBER.young, RUBBER.poisson) == pytest.approx((2 * RUBBER.lame_mu * 1.4, 0.4))
    of = tc.Ogden.of(1e7, 0.3, 1000.0)
    hooke = tc.NeoHookean(1e7, 0.3, 1000.0)
    assert (of.lame_lambda, of.lame_mu, of.young) == pytest.approx((hooke.lame_lambda, hooke.lame_mu, 1e7), rel=1e-12)


def test_rigid_motions_and_one_pair_of_exponent_two():
    nodes = np.array(block("tet4", 2).nodes)
    cells = block("tet4", 2).cells
    step, neo = Step("tet4", "ogden", nodes, cells), Step("tet4", "neo_hookean", nodes, cells)
    step.moduli = tc.Ogden((0.4,), (2.0,), 0.3, 1.0).parameters
    neo.moduli = step.moduli[:2]
    u = 0.03 * np.random.default_rng(2).uniform(-1, 1, nodes.shape)
    (force, energy, _), (wanted, exact, _) = step.force(u), neo.force(u)
    within(force, wanted, 1e-12, np.abs(wanted).max())
    assert energy == pytest.approx(exact, rel=1e-12)
    turn = meshes.rotation(3)
    turned, same, _ = step.force((nodes + u) @ turn.T - nodes)
    within(turned, force @ turn.T, 1e-12, np.abs(force).max())
    assert same == pytest.approx(energy, rel=1e-12)
    force, energy, jacobian = step.force(np.zeros_like(nodes) + 1024.0)
    assert not force.any()
    assert (energy, jacobian) == (0.0, 1.0)
    assert np.isfinite(step.force(-1.5 * nodes * np.array([0, 0, 1.0]))[0]).all()  # inverted


@pytest.mark.parametrize(
    ("kind", "formulation", "removal"),
    [
        ("tet4", "full", "full"),
        ("hex8", "reduced", "normal"),
        pytest.param("hex8", "mean-dilatation", "full", marks=pytest.mark.slow),
        pytest.param("hex8", "full", "normal", marks=pytest.mark.slow),
    ],
)
def test_contact_stiffness_is_the_slope_of_the_force(kind, formulation, removal):
    """At random, with all stretches equal, with two equal, and with two that differ in the last digits."""
    mesh = block(kind, 2, shake=0.15)
    body = tc.Body(mesh, RUBBER, formulation=formulation, contact="zmin")
    force = Force(body)
    nodes, random = np.array(mesh.nodes), np.random.default_rng(1).uniform(-1, 1, mesh.nodes.shape)
    turn = meshes.rotation(2)
    for u in (
        0.02 * random,
        0.0 * nodes,
        0.3 * nodes,
        nodes @ (turn @ np.diag([0.4, 0.4, -0.3]) @ turn.T).T,
        nodes @ (turn @ np.diag([0.4, 0.4 + 3e-9, -0.3]) @ turn.T).T,
    ):
        found, places, basis = contact_stiffness(body, removal, u)
        dofs, spread = spread_of(places, basis)
        slope = spread.T @ force.stiffness(u, 3e-7, dofs)[dofs] @ spread
        assert np.abs(found - slope).max() <= 1e-7 * np.abs(slope).max()


@pytest.mark.parametrize("options", [{"kind": "tet4"}, pytest.param({"removal": "full"}, marks=pytest.mark.slow)])
def test_cube_impact(options):
    result = tc.simulate(cube_impact.scene(cells=4, law="ogden", **options))
    assert result.history["contact_force"][:, 2].max() > 0.0
    assert result.history["static_residual"].max() <= 1e-4
    assert not [check for check in cube_impact.checks(result) if not check.passed]


@pytest.mark.parametrize(
    ("rule", "kind", "formulation"),
    [
        ("end", "tet4", "full"),
        pytest.param("mean", "hex8", "mean-dilatation", marks=pytest.mark.slow),
        pytest.param("transport", "hex8", "reduced", marks=pytest.mark.slow),
        pytest.param("gonzalez", "tet4", "full", marks=pytest.mark.slow),
    ],
)
def test_tangent_of_implicit_steps(rule, kind, formulation, monkeypatch):
    monkeypatch.setitem(MATERIALS, "ogden", tc.Ogden((150.0, 1.0, -3.0), ALPHA, 0.3, 1.2))
    check_cells(rule, "ogden", kind, formulation)


def test_discrete_stresses_by_invariants_are_refused_by_name(tmp_path):
    scene = cube_impact.scene(cells=2, law="ogden")
    for scheme in (tc.DiscreteGradient(dt=1e-4), tc.Dissipative(dt=1e-4)):
        with pytest.raises(tc.InputError, match=r"law = 'ogden': implicit schemes have .* for steps of D") as error:
            tc.simulate(scene, scheme, out=tmp_path / "run")
        others = str(error.value).split("takes ogden: ")[1].split(", ")
        assert {"Gonzalez", "Midpoint", "TransportAveraging", "CentralDifference"} <= {*others}
        assert not {"DiscreteGradient", "Dissipative"} & {*others}
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("law", ["linear_elastic", "neo_hookean", "mooney_rivlin", "st_venant_kirchhoff", "ogden"])
def test_the_scheme_that_a_failed_implicit_step_advises_takes_the_law(law):
    """Ogden refuses discrete-gradient. A scheme that conserves the energy is not told to take one that does."""
    from tcontact.kernels.cells.implicit_rules import has_rule
    from tcontact.kernels.materials import LAWS

    for own in IMPLICIT:
        advised = [scheme for scheme in IMPLICIT if scheme.name in own(dt=1.0).remedy]
        assert bool(advised) == ("energy" not in own.conserves)
        assert all("energy" in scheme.conserves and has_rule(LAWS[law], scheme.stress) for scheme in advised)


def test_an_inverted_cell_is_told_what_helps_this_law():
    """Where the law itself loses ellipticity, advice for shocks would lead astray."""
    mesh = block("tet4", (3, 3, 6), (0.1, 0.1, 0.2), shake=0.0)
    body = tc.Body(mesh, tc.Ogden.of(2.3e7, 0.27, 1350.0), contact="zmin")
    c = body.material.wave_speed
    thrown = replace(body, velocity=(0.0, 0.0, -2.0 * c))
    result = tc.simulate(tc.Scene([thrown], [wall(mesh, (0, 0, 1.0), 1e-3)], duration=0.3 / c))
    assert result.reason == "inverted-cell"
    assert "exponents below 1" in result.message
    assert "viscosity" not in result.message


def test_a_number_of_parameters_that_the_law_does_not_take_is_refused():
    """More or fewer of them would be taken from the next body without a word."""

    class Longer(tc.Ogden):
        @property
        def parameters(self):
            return (*super().parameters, 1.0)

    scene = cube_impact.scene(cells=2, law="ogden")
    own = replace(scene, bodies=[replace(scene.bodies[0], material=Longer(MU, ALPHA, 0.4, 1000.0))])
    with pytest.raises(tc.InputError, match=r"the law 'ogden' takes 8, lam, mu, .*give a value for each") as error:
        tc.simulate(own)
    assert error.value.field == "Scene.bodies[0].material.parameters"


@pytest.mark.parametrize(
    ("mu", "alpha", "field"),
    [
        ((), (), "mu"),
        (1e6, 2.0, "mu"),
        ((1.0,) * 4, (2.0,) * 4, "mu"),
        ((1e6, 1.0), (2.0,), "alpha"),
        ((1e6,), (-2.0,), "alpha[0]"),
        ((1e6, 0.0), (2.0, 1.0), "alpha[1]"),
        ((1e6,), (0.0,), "alpha[0]"),
        ((1e6,), (25.0,), "alpha[0]"),
        ((float("nan"),), (2.0,), "mu"),
        (("1e6",), (2.0,), "mu"),
        ((-1e5,), (-25.0,), "alpha[0]"),
        ((1e6,), (1e-305,), "mu"),
        ((1e-200,), (1e-200,), "mu"),
        ((1e308,), (20.0,), "mu"),
        ((1e6, True), (2.0, 1.0), "mu"),
        ((1e6, 1e6), (2.0, np.True_), "alpha"),
    ],
)
def test_bad_pairs_are_refused(mu, alpha, field):
    with pytest.raises(tc.InputError) as error:
        tc.Ogden(mu, alpha, 0.3, 1.0)
    assert error.value.field == field
    if field == "alpha[0]":
        assert f"alpha[0] = {alpha[0]:g}" in str(error.value)  # with its sign


def test_scene_files_know_it(tmp_path):
    scene = cube_impact.scene(cells=2, law="ogden")
    tc.save_scene(scene, tmp_path / "scene.toml")
    again, _ = tc.load_scene(tmp_path / "scene.toml")
    assert again.bodies[0].material == scene.bodies[0].material
