"""The set-up of large bodies and obstacles: memory beside the arrays, exact masses and distances."""

import tracemalloc

import numpy as np
import pytest

import tcontact as tc
from tcontact.planning.lumped_mass import corner_masses, shape_functions
from tcontact.planning.planning import plan
from tcontact.scene.obstacles.nearest import TriangleTree, pieces_of


@pytest.mark.parametrize(("kind", "limit"), [("hex8", 4.5), ("tet4", 6.5), ("wedge6", 6.5)])
def test_a_plan_needs_little_memory_beside_its_mesh(kind, limit):
    """The peak over everything from the mesh to the plan, over the bytes of nodes and 64-bit cells.

    One more copy of the cells, or the masses of all their corners, is more than there is room for: 8 to 10 times.
    """
    count = 40 if kind == "hex8" else 24

    def planned():
        mesh = tc.box_mesh((1.0, 1.0, 1.0), (count,) * 3, kind)
        body = tc.Body(mesh, tc.NeoHookean(young=1e7, poisson=0.3, density=1e3), (0.0, 0.0, -1.0), contact="zmin")
        plane = tc.Plane((0.0, 0.0, -1e-3), (0.0, 0.0, 1.0))
        scene = tc.Scene([body], [plane], duration=1.0, contact=tc.MasslessContact())
        return mesh, [block.cells[:1] for domain in plan(scene).domains for block in domain.blocks]

    planned()  # what is imported on the way
    tracemalloc.start()
    mesh, _ = planned()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < limit * (mesh.nodes.nbytes + mesh.cells.nbytes)


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_masses_are_density_times_the_integral_of_the_shape_functions_wherever_the_cells_are(kind):
    box = tc.box_mesh((1.0, 0.7, 0.4), (12, 12, 12), kind)  # more than one portion of cells
    nodes = box.nodes + np.random.default_rng(1).uniform(-0.01, 0.01, box.nodes.shape)
    values, gradients, weights = shape_functions(kind)
    wanted = np.zeros(box.cells.shape)
    for value, gradient, weight in zip(values, gradients, weights, strict=True):
        jacobian = np.linalg.det(np.einsum("mad,ac->mdc", nodes[box.cells] - nodes[box.cells[:, :1]], gradient))
        wanted += 7.0 * weight * jacobian[:, None] * value
    assert np.allclose(corner_masses(kind, nodes, box.cells, 7.0), wanted, rtol=2e-14, atol=0.0)
    far = np.round(nodes * 2.0**30) * 2.0**-30  # exact also far from the origin
    here = corner_masses(kind, far, box.cells, 7.0)
    assert np.array_equal(corner_masses(kind, far + 4096.0, box.cells, 7.0), here)


def nearest_by_hand(corners, position):
    """Distance of a position to triangles [m, 3, 3]: all faces, edges and corners in turn."""
    found = [np.linalg.norm(corners - position, axis=2).min()]
    for a, b, c in corners:
        for start, end in ((a, b), (b, c), (c, a)):
            square = (end - start) @ (end - start)
            part = np.clip((position - start) @ (end - start) / square, 0.0, 1.0) if square > 0.0 else 0.0
            found.append(np.linalg.norm(position - start - part * (end - start)))
        normal = np.cross(b - a, c - a)
        if normal @ normal > 0.0:
            sides = [np.cross(end - start, position - start) @ normal for start, end in ((a, b), (b, c), (c, a))]
            found += [abs((position - a) @ normal) / np.linalg.norm(normal)] if min(sides) >= 0.0 else []
    return min(found)


def soup(count):
    """Triangles in the unit ball: even, needles, huge ones, doubles, and some without area."""
    rng = np.random.default_rng(count)
    corners = rng.normal(size=(count, 1, 3)) / 3.0 + 0.1 * rng.normal(size=(count, 3, 3))
    if count > 8:
        corners[0, 2], corners[1, 1:] = corners[0, 1], corners[1, 0]
        corners[2], corners[3, 0], corners[4, 1] = corners[5], corners[3, 0] + 4.0, corners[4, 0] + 1e-9
    return corners


@pytest.mark.parametrize("scale", [1.0, 1e-6, 1e6])
@pytest.mark.parametrize("count", [1, 2, 25, 300])
def test_nearest_points_are_those_of_all_triangles(count, scale):
    corners = scale * soup(count)
    rng = np.random.default_rng(7)
    grid = np.stack(np.meshgrid(*[np.linspace(-1.5, 1.5, 5)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    x = scale * np.concatenate([grid, 3.0 * rng.normal(size=(25, 3)), [[1e4, 0.0, 0.0]]])
    for pieces in (corners, pieces_of(corners, 0.3 * scale)):
        point, owner = TriangleTree(pieces).nearest(x, 0.75 * scale)
        distance = np.linalg.norm(x - point, axis=1)
        assert np.allclose(distance, [nearest_by_hand(corners, here) for here in x], rtol=1e-12, atol=1e-13 * scale)
        own = [nearest_by_hand(pieces[[number]], here) for number, here in zip(owner, x, strict=True)]
        assert np.allclose(distance, own, rtol=1e-12, atol=1e-13 * scale)
