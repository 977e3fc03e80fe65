"""A slave face astride a step: what lies lower, on another body or on the same one, is not pressed across its gap."""

import numpy as np
import pytest
from pair_scenes import soft

import tcontact as tc


def plates(step):
    """Return two plates side by side, the right one lower by a step."""
    left, right = (tc.box_mesh((1, 1, 1), (4, 4, 4), origin=at) for at in ((0, 0, -1), (1.06, 0, -1 - step)))
    held = [tc.Support("zmin", "xyz")]
    law = soft(poisson=0.0)
    return [
        tc.Body(left, law, contact="zmax", name="high", supports=held),
        tc.Body(right, law, contact="zmax", name="low"),
    ]


def stair(step):
    """Return one block whose right half is lower by a step with a vertical wall."""
    mesh = tc.box_mesh((2, 1, 1), (8, 4, 5), origin=(0, 0, -1))
    nodes = mesh.nodes.copy()
    nodes[:, 2] = np.array([-1.0, -0.75, -0.5, -0.3, -step, 0.0])[np.rint((nodes[:, 2] + 1.0) / 0.2).astype(int)]
    centres = nodes[mesh.cells].mean(axis=1)
    cells = mesh.cells[(centres[:, 0] < 1.0) | (centres[:, 2] < -step)]
    used, cells = np.unique(cells, return_inverse=True)
    return [tc.Body(tc.Mesh(nodes[used], cells.reshape(-1, 8), "hex8"), soft(poisson=0.0), contact="all", name="stair")]


@pytest.mark.parametrize(
    ("masters", "step", "start"), [(plates, 0.05, 0.24), (plates, 0.1, 0.15), (plates, 0.17, 0.24), (stair, 0.17, 0.24)]
)
def test_what_lies_below_a_step_is_not_pressed_across_the_gap(masters, step, start):
    """The reach is .0625: the lower faces lie within it, within three of them, and behind the wall of one body."""
    mesh = tc.box_mesh((1, 0.7, 0.5), (4, 3, 2), origin=(start, 0.15, 0.001))
    upper = tc.Body(mesh, soft(young=0.5, poisson=0.0), (0, 0, -0.03), contact="zmin", name="up")
    bodies = [*masters(step), upper]
    pairs = [tc.Pair("up", body.name, slave="up") for body in bodies[:-1]]
    scene = tc.Scene(bodies, duration=2.0, contact=tc.MasslessContact("full"), pairs=pairs)
    result = tc.simulate(scene, scheme=tc.CentralDifference(cfl=0.8))
    assert result.ok
    lower = np.concatenate([body.mesh.nodes for body in bodies[:-1]])
    lower = np.flatnonzero((np.abs(lower[:, 2] + step) < 1e-9) & (lower[:, 0] > 1.0 + 1e-9))
    assert len(lower)
    assert not result.contact_node_force[lower].any()
    assert np.abs(result.history["energy_error"]).max() <= 0.011
    if masters is plates:
        assert not np.abs(result.velocity[result.nodes_of("low")]).any()
