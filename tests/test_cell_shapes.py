"""Stored shapes of cells: numbers against numpy, forces against the oracle, memory, scenes without, order of lanes."""

import numpy as np
import pytest
from one_point import Force, body_of, distorted, moved, twin
from oracle import cells as oracle_cells
from oracle import meshes
from scenes import TWINS, block, force_of, material

import tcontact as tc
from tcontact.base.memory import CACHE_LINE
from tcontact.cells import internal_force
from tcontact.device import arrays
from tcontact.kernels.language.signatures import signature_of
from tcontact.planning import cell_shapes
from tcontact.planning.node_order import lanes_apart
from tcontact.planning.packing import WIDTH

SHEAR = np.array([[1.0, 0.3, -0.2], [0.1, 1.2, 0.15], [-0.25, 0.05, 0.9]])


def sheared(cells=(3, 2, 3)):
    """A box of parallelepipeds that is turned, sheared and far away."""
    box = tc.box_mesh((0.2, 0.22, 0.18), cells)
    nodes = box.nodes @ (meshes.rotation(4) @ SHEAR).T + np.array([8.0, -4.0, 2.0])
    return tc.Mesh(nodes, box.cells, "hex8", face_sets=box.face_sets)


def tetrahedra():
    return block("tet4", (3, 2, 3))


class TetOracle:
    """Force and energy of tetrahedra in numpy."""

    def __init__(self, body):
        mesh = body.mesh
        self.quad = oracle_cells.quadrature(np.array(mesh.nodes), np.array(mesh.cells), "tet4")
        self.law = TWINS[type(body.material).__name__](body.material.young, body.material.poisson)

    def force(self, u):
        return oracle_cells.internal_force(self.quad, self.law, u)

    def energy(self, u):
        return oracle_cells.energy(self.quad, self.law, u)


def body_and_twin(kind):
    if kind == "tet4":
        body = tc.Body(tetrahedra(), material("neo", poisson=0.27))
        return body, TetOracle(body)
    body = body_of(sheared(), "neo")
    return body, twin(body)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e3])
def test_numbers_are_the_inverse_and_the_determinant_of_the_jacobian(scale):
    corners = scale * np.random.default_rng(1).uniform(-1.0, 1.0, (50, 4, 3))
    a = np.stack([corners[:, k] - corners[:, 0] for k in (1, 2, 3)], axis=2)
    found = cell_shapes.shapes(corners)
    wanted = np.linalg.inv(a).swapaxes(1, 2).reshape(-1, 9)
    size = np.abs(wanted).max(axis=1, keepdims=True)
    condition = np.linalg.cond(a)[:, None]
    assert (np.abs(found[:, :9] - wanted) <= 1e-15 * condition * size).all()
    assert (np.abs(found[:, 9] - np.linalg.det(a)) <= 4e-15 * np.linalg.norm(a, axis=1).prod(axis=1)).all()
    box = tc.box_mesh((2.0 * scale,) * 3, (1, 1, 1))  # A = 8 dX/dr = 8 scale I
    cube = cell_shapes.shapes(box.nodes[box.cells])[0]
    assert np.abs(cube[:9].reshape(3, 3) - np.eye(3) / (8.0 * scale)).max() <= 1e-15 / scale
    assert cube[9] == pytest.approx(64.0 * (2.0 * scale) ** 3, rel=1e-14)  # D = 64 V


