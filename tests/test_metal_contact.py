"""Contact of metals: tangent of plastic flow, removal of mass, impacts of two metal bodies."""

import numpy as np
import pytest
from contact_stiffness import contact_plan, contact_stiffness, spread_of
from one_point import distorted
from scenes import block, force_of

import tcontact as tc
from tcontact.device import arrays
from tcontact.planning.packing import WIDTH

LINEAR = tc.LinearHardening(400e6, 100e6)
GUINAN = tc.SteinbergGuinan(400e6, 36.0, 0.45, 0.0, 3e-4, 1e-3, 1356.0)  # hardening by pressure is not symmetric
COOK = tc.JohnsonCook(90e6, 292e6, 0.31, 0.025, 1.09, 1356.0)
SIZE = 0.06  # of a cell [m]
STATE = 8  # numbers of a point
STRAIN = 6  # place of the plastic strain among them


def copper(hardening=LINEAR, **options):
    return tc.ElastoPlastic(117e9, 0.35, 8930.0, hardening, specific_heat=390.0, **options)


class Committed:
    """The force pass of a body over a plane, whose points keep the state of the displacements committed."""

    def __init__(self, body, removal):
        self.plan = contact_plan(body, removal)
        self.term = force_of(self.plan)
        self.rest = arrays.zeros(self.plan.reference.size)

    def commit(self, u):
        self.term.advance(self._placed(u), self.rest, 0.0, 0.0, 0.0, before=1e-7)

    def harden(self):
        """Give all points a plastic strain so large that they are elastic."""
        arrays.get(self.term.memory).reshape(-1, STATE, WIDTH)[:, STRAIN] = 50.0

    def force(self, u):
        """Return the force of the contact cells at the contact nodes [3k]; commits nothing."""
        self.term.measure_surface(self._placed(u), self.rest)
        rows, lists = np.array(arrays.get(self.term.rows)).reshape(-1, 3), np.array(arrays.get(self.term.corner_rows))
        count = len(self.plan.contact.nodes)
        return np.array([rows[lists[lists[k] : lists[k + 1]]].sum(axis=0) for k in range(count)]).ravel()

    def _placed(self, u):
        return arrays.put(np.ascontiguousarray(u[self.plan.node_order]).ravel())


@pytest.mark.parametrize("step", [2e-3, 2e-2, 0.0])
@pytest.mark.parametrize(
    ("kind", "formulation", "hardening", "removal"),
    [
        ("hex8", "mean-dilatation", LINEAR, "full"),
        ("hex8", "mean-dilatation", LINEAR, "normal"),
        ("hex8", "mean-dilatation", GUINAN, "full"),
        pytest.param("hex8", "mean-dilatation", COOK, "full", marks=pytest.mark.slow),
        ("hex8", "reduced", LINEAR, "full"),
        pytest.param("hex8", "full", LINEAR, "full", marks=pytest.mark.slow),
        ("tet4", "full", LINEAR, "full"),
    ],
)
def test_contact_tangent_is_the_slope_of_the_force_from_the_committed_state(
    kind, formulation, hardening, removal, step
):
    """After a random plastic path, in plastic flow, and (step 0) in elasticity; it is symmetric."""
    mesh = distorted((3, 3, 2), 0.2, inner_only=True) if kind == "hex8" else block(kind, 2)
    body = tc.Body(mesh, copper(hardening), formulation=formulation, contact="zmin")
    committed, random = Committed(body, removal), np.random.default_rng(4)
    stretch = np.diag([0.09, 0.09, -0.18]) + np.array([[0, 0.03, 0], [0, 0, 0.06], [0.015, 0, 0]])
    for share in np.linspace(0.0, 1.0, 5):
        u = share * mesh.nodes @ stretch.T + 0.02 * SIZE * random.uniform(-1, 1, mesh.nodes.shape)
        committed.commit(u)
    if step == 0.0:
        committed.harden()
    u = u + step * SIZE * random.uniform(-1, 1, u.shape)
    found, nodes, basis = contact_stiffness(body, removal, u, committed.term)
    dofs, spread = spread_of(nodes, basis)
    columns = []
    for dof in dofs:
        way = np.zeros(u.size)
        way[dof] = 1e-7 * SIZE
        way = way.reshape(u.shape)
        columns.append((committed.force(u + way) - committed.force(u - way)) / (2e-7 * SIZE))
    slope = spread.T @ np.stack(columns, axis=1) @ spread
    largest = np.abs(slope).max()
    assert np.abs(found - slope).max() <= (2e-3 if step else 1e-6) * largest
    assert np.abs(found - found.T).max() <= 1e-14 * largest
