"""Tangents of the implicit steps against central differences; stresses of the conserving ones against the energy."""

from decimal import Decimal, localcontext

import implicit_parts as parts
import numpy as np
import pytest

import tcontact as tc
from tcontact.schemes.implicit.solution.penalty import PenaltyForce
from tcontact.schemes.implicit.solution.surfaces import Curved, surface_of

RULES = ("end", "transport", "mean", "gonzalez", "discrete", "dissipative")
CELLS = (("hex8", "full"), ("tet4", "full"), ("hex8", "reduced"), ("hex8", "mean-dilatation"))
SCHEMES = (
    tc.DiscreteGradient(dt=1.0),
    tc.Gonzalez(dt=1.0),
    tc.TransportAveraging(dt=1.0),
    tc.StressAveraging(dt=1.0),
    tc.Midpoint(dt=1.0),
    tc.Trapezoidal(dt=1.0),
    tc.HilberHughesTaylor(dt=1.0, alpha=-0.2),
    tc.Dissipative(dt=1.0, chi=0.3),
    tc.PaperImplicit(dt=1.0),
)


def check_cells(rule, law, kind, formulation):
    body = parts.body(law, kind, formulation)
    cells = parts.cells_of(body)
    u0, d = parts.moves(body.mesh.node_count)
    level = 1.0 if rule == "end" else 0.5

    def force(d):
        cells.evaluate(rule, u0, d, False, 0.3)
        return cells.force(level)

    cells.evaluate(rule, u0, d, True, 0.3)
    tangent = parts.dense(cells.tangent_blocks(1.0, level), cells.sparsity)
    expected = parts.differences(force, d)
    assert np.abs(tangent - expected).max() < 1e-7 * np.abs(expected).max()


QUICK = [
    *((rule, "neo", "hex8", "full") for rule in RULES),
    *(("discrete", law, kind, "full") for law in ("linear", "svk", "mooney") for kind in ("hex8", "tet4")),
    ("discrete", "neo", "wedge6", "full"),
    ("discrete", "neo", "hex8", "reduced"),
    ("discrete", "neo", "hex8", "mean-dilatation"),
    ("discrete", "linear", "hex8", "mean-dilatation"),
]
ALL = [
    (rule, law, *cell)
    for rule in RULES
    for law in parts.MATERIALS
    for cell in CELLS
    if (law, cell[1]) != ("svk", "mean-dilatation") and (rule, law, *cell) not in QUICK
]


@pytest.mark.parametrize(("rule", "law", "kind", "formulation"), QUICK)
def test_tangent_of_the_cells_is_the_derivative_of_their_force(rule, law, kind, formulation):
    check_cells(rule, law, kind, formulation)


@pytest.mark.slow
@pytest.mark.parametrize(("rule", "law", "kind", "formulation"), ALL)
def test_tangent_of_the_cells_is_the_derivative_of_their_force_everywhere(rule, law, kind, formulation):
    check_cells(rule, law, kind, formulation)


def check_step(scheme, obstacle, law="neo", contact=None, bound=1e-7, **options):
    stepped, d = parts.in_step(scheme, parts.OBSTACLES[obstacle], law, contact, **options)
    equations = stepped.equations
    for k, gaps in enumerate(equations.contact.passages(equations.u0, d)):  # the test must not be about free flight
        assert (gaps.after < 0).any() or (gaps.before < 0).any(), k
    expected = parts.differences(lambda d: equations.evaluate(d)[0], d, step=3e-6)
    equations.evaluate(d)
    tangent = parts.dense(equations.tangent(d), stepped.cells.sparsity)
    assert np.abs(tangent - expected).max() < bound * np.abs(expected).max()


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
def test_tangent_of_a_step_in_contact(scheme):
    check_step(scheme, "sphere")


@pytest.mark.parametrize("obstacle", parts.OBSTACLES)
def test_tangent_of_a_step_on_every_obstacle(obstacle):
    check_step(tc.DiscreteGradient(dt=1.0), obstacle)


@pytest.mark.slow
@pytest.mark.parametrize("law", parts.MATERIALS)
@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
def test_tangent_of_every_step_on_every_obstacle(scheme, law):
    for kind, formulation in CELLS:
        for obstacle in parts.OBSTACLES:
            if (law, formulation) != ("svk", "mean-dilatation"):
                check_step(scheme, obstacle, law, kind=kind, formulation=formulation)


@pytest.mark.parametrize("obstacle", parts.OBSTACLES.values(), ids=list(parts.OBSTACLES))
def test_contact_force_works_like_its_potential(obstacle):
    """Inside, entering, leaving and outside: force . dx is the energy given up, along any way."""
    generator = np.random.default_rng(5)
    surface = surface_of(obstacle, 1.0)
    x0 = np.array([0.4, 0.5, 0.1]) + 0.1 * generator.standard_normal((400, 3))
    x1 = x0 + 0.1 * generator.standard_normal((400, 3)) * 10.0 ** -generator.integers(0, 7, (400, 1))
    stiffness = generator.uniform(1.0, 3.0, 400)
    past = surface.passage(x0, x1)
    assert all(np.any(s0 & s1) for s0 in (past.before < 0, past.before > 0) for s1 in (past.after < 0, past.after > 0))
    force, _ = PenaltyForce([surface], stiffness).conserving(x0, x1)
    stored = 0.5 * stiffness * (np.minimum(past.after, 0.0) ** 2 - np.minimum(past.before, 0.0) ** 2)
    assert np.abs((force[0] * (x1 - x0)).sum(axis=1) + stored).max() < 1e-15
    assert np.abs((past.normal * (x1 - x0)).sum(axis=1) - (past.after - past.before)).max() < 2e-15


