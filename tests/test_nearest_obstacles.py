"""Which obstacles a node knows where there are more than it can touch at once (kernels/contact/obstacle_rows.py)."""

import numpy as np
import pytest
import taichi as ti

from tcontact.device import arrays
from tcontact.kernels.contact import obstacle_rows, obstacles
from tcontact.kernels.lanes import MAXIMUM_SLOTS
from tcontact.kernels.language.arguments import ARRAY, INDEX
from tcontact.kernels.language.bundles import Contact, ContactOptions, Obstacles

OPTIONS = ContactOptions(slots=MAXIMUM_SLOTS)


@ti.kernel
def choose(nodes: INDEX, islands: INDEX, records: ARRAY, candidates: INDEX, reference: ARRAY, u: ARRAY):
    contact = ti.static(Contact(nodes=nodes, islands=islands, reference=reference, options=OPTIONS))
    known = ti.static(Obstacles(records=records, motion=records, candidates=candidates, options=OPTIONS))
    obstacle_rows.choose_candidates(known, contact, u)


def chosen(gaps, known):
    """Obstacles of a node that lies `gaps` above planes across x, y, z, x, ... and knew others before."""
    normals = np.eye(3)[np.arange(len(gaps)) % 3]
    records = np.zeros((len(gaps), obstacles.RECORD))
    records[:, obstacles.FRAME + 6 : obstacles.FRAME + 9] = normals
    records[:, obstacles.POINT : obstacles.POINT + 3] = -np.asarray(gaps)[:, None] * normals
    candidates, islands = (arrays.put(np.array(values)) for values in (known, [0, 0, 0, 0, 1, 0, 1, 0]))
    choose(np.zeros(1, dtype=np.int32), islands, records.reshape(-1), candidates, np.zeros(3), np.zeros(3))
    return arrays.get(candidates).tolist()


def test_a_node_takes_the_three_nearest_obstacles_in_the_order_of_the_scene():
    assert chosen([4.0, 0.1, 3.0, -0.2, 0.3], [0, 1, 2]) == [1, 3, 4]
    assert chosen([0.1, 4.0, -0.2, 0.3, 3.0], [0, 1, 2]) == [0, 2, 3]
    assert chosen([0.3, 0.2, 0.1, 0.0], [0, 1, 2]) == [1, 2, 3]


@pytest.mark.parametrize("known", [[0, 1, 2], [2, 0, 1], [1, 2, 0]])
@pytest.mark.parametrize("gaps", [[0.0, 1e-9, -1e-9, 1.0], [3e-3, 2e-3, 1e-3, 1.0]])
def test_obstacles_keep_their_slots_while_they_are_the_same(gaps, known):
    """What a node keeps of its obstacles, such as their friction of the row before, stays with them."""
    assert chosen(gaps, known) == known
