"""The largest eigenvalue of a Lanczos matrix, which is that of the body from below (METHOD 2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...base.errors import InputError
from ...planning.body_plan import BodyPlan


def top_mode(alphas: Sequence[float], betas: Sequence[float], plan: BodyPlan) -> tuple[float, float, np.ndarray]:
    """Return the largest eigenvalue, its residual and the parts of the Lanczos vectors in its mode.

    alphas, betas: diagonal of the matrix, and the lengths of the vectors that follow; plan: the body, which is named in
    the `InputError` of numbers that are not finite.
    """
    if not np.isfinite([*alphas, *betas]).all():
        raise InputError(
            f"material of {plan.label}",
            plan.body.material,
            "forces overflow; look at the units of stiffness, density, sizes and penalties",
        )
    values, vectors = np.linalg.eigh(np.diag(alphas) + np.diag(betas[:-1], 1) + np.diag(betas[:-1], -1))
    top = vectors[:, -1]
    return float(values[-1]), float(betas[-1] * abs(top[-1])), top
