"""Sweeps of the static solve that a GPU makes by several blocks of threads, launched one by one."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...device.launch import Prepared

FIRST_OFFER = 8, 4  # sweeps that the first pass of a step and the others offer in the first block of rows


class DeviceSweeps:
    """The sweeps of a pass of the static solve, and its end (kernels/step/device_sweeps.py).

    parts: bundles DeviceLists, Contact, System; body, rows: bundles of the contact cells; offered: sweeps of the first
    pass of a step, of the second one, and so on, as many as they needed in the last block of rows. A solve that needs
    more goes on with those of the next pass.
    """

    def __init__(
        self, parts: tuple[Any, Any, Any], body: Any, rows: Any, options: Any, blocks: int, colours: int
    ) -> None:
        from ...kernels.language.signatures import arguments, signature_of
        from ...kernels.step.device_sweeps import make_device_end, make_device_sweep

        lists, contact, system = parts
        sweep = {"lists": lists, "rows": rows, "contact": contact, "system": system}
        end = {"body": type(body)(u=body.u), "lists": lists, "contact": contact, "system": system}
        self.offered = [FIRST_OFFER[0], *(FIRST_OFFER[1],) * 3]
        self._sweep = Prepared(make_device_sweep(signature_of(sweep), options, blocks, colours))
        self._end = Prepared(make_device_end(signature_of(end), options, blocks, colours))
        self._arrays = arguments(sweep), arguments(end)

    def needed(self, sweeps: np.ndarray) -> None:
        """Offer so many sweeps from now on, at least one in the first pass."""
        self.offered = [max(int(sweeps[0]), 1), *map(int, sweeps[1:])]

    def offer(self, number: int, times: int = 1) -> None:
        """Offer the sweeps of pass `number`, `times` as many as usual, and its end."""
        for _ in range(times * self.offered[min(number, len(self.offered) - 1)]):
            self._sweep(*self._arrays[0])
        self._end(*self._arrays[1])