@pytest.mark.parametrize(("kind", "variant"), [("tet4", "tet4-stored"), ("hex8-reduced", "hex8-reduced-affine")])
def test_forces_and_energy_from_stored_shapes_match_numpy_and_those_from_positions(kind, variant, monkeypatch):
    body, there = body_and_twin(kind)
    force, u = Force(body), moved(body.mesh, 0.2)
    assert force.plan.variant == variant
    found, exact = force(u), there.force(u)
    size = np.abs(exact).max()
    assert np.abs(found - exact).max() <= 2e-13 * size
    assert force.energy == pytest.approx(there.energy(u), rel=1e-12)
    hourglass = force.hourglass
    assert (hourglass > 0.01 * force.energy) == (kind == "hex8-reduced")
    positions = np.array(arrays.get(force.term.reference))
    stretched = positions.copy()
    stretched[3 * body.mesh.node_count :] *= 1.0 + 1e-6
    arrays.set_values(force.term.reference, stretched)
    assert np.abs(force(u) - exact).max() > 1e-7 * size  # the numbers are what the pass reads
    monkeypatch.setattr(cell_shapes, "LARGEST", len(body.mesh.cells) - 1)
    other = Force(body)
    assert other.plan.variant == kind
    assert np.abs(other(u) - found).max() <= 2e-13 * size
    assert other.hourglass == pytest.approx(hourglass, rel=1e-12)


def test_only_cells_with_stored_shapes_pay_for_them_and_nothing_pays_an_argument():
    """80 bytes a lane behind the positions, in the memory that the plan foresees; hexahedra and prisms have none."""
    signatures = set()
    for mesh, formulation, stored in (
        (tc.box_mesh((1, 1, 1), (2, 2, 2)), "full", False),
        (tc.box_mesh((1, 1, 1), (2, 2, 2)), "reduced", True),
        (distorted((2, 2, 2)), "reduced", False),
        (tc.box_mesh((1, 1, 1), (2, 2, 2), kind="wedge6"), "full", False),
        (tc.box_mesh((1, 1, 1), (2, 2, 2), kind="tet4"), "full", True),
    ):
        body = tc.Body(mesh, material(), formulation=formulation)
        plan = tc.plan(tc.Scene(bodies=[body], duration=1.0))
        term = force_of(plan.bodies[0])
        nodes, lanes = 3 * mesh.node_count, -(-len(mesh.cells) // WIDTH) * WIDTH
        count = -nodes % WIDTH + 10 * lanes if stored else 0
        assert term.packs.shapes == count
        assert len(arrays.get(term.reference)) == nodes + count
        indices = (term.packs.connectivity, term.packs.chunk_table, term.packs.segments, term.packs.node_info)
        assert term.packs.nbytes == sum(part.nbytes for part in indices) + 24 * term.packs.row_count + 8 * count
        signatures.add(signature_of({"body": term.bundle()}))
    assert len(signatures) == 1


def test_arrays_start_on_cache_lines():
    for count in (1, 3, 1000):
        values = arrays.put(np.arange(float(count)))
        assert values.ctypes.data % CACHE_LINE == 0
        assert (arrays.get(values) == np.arange(count)).all()


def test_packs_of_tetrahedra_have_each_node_at_most_once_at_a_corner():
    """In a box, six tetrahedra share the corner of their hexahedron: a pack takes those of eight hexahedra."""
    mesh = tc.box_mesh((1, 1, 1), (8, 4, 4), kind="tet4")
    plan = tc.plan(tc.Scene(bodies=[tc.Body(mesh, material())], duration=1.0)).bodies[0]
    packs = plan.cells.reshape(-1, WIDTH, 4)
    assert all(len(np.unique(pack[:, corner])) == WIDTH for pack in packs for corner in range(4))
    assert (np.sort(plan.cell_order) == np.arange(mesh.cell_count)).all()
    cells = np.sort(np.random.default_rng(2).integers(0, 40, (101, 4)), axis=1)
    cells = cells[np.argsort(cells[:, 0], kind="stable")]
    assert (np.sort(lanes_apart(cells[:, 0])) == np.arange(101)).all()


def test_too_many_numbers_are_refused_by_name(monkeypatch):
    from tcontact.planning import packing

    monkeypatch.setattr(packing, "MAXIMUM_STORED", 1000)
    with pytest.raises(tc.InputError, match="cells"):
        internal_force.InternalForce(tc.plan(tc.Scene([tc.Body(tetrahedra(), material())], [], 1.0)).domains[0])
