"""A single material point of a law with plastic flow, driven along a path of deformation gradients."""

import functools

import numpy as np

from tcontact.device import runtime


@functools.cache
def _kernel(law):
    runtime.start("cpu")
    import taichi as ti

    from tcontact.kernels.language.arguments import ARRAY
    from tcontact.kernels.materials import LAWS

    known = LAWS[law]
    size, count = len(known.state), len(known.parameters) + known.plastic.rates
    width = 11 + size

    @ti.kernel
    def drive(path: ARRAY, parameters: ARRAY, state: ARRAY, out: ARRAY):
        ti.loop_config(serialize=True)
        for n in range(path.shape[0] // 9):
            h = [[path[9 * n + 3 * i + j] for j in range(3)] for i in range(3)]
            old = [state[i] for i in range(size)]
            answer = known.update(h, [parameters[i] for i in range(count)], old, [])
            for i in ti.static(range(3)):
                for j in ti.static(range(3)):
                    out[width * n + 3 * i + j] = answer[0][i][j]
            out[width * n + 9] = answer[1]
            out[width * n + 10] = answer[4]
            for i in ti.static(range(size)):
                out[width * n + 11 + i] = answer[3][i]
                state[i] = answer[3][i]

    return drive


def state_size(law):
    """Return how many numbers of state a point of a law has."""
    from tcontact.kernels.materials import LAWS

    return len(LAWS[law].state)


class Path:
    """What a point went through: P [n, 3, 3], W [n], dissipation of every step [n], state [n, s] and F [n, 3, 3]."""

    def __init__(self, material, gradients, state=None, step=0.0):
        """Drive a material along F - I [n, 3, 3]; state [s]: at the start; step [s]: of every increment."""
        gradients = np.asarray(gradients, dtype=float)
        self.f = gradients + np.eye(3)
        parameters = np.array([*material.parameters, step])
        drive = _kernel(material.law)
        size = state_size(material.law)
        state = np.zeros(size) if state is None else np.array(state, dtype=float)
        out = np.zeros((len(gradients), 11 + size))
        drive(gradients.reshape(-1).copy(), parameters, state, out.reshape(-1))
        self.p, self.energy, self.lost = out[:, :9].reshape(-1, 3, 3), out[:, 9], out[:, 10]
        self.state, self.strain, self.warming = out[:, 11:], out[:, 17], out[:, 18]

    @property
    def kirchhoff(self):
        """Return tau = P F^t."""
        return np.einsum("nij,nkj->nik", self.p, self.f)

    @property
    def mises(self):
        """Return the von Mises norm of tau."""
        tau = self.kirchhoff
        s = tau - np.trace(tau, axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3.0
        return np.sqrt(1.5 * np.einsum("nij,nij->n", s, s))

    @property
    def inverse_plastic(self):
        """Return Cp^-1 [n, 3, 3]."""
        d = self.state
        full = np.empty((len(d), 3, 3))
        for place, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
            full[:, i, j] = full[:, j, i] = d[:, place]
        return full + np.eye(3)

    @property
    def closure(self):
        """Return (W + dissipation - work)/work at the end, the work by the trapezoidal rule from the start at rest."""
        before = np.concatenate([np.eye(3)[None], self.f[:-1]])
        earlier = np.concatenate([np.zeros((1, 3, 3)), self.p[:-1]])
        work = 0.5 * np.einsum("nij,nij->", self.p + earlier, self.f - before)
        return float((self.energy[-1] + self.lost.sum() - work) / work)
