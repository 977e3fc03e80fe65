"""The images of periodic bodies: pairs of boundary nodes that move together (kernels/nodes/images.py)."""

from __future__ import annotations

from ..device import arrays
from ..planning.domain import Domain
from ..scene.periodic import Images


class PeriodicImages:
    """Pairs of a follower and its master."""

    name = "periodic"

    def __init__(self, domain: Domain, images: Images) -> None:
        self.pairs = arrays.put(images.pairs(domain.boundary).astype("int32"))

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return [self.pairs]
