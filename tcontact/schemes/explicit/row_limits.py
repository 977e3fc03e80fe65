"""Limits at which a launch of several steps ends early, because the host must look at a row before the next one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class RowLimits(NamedTuple):
    """Values of a row of the history up to which the next step may follow in the same launch.

    jacobian: smallest det F, which must stay above it; energy: kinetic and elastic [J]; viscous_rate: of the bulk
    viscosity [1/s]; contact_nodes: number of nodes in contact; rigid_rate: of obstacles that move freely [1/s^2].
    """

    jacobian: float = -np.inf
    energy: float = np.inf
    viscous_rate: float = np.inf
    contact_nodes: float = np.inf
    rigid_rate: float = np.inf


NO_LIMITS = RowLimits()
