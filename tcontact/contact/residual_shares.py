"""Forces that the static solve of contact nodes leaves unbalanced, where several ranks share the contact."""

from __future__ import annotations

import numpy as np

from ..cells.internal_force import InternalForce
from ..device import arrays
from ..device.team import Team
from ..planning.partition.shared_contact import SharedContact
from .massless_contact import MasslessContactTerm


class ResidualShares:
    """Shares out what a static solve leaves unbalanced among the nodes that carry the mass of a contact node.

    f_j += sum over contact nodes k of rest_k / number of receivers of k,   j among these

    Every share is computed by one rank, and summed over all ranks with a copy of the receiver. width: nodes of the
    part of this rank that have such shares.
    """

    def __init__(self, team: Team, shared: SharedContact) -> None:
        from scipy.sparse import csr_matrix

        self.rows = shared.receivers
        self.exchange = team.exchange(shared.receivers_shared)
        nodes, receivers = shared.pairs.T
        places = np.searchsorted(self.rows, receivers)
        size = len(self.rows), max(1, len(shared.nodes))
        self._parts = csr_matrix((1.0 / shared.receiver_counts[nodes], (places, nodes)), shape=size)

    def add(self, special_force: np.ndarray, rest: np.ndarray) -> None:
        """Add the shares of the forces [k, 3] [N] to `special_force` [s, 3]; without contact nodes [1, 3] zeros."""
        shares = np.asarray(self._parts @ rest)
        self.exchange.add(shares)
        special_force[self.rows] += shares

    def share_residual(self, force: InternalForce, contact: MasslessContactTerm) -> None:
        """Share out what the last solve has left unbalanced at the contact nodes of this rank."""
        assert contact.residual_shares is not None
        self.add(arrays.get(force.special_force).reshape(-1, 3), arrays.get(contact.residual_shares).reshape(-1, 3))
