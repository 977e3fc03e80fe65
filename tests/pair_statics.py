"""Dense statics of bodies of linear laws in contact: the stiffness of the oracle, the coupling rows of the code."""

import numpy as np
from oracle.cells import displacement_gradient, quadrature, tangent
from oracle.laws import LinearElastic
from oracle.static_contact import solve_lcp

import tcontact as tc
from tcontact.contact.pairs.coupling import couple
from tcontact.contact.pairs.search import close_faces
from tcontact.contact.pairs.surfaces import area_vectors, facings_of, surfaces_of


class Statics:
    """The bodies of a scene as one system, in the numbering of its domain.

    positions [n, 3]: at rest; stiffness [3n, 3n]; bodies: quadrature, law and places of the nodes of each; rows: the
    `Coupling` of every slave, built at the displacement `u` [n, 3].
    """

    def __init__(self, scene, u=0.0):
        self.domain = tc.plan(scene).domains[0]
        self.positions = self.domain.reference
        self.facings = facings_of(self.domain, surfaces_of(self.domain))
        where = self.positions + u
        self.candidates = [close_faces(facing, where) for facing in self.facings]
        pairs = zip(self.facings, self.candidates, strict=True)
        self.rows = [couple(facing, where, found) for facing, found in pairs]
        self.stiffness, self.bodies = np.zeros((self.positions.size, self.positions.size)), []
        for number, plan, start in zip(self.domain.numbers, self.domain.bodies, self.domain.node_start, strict=False):
            body = scene.bodies[number]
            mesh, law = body.mesh, LinearElastic(body.material.young, body.material.poisson)
            quad, place = quadrature(mesh.nodes, mesh.cells, mesh.kind), plan.place + start
            dof = (3 * place[:, None] + np.arange(3)).reshape(-1)
            self.stiffness[np.ix_(dof, dof)] = tangent(quad, law, 0.0 * mesh.nodes).toarray()
            self.bodies.append((quad, law, place))

    @property
    def slaves(self):
        """The nodes that have a row."""
        return np.concatenate([one.slaves for one in self.rows])

    @property
    def areas(self):
        """The area D of every row."""
        return np.concatenate([one.area for one in self.rows])

    def constraints(self, u):
        """Return the gradient [r, 3n] of the gaps of all rows at the displacement u [n, 3], and the gaps [r]."""
        positions, gradients, gaps = self.positions + u, [], []
        for one in self.rows:
            across = area_vectors(positions, one.faces)
            across *= (one.face_weights / np.linalg.norm(across, axis=1))[:, None]
            normal = np.add.reduceat(across, one.first_face[:-1])
            normal /= np.linalg.norm(normal, axis=1)[:, None]
            owner = np.repeat(np.arange(len(one.slaves)), np.diff(one.first))
            weights = np.zeros((len(one.slaves), len(positions)))
            weights[np.arange(len(one.slaves)), one.slaves] = 1.0
            np.add.at(weights, (owner, one.masters), -one.weights)
            gradients.append(np.einsum("rn,ri->rni", weights, normal).reshape(len(normal), -1))
            gaps.append(np.einsum("ri,ri->r", weights @ positions, normal))
        return np.concatenate(gradients), np.concatenate(gaps)

    def stress(self, u):
        """Return the stresses [points, 3, 3] of all bodies at the displacement u [n, 3]."""
        found = [law.stress(displacement_gradient(quad, u[place])) for quad, law, place in self.bodies]
        return np.concatenate([part.reshape(-1, 3, 3) for part in found])

    def closed(self, load):
        """Return u [n, 3] and lambda [r] of a load [n, 3] with all rows closed; free rigid motions are the smallest."""
        gradient, _gaps = self.constraints(0.0 * load)
        scale = self.stiffness[0, 0]
        whole = np.block([[self.stiffness / scale, gradient.T], [gradient, np.zeros((len(gradient), len(gradient)))]])
        right = np.concatenate([load.ravel() / scale, np.zeros(len(gradient))])
        found = np.linalg.lstsq(whole, right, rcond=1e-12)[0]
        return found[: load.size].reshape(-1, 3), -scale * found[load.size :]

    def equilibrium(self, u, free, walls=(), iterations=20):
        """Return u [n, 3] in equilibrium, and lambda >= 0 of all rows, walls last; `free` [n, 3] components move.

        walls: function that returns the gradient and the gaps of more constraints. Newton's method renews normals and
        gaps; every linear problem is solved by an active set.
        """
        u, dof = u.copy(), np.flatnonzero(free.ravel())
        compliance = np.linalg.inv(self.stiffness[np.ix_(dof, dof)])
        closed = None
        for _ in range(iterations):
            parts = [self.constraints(u)] + ([walls(u)] if walls else [])
            gradient, gaps = (np.concatenate([part[i] for part in parts]) for i in range(2))
            gradient = gradient[:, dof]
            right = -(self.stiffness @ u.ravel())[dof]
            after = gaps + gradient @ (compliance @ right)
            closed = np.zeros(len(gaps), dtype=bool) if closed is None else closed
            pressing = solve_lcp(gradient @ compliance @ gradient.T, after, closed)
            closed = pressing > 0.0
            step = compliance @ (right + gradient.T @ pressing)
            u.reshape(-1)[dof] += step
            if np.abs(step).max() <= 1e-14:
                break
        return u, pressing
