"""Contact nodes under the edges of a block: held on an edge, and told of where normal removal lets them in."""

import re
import warnings

import numpy as np
import pytest
from conftest import THREADS

import tcontact as tc

HALF, DEPTH, RISE = 0.1, 1e-3, 0.03
TOP = 0.2
LAW = tc.LinearElastic(1e7, 0.3, 1000.0)


def pressed(removal="normal", beyond=0.0, held=("zmin", "xyz")):
    """Press a square punch into a block; beyond [m]: how far its edges lie outside of lines of nodes."""

    def velocity(t):
        return 0.0, 0.0, -DEPTH * np.pi / (2.0 * RISE) * np.sin(np.pi * t / RISE) if t < RISE else 0.0

    mesh = tc.box_mesh((4.0 * HALF, 4.0 * HALF, TOP), (4, 4, 2), origin=(-2.0 * HALF, -2.0 * HALF, 0.0))
    body = tc.Body(mesh, LAW, contact="zmax", supports=[tc.Support(*held)], name="block")
    width = 2.0 * (HALF + beyond)
    punch = tc.Box((0.0, 0.0, TOP + HALF), (width, width, 2.0 * HALF), velocity=velocity, name="punch")
    contact = tc.MasslessContact(removal)
    scene = tc.Scene([body], [punch], duration=0.04, damping=tc.MassDamping(200.0), contact=contact)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = tc.simulate(scene, threads=THREADS)
    assert result.ok
    return result


def test_nodes_that_begin_under_an_edge_stay_out_of_the_block():
    """With normal removal contact may hold them by each face of their edge or corner, as with full removal."""
    found, full = pressed("normal"), pressed("full")
    assert found.history["gap_min"].min() > -1e-12
    assert not found.warnings
    forces = [result.history["obstacle_force:punch"][-1, 2] for result in (found, full)]
    assert forces[1] > 100.0
    assert abs(forces[0] / forces[1] - 1.0) < 1e-4


def told(result):
    """Return the only warning about a node inside an obstacle."""
    (text,) = (text for text in result.warnings if "inside obstacle" in text)
    return text


def test_a_node_that_comes_back_beside_an_edge_is_told_of():
    """It steps out of the footprint and comes back to the side face, across which it has kept its mass.

    It is not one of the nodes that the support holds.
    """
    result = pressed(beyond=1e-8)
    found = re.search(
        r"contact node (\d+) of block at \((.*)\) ends (\S+) m inside obstacle punch at t = (\S+) s",
        text := told(result),
    )
    node, place, depth, time = found.groups()
    assert np.allclose([float(part) for part in place.split(",")], result.position[int(node)], atol=1e-6)
    assert abs(result.position[int(node)][:2]).max() < HALF + 1e-8
    assert float(time) == pytest.approx(result.time, rel=1e-5)
    assert 1e-7 < float(depth) <= -result.history["gap_min"][-1] * 1.01
    assert "removal='full'" in text
    assert "support" not in text


@pytest.mark.parametrize("axes", ["z", "xyz"])
def test_a_node_that_a_support_holds_inside_is_said_to_be_held(axes):
    text = told(pressed("full", held=("zmax", axes)))
    assert f"ends {DEPTH:.3g} m inside obstacle punch" in text
    assert text.endswith("its support holds it there")
