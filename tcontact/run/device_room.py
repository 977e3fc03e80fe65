"""Checks that a run can be made on a GPU: the scheme has kernels for it, the device is there and has the memory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..base.errors import InputError
from ..device import cuda, runtime
from ..planning.device_memory import PLACES
from ..planning.planning import Plan
from ..schemes.explicit.device_memory import plan_bytes, plan_places

RESERVE = 2**30  # bytes for Taichi, the machine code and the memory of threads whose registers do not suffice


def check_scheme(scheme: Any, arch: str) -> None:
    """Refuse an implicit scheme on a GPU. Raises `InputError`."""
    if arch == "cuda" and scheme.implicit:
        remedy = f"{scheme.name} solves its equations on the CPU; use arch='cpu' or scheme='central-difference'"
        raise InputError("arch", arch, remedy)


def check_same(head: Mapping[str, Any], arch: str) -> None:
    """Refuse to go on elsewhere than the run that wrote a checkpoint; head: its plain data. Raises `InputError`."""
    kept = head.get("arch", arch)
    if arch != kept:
        raise InputError("arch", arch, f"the run computes on {kept!r}; resume it with arch={kept!r}, or run again")


def check_device(planned: Plan, arch: str, together: Callable[[int], int] = int) -> None:
    """Refuse arch="cuda" without a device, and a plan that is too large for its memory. Raises `InputError`.

    In a process that runs on the device already, memory counts as free which Taichi holds for later arrays.
    together: gives the bytes that all processes need which share the device, from those of this one.
    """
    if arch != "cuda":
        return
    try:
        device = cuda.find_device()
    except cuda.NoDevice as error:
        raise InputError("arch", arch, f"no usable CUDA device was found: {error}; use arch='cpu'") from error
    places = plan_places(planned)
    if places > PLACES:
        remedy = f"arrays have at most {PLACES} numbers there and the largest one would have {places}; coarsen the mesh"
        raise InputError("arch", arch, f"{remedy} or use arch='cpu'")
    there = device.total if runtime.arch() == "cuda" else device.free
    needed = together(plan_bytes(planned) + RESERVE)
    if needed > there:
        cells = sum(block.count for domain in planned.domains for block in domain.blocks)
        share = int(cells * max(there - RESERVE, 0) / (needed - RESERVE))
        text = f"the run needs {needed} bytes ({readable(needed)}) of the device's memory, {device.name} has {there}"
        text += f" ({readable(there)}) free of {readable(device.total)}; coarsen the mesh from {cells} to about {share}"
        raise InputError("arch", arch, f"{text} cells, end what else runs there, or use arch='cpu'")


def readable(size: int) -> str:
    """Return bytes as text."""
    return f"{size / 2**30:.4g} GiB" if size >= 2**30 else f"{size / 2**20:.4g} MiB"
