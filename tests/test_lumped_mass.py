"""Masses of cells and area weights of faces against exact integrals of the shape functions (METHOD 1)."""

import numpy as np
import oracle
import pytest
from oracle import meshes
from scenes import block

import tcontact as tc
from tcontact.planning.lumped_mass import corner_masses, node_areas


def test_area_weight_of_a_corner_of_a_triangle_is_a_third_of_its_area():
    nodes = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0], [9.0, 9.0, 9.0]]) @ meshes.rotation(3).T
    assert node_areas(nodes, np.array([[0, 1, 2]])) == pytest.approx([2.0, 2.0, 2.0, 0.0], rel=1e-14)


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_area_weights_integrate_what_is_linear_over_plane_faces(kind):
    """The sum of A_k is the area, the sum of A_k x_k the integral of x."""
    mesh = tc.box_mesh((0.3, 0.5, 0.7), (2, 3, 4), kind)
    areas = node_areas(mesh.nodes, mesh.faces_of("zmin"))
    assert areas.sum() == pytest.approx(0.3 * 0.5, rel=1e-13)
    assert areas @ mesh.nodes == pytest.approx(0.15 * np.array([0.15, 0.25, 0.0]), rel=1e-13, abs=1e-17)
    assert not np.delete(areas, mesh.nodes_of("zmin")).any()


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_area_weights_of_a_curved_skin_are_those_of_the_oracle(kind):
    mesh = block(kind, 3, turn=meshes.rotation(8))
    generator = np.random.default_rng(2)
    nodes = mesh.nodes + 0.01 * generator.uniform(-1.0, 1.0, mesh.nodes.shape)
    faces = mesh.faces_of(["zmin", "xmin"])
    assert node_areas(nodes, faces) == pytest.approx(oracle.face_area_weights(nodes, np.array(faces)), rel=1e-12)


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_masses_of_cells_have_the_mass_and_the_centre_of_the_body(kind):
    mesh = tc.box_mesh((0.3, 0.5, 0.7), (2, 3, 4), kind)
    masses = corner_masses(kind, mesh.nodes, mesh.cells, 7.0)
    lumped = np.zeros(mesh.node_count)
    np.add.at(lumped, mesh.cells, masses)
    assert lumped.sum() == pytest.approx(7.0 * 0.3 * 0.5 * 0.7, rel=1e-13)
    assert lumped @ mesh.nodes / lumped.sum() == pytest.approx([0.15, 0.25, 0.35], rel=1e-12)
    assert masses.min() > 0.0
