"""Sweeps of the static solve that a GPU makes by several blocks of threads, launched one by one."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...device.launch import Prepared
from ...kernels.lanes import SWEEPS_AT_ONCE
from . import device_offers

OF_AN_END = 4  # kernels that the end of a pass starts
FIRST_OFFER = 2, 1  # launches of sweeps that the first pass of a step and the others offer in the first block of rows


class DeviceSweeps:
    """The sweeps of a pass of the static solve, and its end (kernels/step/device_sweeps.py).

    parts: bundles DeviceLists, Contact, System; body: that of the contact cells; offered: launches of SWEEPS_AT_ONCE
    sweeps in the first pass of a step, in the second one, and so on, by what the last block of rows needed. A solve
    that needs more goes on with those of the next pass.
    """

    def __init__(self, parts: tuple[Any, Any, Any], body: Any, options: Any, blocks: int, colours: int) -> None:
        from ...kernels.language.signatures import arguments, signature_of
        from ...kernels.step.device_sweeps import make_device_end, make_device_sweep

        lists, contact, system = parts
        sweep = {"lists": lists, "contact": contact, "system": system}
        end = {"body": type(body)(u=body.u), **sweep}
        self.offered = [FIRST_OFFER[0], *(FIRST_OFFER[1],) * 3]
        self._sweep = Prepared(make_device_sweep(signature_of(sweep), options, blocks, colours))
        self._end = Prepared(make_device_end(signature_of(end), options, blocks, colours))
        self._arrays = arguments(sweep), arguments(end)
        kernels = SWEEPS_AT_ONCE * (1 + colours), OF_AN_END
        self._cost = [float(len(given) + count) for given, count in zip(self._arrays, kernels, strict=True)]

    @property
    def costs(self) -> list[float]:
        """Costs of the launches of the first pass of a step, of the second one, and so on (device_offers.py)."""
        sweep, end = self._cost
        return [end + offered * sweep for offered in self.offered]

    def needed(self, steps: np.ndarray, passes: np.ndarray, rest: float) -> None:
        """Offer what costs least from now on.

        steps: sweeps of every step of this block; passes: the most of their first pass, of the second one, and so on;
        rest: cost of all other launches of a step.
        """
        sweep, end = self._cost
        first = device_offers.launches(steps, SWEEPS_AT_ONCE, rest + end, sweep)
        self.offered = [first, *(-(-int(most) // SWEEPS_AT_ONCE) for most in passes[1:])]

    def offer(self, number: int, times: int = 1) -> None:
        """Offer the sweeps of pass `number`, `times` as many as usual, and its end."""
        for _ in range(times * self.offered[min(number, len(self.offered) - 1)]):
            self._sweep(*self._arrays[0])
        self._end(*self._arrays[1])
