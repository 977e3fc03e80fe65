"""Node-averaged tetrahedra all of whose nodes are held: each cell has its own volume change, as in full integration."""

from dataclasses import replace

import numpy as np
import pytest
from one_point import moved
from scenes import block, material, simulate
from test_node_averaged import AVERAGED, force_of

import tcontact as tc

PLATE = tc.RigidPart("zmax", mass=0.01, velocity=(0.3, 0.0, 1.0))


def layer(**options):
    """One layer of tetrahedra between a held face and a rigid plate, such as glue."""
    mesh = block("tet4", (3, 3, 1), size=(0.1, 0.1, 0.02))
    supports = [tc.Support("zmin", "xyz")]
    return tc.Body(mesh, material(poisson=0.49), formulation=AVERAGED, supports=supports, **options)


@pytest.mark.filterwarnings("ignore::tcontact.LockingWarning")
@pytest.mark.parametrize("contact", [None, "zmin"])
@pytest.mark.parametrize("path", ["serial", "parallel"])
def test_a_layer_without_a_free_node_is_that_of_full_integration(contact, path, request):
    """A run with nothing else in its domain, also with massless contact: it could not start."""
    if path == "parallel":
        request.getfixturevalue("parallel_path")
    body = layer(rigid_parts=[PLATE], contact=contact)
    plane = tc.Plane((0, 0, -1e-3), (0, 0, 1.0))
    results = [
        simulate(tc.Scene([one], [plane] if contact else [], duration=1e-3), dt=1e-5)
        for one in (body, replace(body, formulation="full"))
    ]
    found, wanted = (result.history["elastic"] for result in results)
    assert wanted.max() > 1e-3
    assert np.abs(found - wanted).max() <= 1e-12 * wanted.max()
    assert np.abs(results[0].position - results[1].position).max() <= 1e-14


@pytest.mark.parametrize("first", ["held", "free"])
def test_a_region_without_a_free_node_leaves_the_averages_of_others(first):
    """Two regions of one law, one of them held, are the body of one region.

    With the held region first the free nodes had the averages of their neighbours in the list.
    """
    mesh = block("tet4", (3, 3, 4), shake=0.0)
    height = mesh.nodes[:, 2]
    low = mesh.nodes[mesh.cells].mean(axis=1)[:, 2] < 0.25 * height.max()
    mesh = mesh.with_sets(
        node_sets={"bottom": np.flatnonzero(height < 0.26 * height.max())},
        cell_sets={"held": np.flatnonzero(low), "free": np.flatnonzero(~low)},
    )
    law = material(poisson=0.499)
    other = replace(law, density=2.0 * law.density)  # another material of the same stress
    materials = {first: law, "free" if first == "held" else "held": other}
    whole, parts = (
        force_of(tc.Body(mesh, one, formulation=AVERAGED, supports=[tc.Support("bottom", "xyz")]))
        for one in (law, materials)
    )
    u = moved(mesh, 0.1)
    wanted, found = whole(u), parts(u)
    assert parts.energy == pytest.approx(whole.energy, rel=1e-12)
    assert np.abs(found - wanted).max() <= 1e-12 * np.abs(wanted).max()
