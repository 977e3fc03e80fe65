"""Mixed precision: laws and elements in float32 against float64; translations, sizes, viscosity, plastic flow."""

import functools

import numpy as np
import pytest
from own_law_formulas import gent
from scenes import block

import tcontact as tc
from tcontact.cells.internal_force import InternalForce
from tcontact.device import arrays
from tcontact.kernels import lanes
from tcontact.mesh.elements import FORMULATIONS
from tcontact.planning.planning import plan

YOUNG, POISSON, DENSITY = 2.3e7, 0.27, 1350.0
CONSTANTS = {"young": YOUNG, "poisson": POISSON, "density": DENSITY}
METAL = {"young": 2e11, "poisson": 0.3, "density": 7800.0, "specific_heat": 460.0}
LINEAR, COOK = tc.LinearHardening(3e8, 1e9), tc.JohnsonCook(3.5e8, 2.7e8, 0.36, 0.022, 1.0, 1811.0)
GUINAN = tc.friction_layer.metals.STAINLESS_304
ELASTIC = {
    "linear": tc.LinearElastic(**CONSTANTS),
    "svk": tc.StVenantKirchhoff(**CONSTANTS),
    "neo": tc.NeoHookean(**CONSTANTS),
    "mooney": tc.MooneyRivlin.of(**CONSTANTS),
    "ogden": tc.Ogden((6e6, -1e5), (1.7, -2.0), 0.27, DENSITY),
}


def metals():
    """Every yield stress with every equation of state."""
    shock = tc.MieGrueneisen(1.5, 1.7)
    return {
        f"{type(hardening).__name__} {pressure if isinstance(pressure, str) else 'shock'}": tc.ElastoPlastic(
            **METAL, hardening=hardening, pressure=pressure
        )
        for hardening in (LINEAR, COOK, GUINAN)
        for pressure in ("bulk", "barrier", shock)
    }


