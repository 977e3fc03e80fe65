"""Nodes of a contact set that supports hold are masters of other bodies: the forces on them are in the nodal forces."""

import numpy as np
import pytest
from scenes import simulate

import tcontact as tc

RUBBER = tc.NeoHookean(1e7, 0.3, 1e3)
CONTACTS = {
    "full": (tc.MasslessContact("full"), None),
    "normal": (tc.MasslessContact("normal"), tc.Coulomb(0.2)),
    "penalty": (tc.PenaltyContact(1e9), tc.Coulomb(0.2)),
}


@pytest.mark.parametrize("name", CONTACTS)
def test_nodal_forces_of_both_bodies_are_the_force_of_the_pair(name, tmp_path):
    """A block falls onto another one, of which a side with nodes of the contact set is held."""
    contact, friction = CONTACTS[name]
    side = [tc.Support("xmin", "xyz")]
    held = tc.Body(tc.box_mesh((0.06, 0.06, 0.04), (2, 2, 2)), RUBBER, name="held", contact="zmax", supports=side)
    block = tc.box_mesh((0.06, 0.06, 0.04), (3, 3, 2), origin=(0.003, 0.0, 0.0401))
    upper = tc.Body(block, RUBBER, (0, 0, -3.0), name="upper", contact="zmin")
    scene = tc.Scene([held, upper], duration=1e-3, contact=contact, friction=friction)
    result = simulate(scene, out=tmp_path / "run", frames=1)
    expected, force = result.history["pair_force:held-upper"][-1], result.contact_node_force
    scale = np.linalg.norm(expected)
    assert scale > 1.0
    for body, sign in (("held", 1.0), ("upper", -1.0)):
        np.testing.assert_allclose(force[result.nodes_of(body)].sum(axis=0), sign * expected, atol=1e-9 * scale)
    on_held = force[result.nodes_of("held")][held.mesh.nodes_of("xmin")]
    assert np.linalg.norm(on_held, axis=1).max() > 0.01 * scale
    last = result.frames.frame(-1).point_data
    np.testing.assert_array_equal(last["contact_force"], force.astype(last["contact_force"].dtype))
    loaded = np.linalg.norm(force, axis=1) > 0.0
    assert (last["contact_pressure"][loaded] > 0.0).all()
    assert last["contact_pressure"].max() < 20.0 * scale / 0.06**2