@pytest.mark.parametrize("name", ["sphere", "bowl", "cylinder"])
def test_round_obstacles_push_without_torque(name):
    obstacle = parts.OBSTACLES[name]
    generator = np.random.default_rng(6)
    x0, x1 = generator.uniform(-1.0, 1.0, (2, 100, 3))
    normal = surface_of(obstacle, 1.0).passage(x0, x1).normal
    torque = np.cross(0.5 * (x0 + x1) - obstacle.reference, normal)
    if name == "cylinder":
        torque = torque @ obstacle.axis
    assert np.abs(torque).max() < 1e-14
    assert np.linalg.norm(normal, axis=1).max() < 1.0 + 1e-15


def test_a_step_without_motion_has_the_normal_of_its_place():
    x = np.array([[0.4, 0.5, 0.2]])
    sphere = parts.OBSTACLES["sphere"]
    for surface in (surface_of(sphere, 1.0), Curved(sphere, 1.0)):
        assert np.allclose(surface.passage(x, x).normal, sphere.normal_at(x), atol=1e-14)


# S*:dC/2 = W1 - W0


def strain_energy(law, h):
    """W of a displacement gradient in 60 digits."""
    f = [[h[i][j] + (i == j) for j in range(3)] for i in range(3)]
    if law == "linear":
        e = [[(h[i][j] + h[j][i]) / 2 for j in range(3)] for i in range(3)]
    else:
        e = [[(sum(f[k][i] * f[k][j] for k in range(3)) - (i == j)) / 2 for j in range(3)] for i in range(3)]
    trace, square = e[0][0] + e[1][1] + e[2][2], sum(part**2 for row in e for part in row)
    jacobian = sum(
        f[0][i] * (f[1][(i + 1) % 3] * f[2][(i + 2) % 3] - f[1][(i + 2) % 3] * f[2][(i + 1) % 3]) for i in range(3)
    )
    first, second, *third = map(Decimal, parts.MATERIALS[law].parameters)
    if law in ("linear", "svk"):
        return first / 2 * trace**2 + second * square
    result = second * (trace - jacobian.ln()) + first / 2 * (jacobian - 1) ** 2
    return result + (third[0] / 2 * (trace**2 - square) if third else 0)


def strain_energy_change(law, h0, dh):
    """W(h0 + dh) - W(h0), without the rounding of doubles."""
    with localcontext() as context:
        context.prec = 60
        start, change = ([[Decimal(value) for value in row] for row in part.tolist()] for part in (h0, dh))
        end = [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(start, change, strict=True)]
        return float(strain_energy(law, end) - strain_energy(law, start))


@pytest.mark.parametrize(
    ("rule", "law"),
    [
        *(("discrete", law) for law in parts.MATERIALS),
        ("gonzalez", "neo"),
        *(pytest.param("gonzalez", law, marks=pytest.mark.slow) for law in ("linear", "svk", "mooney")),
    ],
)
def test_conserving_stress_does_the_work_of_the_energy(rule, law):
    """Over 0 to 8 decades of increments, and through rigid rotations, relative to |S| |dC| + what rounds in W."""
    body = tc.Body(tc.box_mesh(size=(1, 1, 1), cells=(1, 1, 1), kind="tet4"), parts.MATERIALS[law])
    cells = parts.cells_of(body)
    nodes, volume = np.array(body.mesh.nodes), cells.volume.sum()
    generator = np.random.default_rng(7)
    for decade in range(9):
        h0 = 0.1 * generator.standard_normal((3, 3))
        dh = 10.0**-decade * 0.2 * generator.standard_normal((3, 3))
        if decade == 4 and law != "linear":  # a rotation on top of a strain
            turn = np.linalg.qr(np.eye(3) + generator.standard_normal((3, 3)))[0]
            turn *= np.sign(np.linalg.det(turn))
            dh = (turn - np.eye(3)) @ (np.eye(3) + h0)
        d = nodes @ dh.T
        cells.evaluate(rule, nodes @ h0.T, d)
        work = (cells.force(0.5) * d).sum() / volume
        expected = strain_energy_change(law, h0, dh)
        stress = np.abs(np.asarray(cells.stress)).max() / cells.volume.min()
        rounding = 1e3 * np.abs(h0).max() ** 2 if rule == "gonzalez" else 0.0  # W1 - W0 is a difference there
        dropped = 1e3 * (0.4 * 10.0**-decade) ** 3 if rule == "gonzalez" and 0.4 * 10.0**-decade < 1e-5 else 0.0
        scale = stress * np.abs(dh).max() + rounding
        assert abs(work - expected) <= 1e-13 * scale + dropped, decade