@functools.cache
def point_kernel(law):
    """Return a kernel that gives P, W, J - 1 of a law at gradients [n, 9], in float64 and in float32."""
    import taichi as ti

    from tcontact.kernels.cells.mixed_cells import narrow
    from tcontact.kernels.language.arguments import ARRAY
    from tcontact.kernels.language.precision import in_single
    from tcontact.kernels.materials import LAWS

    known = LAWS[law]
    quick, size, count, flows = in_single(known.update), len(known.state), len(known.parameters), known.plastic
    count += 1 if flows and flows.rates else 0

    @ti.func
    def respond(update: ti.template(), h, parameters, old):
        if ti.static(size):
            return update(h, parameters, old, [])
        else:
            return update(h, parameters)

    @ti.kernel
    def drive(gradients: ARRAY, numbers: ARRAY, state: ARRAY, out: ARRAY):
        ti.loop_config(serialize=True)
        for n in range(gradients.shape[0] // 9):
            h = [[gradients[9 * n + 3 * i + j] for j in range(3)] for i in range(3)]
            parameters, old = [numbers[i] for i in range(count)], [state[i] for i in range(size)]
            exact = respond(known.update, h, parameters, old)
            narrow_h = [[narrow(h[i][j]) for j in range(3)] for i in range(3)]
            rough = respond(quick, narrow_h, [narrow(a) for a in parameters], [narrow(a) for a in old])
            for i, j in ti.static(ti.ndrange(3, 3)):
                out[22 * n + 3 * i + j] = exact[0][i][j]
                out[22 * n + 11 + 3 * i + j] = rough[0][i][j]
            for i in ti.static(range(2)):
                out[22 * n + 9 + i] = exact[1 + i]
                out[22 * n + 20 + i] = rough[1 + i]

    return drive, size


def at_points(material, gradients):
    """P [n, 3, 3], W, J - 1 of a material in float64 and in float32 at F - I [n, 3, 3]."""
    drive, size = point_kernel(material.law)
    gradients = np.float64(np.float32(gradients))
    out = np.zeros(22 * len(gradients))
    drive(gradients.reshape(-1).copy(), np.array([*material.parameters, 1e-6]), np.zeros(max(size, 1)), out)
    return [(part[:, :9].reshape(-1, 3, 3), part[:, 9], part[:, 10]) for part in np.split(out.reshape(-1, 22), 2, 1)]


def spread(exact, rough, scale):
    """Largest difference over the scale; numbers that are not finite count."""
    difference = np.abs(rough - exact) / scale
    return float(np.where(np.isfinite(difference), difference, np.inf).max())


def own_law():
    """A registered law with a logarithm and the cube root of J."""
    if "MixedGent" not in own_law.__dict__:
        own_law.MixedGent = tc.register_law("MixedGent", gent, {"mu": 4e5, "limit": 30.0, "bulk": 2e6})
    return own_law.MixedGent(mu=4e5, limit=30.0, bulk=2e6, density=DENSITY)


@pytest.mark.parametrize("name", [*ELASTIC, "own"])
def test_elastic_laws_in_float32_keep_their_digits_at_every_strain(name):
    """Errors of P and W in units of their own size: small strains are as accurate as large ones."""
    material = own_law() if name == "own" else ELASTIC[name]
    random = np.random.default_rng(3)
    for size in (1e-9, 1e-5, 1e-2, 0.2):
        exact, rough = at_points(material, size * random.uniform(-1.0, 1.0, (200, 3, 3)))
        assert spread(exact[0], rough[0], np.abs(exact[0]).max()) < 1e-6, size
        assert spread(exact[1], rough[1], np.abs(exact[1]).max()) < 1e-6, size
        assert spread(exact[2], rough[2], size) < 1e-6, size


@pytest.mark.parametrize("name", metals())
def test_metals_in_float32_err_by_rounding_of_the_trial_stress(name):
    """A trial stress of modulus times strain is cut down to the yield stress: the scale of its error is the former."""
    material = metals()[name]
    random = np.random.default_rng(4)
    for size in (1e-7, 1e-3, 2e-2, 0.1):
        exact, rough = at_points(material, size * random.uniform(-1.0, 1.0, (200, 3, 3)))
        scale = 2e11 * size
        assert spread(exact[0], rough[0], scale) < 3e-6, size
        assert spread(exact[1], rough[1], scale * size) < 3e-6, size


def scene_of(kind, material, scale=1.0, shake=0.2, viscosity=None):
    base, _, formulation = kind.partition("-")
    mesh = block(base, 3, shake=shake)
    mesh = tc.Mesh(scale * mesh.nodes, mesh.cells, mesh.kind)
    return tc.Scene(
        bodies=tc.Body(mesh, material, formulation=formulation or "full"), duration=1.0, viscosity=viscosity
    )


class Pass:
    """The force pass of a body in mixed precision, which also computes in float64 where it is asked for it."""

    def __init__(self, scene):
        self.domain = plan(scene).domains[0]
        self.domain.mixed = True
        self.order = self.domain.bodies[0].node_order
        self.mixed, self.exact = InternalForce(self.domain), InternalForce(self.domain)
        values = np.array(arrays.get(self.exact.parameters))
        values[lanes.FREE] = 1.0  # as in products
        arrays.set_values(self.exact.parameters, values)

    def force(self, u, v=None, which="mixed", commit=False, step=0.0):
        """Force [n, 3] on the nodes at u [n, 3] and v [n, 3]; a committing pass stores the state of its points."""
        taken = getattr(self, which)
        speed = np.zeros_like(u) if v is None else v
        out = arrays.put(speed[self.order].ravel())
        kick = 1e-9 * np.ptp(self.domain.reference)  # viscosity at most reverses the strain rate over a step
        taken.advance(arrays.put(u[self.order].ravel()), out, 0.0, kick, 0.0, loaded=commit, before=step)
        found = np.empty_like(u)
        moved = speed[self.order] - np.array(arrays.get(out)).reshape(-1, 3)
        found[self.order] = moved * self.domain.lumped[:, None] / kick
        return found

    def both(self, u, v=None):
        """Forces in float64 and in mixed precision, and the difference over the largest."""
        exact, rough = (self.force(u, v, which) for which in ("exact", "mixed"))
        return exact, rough, spread(exact, rough, np.abs(exact).max())


def moved(scene, size, seed=5):
    """Random displacements [n, 3] of a share of a cell."""
    nodes = scene.bodies[0].mesh.nodes
    return size * np.ptp(nodes, axis=0).min() / 3 * np.random.default_rng(seed).uniform(-1.0, 1.0, nodes.shape)


@pytest.mark.parametrize("shake", [0.2, 0.0])
@pytest.mark.parametrize("kind", FORMULATIONS)
def test_every_element_has_the_force_of_float64_in_bodies_of_every_size(kind, shake):
    """Volumes of cells of 1e-10 m and of 1e5 m leave the range of float32; in units of length they do not."""
    for scale in (1e-9, 1.0, 1e6):
        scene = scene_of(kind, ELASTIC["neo"], scale, shake)
        ways = Pass(scene)
        for size in (1e-9, 1e-3, 0.1):
            _, rough, error = ways.both(moved(scene, size))
            assert error < 1e-6, (scale, size, error)
            energies = [getattr(ways, which).sum_of("elastic") for which in ("exact", "mixed")]
            assert abs(energies[1] / energies[0] - 1.0) < 1e-6, (scale, size)
            assert np.abs(rough.sum(axis=0)).max() < 1e-13 * np.abs(rough).sum()
            lowest = [getattr(ways, which).sum_of("jacobian_min") for which in ("exact", "mixed")]
            assert abs(lowest[1] - lowest[0]) < 1e-7
            assert abs(lowest[1] - lowest[0]) > 0.0 or size < 1e-3  # it is float32 that computed


@pytest.mark.parametrize("kind", ["hex8", "tet4", "hex8-reduced"])
def test_a_translation_of_a_million_lengths_changes_no_bit(kind):
    scene = scene_of(kind, ELASTIC["linear"])
    ways = Pass(scene)
    u = np.round(moved(scene, 0.01) * 2.0**32) / 2.0**32  # sums with 2^18 are exact
    still = ways.force(u)
    assert np.array_equal(ways.force(u + np.array([2.0**18, -(2.0**17), 2.0**18])), still)
    assert np.abs(still).max() > 0.0


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
@pytest.mark.parametrize("scale", [1e-9, 1e6])
def test_bulk_viscosity_in_float32_has_the_force_and_power_of_float64(kind, scale):
    scene = scene_of(kind, ELASTIC["linear"], scale, viscosity=tc.BulkViscosity())
    ways = Pass(scene)
    u, v = moved(scene, 0.02), 1e5 * moved(scene, 0.02, seed=6)
    still = ways.force(u, None, "exact")
    exact, _, error = ways.both(u, v)
    assert error < 1e-6
    assert np.abs(exact - still).max() > 0.0
    rough = ways.force(u, v) - ways.force(u)
    assert spread(exact - still, rough, np.abs(exact).max()) < 1e-6
    ways.both(u, v)
    ways.both(u, v)  # the power takes the mean of the pressures of two passes
    for name in ("viscous_power", "viscous_rate"):
        power, rough = (getattr(ways, which).sum_of(name) for which in ("exact", "mixed"))
        assert power != 0.0
        assert abs(rough / power - 1.0) < 1e-6, name


@pytest.mark.parametrize("kind", ["hex8-mean-dilatation", "hex8-reduced", "tet4-node-averaged"])
def test_plastic_flow_in_float32_dissipates_and_hardens_as_in_float64(kind):
    scene = scene_of(kind, tc.ElastoPlastic(**METAL, hardening=LINEAR))
    ways = Pass(scene)
    u = moved(scene, 0.05)
    for share in np.linspace(0.1, 1.0, 10):
        exact, rough = (ways.force(share * u, None, which, True, 1e-6) for which in ("exact", "mixed"))
        assert spread(exact, rough, np.abs(exact).max()) < 3e-5  # modulus times strain over the yield stress: 20
        for name in ("plastic_step", "heat_step", "plastic_strain_max", "temperature_max"):
            sums = [getattr(ways, which).sum_of(name) for which in ("exact", "mixed")]
            assert sums[1] == pytest.approx(sums[0], rel=1e-5, abs=0.0), name
    assert ways.mixed.sum_of("plastic_strain_max") > 0.01
