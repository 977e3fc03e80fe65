"""Internal force of the cells on a GPU, with kick and drift of the nodes: a thread per cell, then a thread per node."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..device import arrays
from ..device.launch import Prepared
from ..kernels import lanes
from ..kernels.columns import NODE_SUMS, cell_groups, group_size
from ..planning.device_lists import corner_places, device_threads, parts_of
from ..planning.domain import Domain
from .internal_force import InternalForce

if TYPE_CHECKING:
    from ..kernels.language.bundles import Body


class DeviceForce(InternalForce):
    """The force pass of a domain on a GPU, all of whose nodes it moves as ordinary ones.

    With boundary nodes it serves products; their steps have another kernel (schemes/explicit/device_contact.py).

    Cells, constants and the state of points stand as in `InternalForce`; corner_forces: a place for every corner of
    every cell; threads: of each loop of the kernel (kernels/step/device_step.py).
    """

    def __init__(self, domain: Domain) -> None:
        from ..kernels.language.bundles import DeviceLists
        from ..kernels.language.signatures import arguments, signature_of
        from ..kernels.step.device_ledger import ledger_places, make_ledger

        super().__init__(domain, chunks=1)
        self.threads = device_threads(self.packs, len(domain.reference))
        self.numbers = NODE_SUMS + group_size(*cell_groups(False, self.plastic))
        _second, self._third, size = ledger_places(self.threads, self.numbers)
        self.parts = arrays.put(parts_of(self.packs, domain))
        self.node_corners = arrays.put(corner_places(self.packs, domain))
        self.corner_forces = arrays.zeros(3 * len(self.packs.connectivity))
        self.partial_sums = arrays.zeros(self.numbers * self.threads)
        self.ledger = arrays.zeros(size)
        self.lists = DeviceLists(self.parts, self.node_corners, self.corner_forces, self.partial_sums, self.ledger)
        self.step = self.kernel_for(domain.kinds, **domain.options)
        self.kernel = Prepared(self.step)
        self._ledger = Prepared(make_ledger(signature_of({"lists": self.lists}), self.plastic, self.threads))
        self._of_lists = arguments({"lists": self.lists})
        self._solved_step = 0.0

    def kernel_for(self, kinds: tuple[tuple[str, str], ...], **options: Any) -> Callable[..., None]:
        """Return the step kernel for kinds of cells (element, law) that stand in these arrays."""
        from ..kernels.language.signatures import signature_of
        from ..kernels.step.device_step import make_device_step

        signature = signature_of({"body": self.device_bundle(), "lists": self.lists})
        return make_device_step(kinds, signature, self.threads, **options)

    def force_rows(self) -> arrays.Array:
        """Return an array without room: the corners of all cells have rows of their own."""
        return arrays.zeros(1)

    def device_bundle(self) -> Body:
        """Return the arrays of the body that the kernel needs, by name."""
        unused = (
            "chunk_table",
            "segments",
            "corner_rows",
            "node_info",
            "rows",
            "special_force",
            "node_sums",
            "cell_sums",
        )
        return self.bundle()._replace(**dict.fromkeys(unused))

    def advance(
        self,
        u: arrays.Array,
        v: arrays.Array,
        kick_before: float,
        kick_after: float,
        drift: float,
        *,
        loaded: bool = True,
        before: float = 0.0,
        row: int = 0,
    ) -> None:
        """Launch a step as `InternalForce.advance`; row: the number of its row in the block, up to DEVICE_ROWS."""
        gravity = self.gravity if loaded else np.zeros(3)
        numbers = [float(number) for number in (before or self.resting, kick_before, kick_after, drift, *gravity)]
        commit = int(loaded and self.memory is not None)
        self.kernel(row, commit, *numbers, *self.device_arguments(u, v))

    def set_solved_step(self, step: float) -> None:
        """Set the step [s] at whose end the static solve finds the forces of metals that need it."""
        if self.timed and step != self._solved_step:
            self._solved_step = step
            arrays.set_values(self.parameters, np.array([step]), lanes.STEP)

    def device_arguments(self, u: arrays.Array, v: arrays.Array) -> tuple[arrays.Array, ...]:
        """Return the arrays of the kernel."""
        body = (u, v, self.connectivity, self.reference, self.mass, self.parameters)
        return (*body, *(() if self.memory is None else (self.memory,)), *self._of_lists)

    def ledger_rows(self, rows: int) -> np.ndarray:
        """Complete the sums of the rows of a block and return them [rows, numbers], nodes then cells."""
        self._ledger(rows, *self._of_lists)
        count = rows * self.numbers
        return arrays.part(self.ledger, self._third, count).reshape(rows, self.numbers)

    def sums(self) -> np.ndarray:
        """Return the sums of the last step, which was row 0 of a block."""
        return self.ledger_rows(1)[0]

    def measure_surface(self, u: arrays.Array, v: arrays.Array) -> None:
        """Refuse: no cells are contact cells here."""
        raise NotImplementedError("contact cells are not stepped by this pass")

    def owned(self) -> list[arrays.Array]:
        """Return the arrays of this term."""
        return [*super().owned(), self.parts, self.node_corners, self.corner_forces, self.partial_sums, self.ledger]
