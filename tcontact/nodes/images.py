"""The images of a periodic body: which boundary node follows which (kernels/nodes/images.py)."""

from __future__ import annotations

from ..device import arrays
from ..planning.domain import Domain
from ..scene.periodic import Images


class PeriodicImages:
    """The list of followers with their masters."""

    name = "periodic"

    def __init__(self, domain: Domain, images: Images) -> None:
        self.pairs = arrays.put(images.pairs(domain.boundary).astype("int32"))

    def owned(self) -> list[arrays.Array]:
        """Arrays of this term."""
        return [self.pairs]
