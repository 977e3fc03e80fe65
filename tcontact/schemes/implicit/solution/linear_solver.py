"""Solve the linear systems of Newton's method: sparse LU for small or stiff bodies, else BiCGStab (METHOD 4).

The tangents are not symmetric. Blocks [b, 3, 3] come in the fixed sparsity; the preconditioner is the inverse of the
diagonal blocks, which the inertia of a step keeps well conditioned.
"""

from __future__ import annotations

import numpy as np

from ....device import arrays
from ....device.launch import Prepared
from .sparsity import Sparsity

DIRECT = 900  # unknowns up to which a factorisation is cheaper
STIFF = 100.0  # lam/mu from which Krylov methods need too many products
MAXIMUM_PRODUCTS = 500  # maximum number of products of BiCGStab


class NoSolution(ArithmeticError):
    """The linear system could not be solved."""


def choose(unknowns: int, ratio: float, wanted: str = "auto") -> str:
    """Return "direct" or "krylov" for so many unknowns and a ratio lam/mu."""
    if wanted != "auto":
        return wanted
    return "direct" if unknowns <= DIRECT or ratio >= STIFF else "krylov"


class Direct:
    """Sparse LU factors by SuperLU."""

    def __init__(self, sparsity: Sparsity) -> None:
        import scipy.sparse

        count = len(sparsity.diagonal)
        shape = (3 * count, 3 * count)
        places = np.arange(9 * len(sparsity.columns), dtype=float).reshape(-1, 3, 3) + 1.0
        pattern = scipy.sparse.bsr_matrix((places, sparsity.columns, sparsity.starts), shape=shape).tocsc()
        self.order = (pattern.data - 1.0).astype(np.int64)
        self.matrix = pattern

    def solve(self, blocks: np.ndarray, right: np.ndarray, tolerance: float) -> np.ndarray:
        """Solve K x = right, both [n, 3]. Raises `NoSolution` for a singular matrix."""
        from scipy.sparse.linalg import splu

        self.matrix.data = blocks.reshape(-1)[self.order]
        try:
            factors = splu(
                self.matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise NoSolution(str(error)) from error
        x = factors.solve(right.reshape(-1))
        if not np.isfinite(x).all():
            raise NoSolution("the tangent is singular")
        return x.reshape(right.shape)


class Krylov:
    """BiCGStab with block-Jacobi preconditioning (van der Vorst, SIAM J. Sci. Stat. Comput. 13, 631, 1992).

    Where it does not converge or breaks down, at very large steps, `Direct` solves.
    """

    def __init__(self, sparsity: Sparsity) -> None:
        from ....kernels.cells import implicit_cells

        self.sparsity = sparsity
        self.spare: Direct | None = None
        self.product = Prepared(implicit_cells.block_product)
        self.starts = arrays.put(sparsity.starts.astype(np.int32))
        self.columns = arrays.put(sparsity.columns.astype(np.int32))
        self.blocks = arrays.zeros(9 * len(sparsity.columns))
        self.x, self.y = arrays.zeros(3 * len(sparsity.diagonal)), arrays.zeros(3 * len(sparsity.diagonal))

    def _times(self, x: np.ndarray) -> np.ndarray:
        arrays.set_values(self.x, x)
        self.product(self.starts, self.columns, self.blocks, self.x, self.y)
        return np.array(arrays.get(self.y))

    def solve(self, blocks: np.ndarray, right: np.ndarray, tolerance: float) -> np.ndarray:
        """Solve K x = right, both [n, 3], to a relative residual of `tolerance`. Raises `NoSolution`."""
        try:
            with np.errstate(all="ignore"):  # it may diverge
                return self._iterate(blocks, right, tolerance)
        except NoSolution:
            self.spare = self.spare or Direct(self.sparsity)
            return self.spare.solve(blocks, right, tolerance)

    def _iterate(self, blocks: np.ndarray, right: np.ndarray, tolerance: float) -> np.ndarray:
        arrays.set_values(self.blocks, blocks)
        try:
            inverse = np.linalg.inv(blocks[self.sparsity.diagonal])
        except np.linalg.LinAlgError as error:
            raise NoSolution("a diagonal block of the tangent is singular") from error

        def scaled(vector: np.ndarray) -> np.ndarray:
            return np.einsum("nij,nj->ni", inverse, vector.reshape(-1, 3)).reshape(-1)

        r = right.reshape(-1).astype(float)
        x = np.zeros_like(r)
        shadow, goal = r.copy(), tolerance * norm(r)
        rho = alpha = omega = 1.0
        v = p = np.zeros_like(r)
        for _ in range(MAXIMUM_PRODUCTS):
            if norm(r) <= goal:
                return x.reshape(right.shape)
            before, rho = rho, inner(shadow, r)
            if rho == 0.0 or omega == 0.0:
                break
            p = r + (rho / before) * (alpha / omega) * (p - omega * v)
            direction = scaled(p)
            v = self._times(direction)
            along = inner(shadow, v)
            if along == 0.0:  # no direction is left where the residual stagnates
                break
            alpha = rho / along
            s = r - alpha * v
            turned = scaled(s)
            t = self._times(turned)
            square = inner(t, t)
            omega = inner(t, s) / square if square > 0.0 else 0.0
            x += alpha * direction + omega * turned
            r = s - omega * t
            if not np.isfinite(omega):
                break
        if norm(r) <= goal and np.isfinite(x).all():
            return x.reshape(right.shape)
        raise NoSolution(f"BiCGStab stopped at {norm(r) / max(norm(right), 1e-300):.1e} of the residual")


def inner(a: np.ndarray, b: np.ndarray) -> float:
    """Return a.b without BLAS, whose idle threads would occupy cores that the kernels need."""
    return float((a * b).sum())


def norm(a: np.ndarray) -> float:
    """Return the Euclidean length."""
    return float(np.sqrt((a * a).sum()))


def make_solver(kind: str, sparsity: Sparsity) -> Direct | Krylov:
    """Make the solver of that name."""
    return Direct(sparsity) if kind == "direct" else Krylov(sparsity)
