"""Bulk viscosity in rotations: the rate of volume of a step is exact, a body that spins freely dissipates nothing."""

import functools

import numpy as np
import pytest
from oracle import meshes
from scenes import block, material, simulate
from test_viscosity import volumes

import tcontact as tc

CORNERS = {"hex8": 8, "tet4": 4, "wedge6": 6}
SCALE = {"hex8": 1.0 / 64.0, "tet4": 1.0 / 6.0, "wedge6": 0.5}  # volume over the determinant that elements use for it


@functools.cache
def kernel(kind):
    """A kernel of the viscosity of one cell: its rate of volume, -q and its corner forces, all without their scale."""
    from tcontact.device import runtime

    ti = runtime.start("cpu")
    from tcontact.kernels.elements import FUNCTIONS

    viscosity, corners = FUNCTIONS[kind].viscosity, CORNERS[kind]

    @ti.kernel
    def run(nodes: ti.types.ndarray(), half: ti.f64, answer: ti.types.ndarray()):
        for _ in range(1):
            x = [[nodes[0, k, c] for k in range(corners)] for c in range(3)]
            u = [[nodes[1, k, c] for k in range(corners)] for c in range(3)]
            v = [[nodes[2, k, c] for k in range(corners)] for c in range(3)]
            found = viscosity(x, u, v, half, 1.0, 1.0)
            answer[0], answer[1] = found[2], found[1]
            for c, k in ti.static(ti.ndrange(3, corners)):
                answer[2 + 3 * k + c] = found[0][c][k]

    return run


def of_step(kind, start, end, dt):
    """Rate of volume [m^3/s] of a cell in a step and its corner forces [n, 3] for a unit of -q."""
    nodes = np.stack([start, end - start, (end - start) / dt])
    answer = np.zeros(2 + 3 * CORNERS[kind])
    kernel(kind)(np.ascontiguousarray(nodes), 0.5 * dt, answer)
    return SCALE[kind] * answer[0], answer[2:].reshape(-1, 3) / (answer[1] / SCALE[kind])


def cell(kind, seed):
    """Corners of a distorted cell."""
    mesh = block(kind, 1, shake=0.0)
    corners = mesh.nodes[mesh.cells[0]]
    return corners + 0.02 * np.random.default_rng(seed).uniform(-1.0, 1.0, corners.shape)


def volume(kind, corners):
    """Volume of a cell with any corners, by numpy."""
    return volumes(tc.Mesh(cell(kind, 0), np.arange(CORNERS[kind])[None], kind), corners)[0][0]


@pytest.mark.parametrize("kind", CORNERS)
def test_a_rigid_step_by_any_rotation_has_no_rate_of_volume(kind):
    """Steps by one radian and more, with a translation."""
    for seed in range(3):
        start, turn = cell(kind, seed), meshes.rotation(seed)
        end = start @ turn.T + (0.3, -0.1, 0.2)
        rate, _ = of_step(kind, start, end, 1e-3)
        assert abs(rate) <= 1e-12 * volume(kind, start) / 1e-3


@pytest.mark.parametrize("kind", CORNERS)
def test_the_rate_of_volume_of_a_step_is_exact_to_third_order(kind):
    """V' dt is the change of volume less a quarter of the volume that the moves of the corners span, as V is cubic."""
    start = cell(kind, 4)
    end = start + 0.02 * np.random.default_rng(5).uniform(-1.0, 1.0, start.shape)
    change = volume(kind, end) - volume(kind, start) - 0.25 * volume(kind, end - start)
    assert of_step(kind, start, end, 1e-3)[0] * 1e-3 == pytest.approx(change, rel=1e-12)


@pytest.mark.parametrize("kind", CORNERS)
def test_the_force_at_both_ends_of_a_rigid_step_does_no_work(kind):
    """The mean of the slopes of volume at both ends, along which the force acts, gives the same rate: none."""
    start, turn = cell(kind, 1), meshes.rotation(7)
    end = start @ turn.T
    rate = 1e-3 * np.random.default_rng(0).uniform(-1.0, 1.0, start.shape)  # any, so that the force is not 0
    slopes = [of_step(kind, corners - 1e-12 * rate, corners, 1e-12)[1] for corners in (start, end)]
    work = 0.5 * ((slopes[0] + slopes[1]) * (end - start)).sum()
    assert abs(work) <= 1e-11 * (np.abs(slopes[1]) * np.abs(end - start)).sum()


def spinning(kind, formulation, mat, turns=2.0):
    """A block that spins freely about an axis across, from its shape at rest; angular speed .05 c/L."""
    mesh = block(kind, (3, 3, 2), (0.3, 0.3, 0.1), shake=0.1)
    spin = 0.05 * mat.wave_speed / 0.3 * np.array([0.0, 0.6, 0.8])
    centre = np.array([0.15, 0.15, 0.05])
    velocity = np.cross(spin, np.asarray(mesh.nodes) - centre)
    body = tc.Body(mesh, mat, velocity=velocity, formulation=formulation)
    return tc.Scene([body], duration=turns * 2.0 * np.pi / np.linalg.norm(spin), viscosity=tc.BulkViscosity())


@pytest.mark.parametrize(("kind", "formulation", "metal"), [
    ("hex8", "full", False), ("tet4", "full", False), ("wedge6", "full", False), ("hex8", "reduced", False),
    ("hex8", "mean-dilatation", True), ("tet4", "node-averaged", False),
])  # fmt: skip
def test_a_free_spin_dissipates_what_its_energy_loses(kind, formulation, metal):
    """What it dissipates is the vibration in which it starts; slopes at the end of a step see w^2 dt of expansion."""
    mat = material("neo")
    if metal:
        hardening = tc.LinearHardening(1e-2 * 2.3e7, 0.0)
        mat = tc.ElastoPlastic(young=2.3e7, poisson=0.27, density=1350.0, hardening=hardening, specific_heat=400.0)
    history = simulate(spinning(kind, formulation, mat), cfl=0.9).history
    energy = sum(history[name] for name in ("kinetic", "elastic", "hourglass") if name in history)
    gone, booked = energy[0] - energy[-1], history["viscous_work"][-1]
    assert booked <= 5e-4 * energy[0]
    assert booked == pytest.approx(gone, abs=3e-5 * energy[0])
    assert history["energy_error"].max() <= 3e-5


def test_mixed_precision_spins_as_float64_does():
    """The rate of volume is made of slopes and velocities; of a difference of volumes float32 would leave nothing."""
    scene = spinning("hex8", "full", material("neo"), turns=0.5)
    one, other = (simulate(scene, cfl=0.9, precision=precision).history for precision in ("f64", "mixed"))
    assert other["viscous_work"][-1] == pytest.approx(one["viscous_work"][-1], rel=1e-3)
