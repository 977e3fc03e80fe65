"""Bodies of one-point hexes, or of a mean dilatation, their force pass by itself and the same in numpy."""

import numpy as np
import oracle
from oracle import meshes
from scenes import TWINS, force_of, material

import tcontact as tc
from tcontact.device import arrays

SIZE = (0.2, 0.22, 0.18)


def distorted(cells=(3, 2, 3), share=0.25, seed=0, size=SIZE, inner_only=False):
    """A box whose nodes are moved at random by up to a share of a cell; flat outer faces if inner_only."""
    box = tc.box_mesh(size, cells)
    if inner_only:
        nodes = meshes.shaken(np.array(box.nodes), share * min(np.array(size) / cells), seed)
    else:
        move = np.random.default_rng(seed).uniform(-share, share, box.nodes.shape)
        nodes = box.nodes + move * np.array(size) / cells
    return tc.Mesh(nodes, box.cells, "hex8", face_sets=box.face_sets)


def body_of(mesh, law="neo", formulation="reduced", poisson=0.27, **how):
    return tc.Body(mesh, material(law, poisson=poisson), formulation=formulation, **how)


def twin(body):
    """Return the numpy oracle of a body: the same cells, law and formulation."""
    law = TWINS[type(body.material).__name__](body.material.young, body.material.poisson)
    kind = oracle.ReducedHex if body.formulation == "reduced" else oracle.MeanDilatation
    return kind(np.array(body.mesh.nodes), np.array(body.mesh.cells), law)


class Force:
    """The force pass of a body, in the user's numbering."""

    def __init__(self, body):
        self.plan = tc.plan(tc.Scene(bodies=[body], duration=1.0)).bodies[0]
        self.term = force_of(self.plan)

    def __call__(self, u):
        """dW/du [n, 3]; afterwards energy, jacobian and hourglass (energy) are those of u."""
        answer = arrays.zeros(u.size)
        self.term.minus_force(arrays.put(np.ascontiguousarray(u[self.plan.node_order]).ravel()), answer)
        names = ("elastic", "jacobian_min", "hourglass")
        self.energy, self.jacobian, self.hourglass = map(self.term.sum_of, names)
        force = np.empty_like(u)
        force[self.plan.node_order] = -np.array(arrays.get(answer)).reshape(-1, 3) * self.plan.lumped[:, None]
        return force

    def stiffness(self, u, step, dofs):
        """Columns of df/du [3n, dofs] by central differences."""
        columns = []
        for dof in dofs:
            way = np.zeros(u.size)
            way[dof] = step
            way = way.reshape(u.shape)
            columns.append((self(u + way) - self(u - way)).ravel() / (2 * step))
        return np.stack(columns, axis=1)


def moved(mesh, share=0.1, seed=1):
    """A random displacement of a share of a cell."""
    return share * 0.06 * np.random.default_rng(seed).uniform(-1, 1, mesh.nodes.shape)


def check_turning(body, force, share):
    """Check that a rotation of the moved body turns its forces and leaves its energy; share: see `moved`."""
    nodes, u, turn = body.mesh.nodes, moved(body.mesh, share), meshes.rotation(9)
    before = force(u)
    energy = force.energy
    after = force((nodes + u) @ turn.T - nodes)
    assert np.abs(after - before @ turn.T).max() <= 1e-12 * np.abs(before).max()
    assert abs(force.energy - energy) <= 1e-12 * energy
