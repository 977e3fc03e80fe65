"""What the CUDA driver says of the device, asked without Taichi: nothing is started that stays.

Where a launcher has started several processes on a machine, they take its devices in turn.
"""

from __future__ import annotations

import ctypes
import os
from dataclasses import dataclass
from typing import Any

from .ranks import number_on_machine

LIBRARIES = ("libcuda.so", "libcuda.so.1")  # in the order in which Taichi looks for the driver
NAME = 100  # characters of the name of a device
VISIBLE = "CUDA_VISIBLE_DEVICES"  # environment: the devices that the driver shows, when it starts


@dataclass(frozen=True)
class Device:
    """The first CUDA device: its name, how many there are, its memory and what is free of it [bytes]."""

    name: str
    count: int
    total: int
    free: int


class NoDevice(Exception):
    """There is no usable CUDA device; the text says why."""


def find_device() -> Device:
    """Ask the driver for the first device, which is the one that Taichi takes. Raises `NoDevice`.

    The free memory is that of a context, which is made for the question and given back.
    """
    count, driver = count_devices(), _driver()
    device, name = ctypes.c_int(0), ctypes.create_string_buffer(NAME)
    if driver.cuDeviceGet(ctypes.byref(device), 0) or driver.cuDeviceGetName(name, NAME, device):
        raise NoDevice("the driver does not open the device")
    free, total = _memory(driver, device)
    return Device(name.value.decode(errors="replace"), count, total, free)


def count_devices() -> int:
    """Return the number of devices, at least 1: of several ranks on a machine each sees one. Raises `NoDevice`."""
    take_turn()
    driver = _driver()
    if code := driver.cuInit(0):
        raise NoDevice(f"the driver does not start (error {code}{_named(driver, code)})")
    count = ctypes.c_int(0)
    if driver.cuDeviceGetCount(ctypes.byref(count)) or count.value == 0:
        raise NoDevice("the driver finds no device (CUDA_VISIBLE_DEVICES may hide it)")
    return count.value


def take_turn() -> None:
    """Let a rank see one device of its machine: that of its turn, before the driver starts, which looks then."""
    number = number_on_machine()
    if number is None:
        return
    named = os.environ.get(VISIBLE)
    names = [str(one) for one in range(_installed())] if named is None else named.split(",")
    if len(names) > 1:
        os.environ[VISIBLE] = names[number % len(names)]


def _installed() -> int:
    """Return the number of devices of the machine, which a library tells without the driver; 0 where it is missing."""
    try:
        library = ctypes.CDLL("libnvidia-ml.so.1")
        count = ctypes.c_uint(0)
        failed = library.nvmlInit_v2() or library.nvmlDeviceGetCount_v2(ctypes.byref(count))
    except (OSError, AttributeError):
        return 0
    return 0 if failed else count.value


def _driver() -> Any:
    for name in LIBRARIES:
        try:
            return ctypes.CDLL(name)
        except OSError:
            continue
    raise NoDevice(f"no driver ({LIBRARIES[0]} is not there)")


def _memory(driver: Any, device: ctypes.c_int) -> tuple[int, int]:
    """Return the free and the whole memory of a device [bytes]. Raises `NoDevice`."""
    before, context = ctypes.c_void_p(), ctypes.c_void_p()
    driver.cuCtxGetCurrent(ctypes.byref(before))
    if code := driver.cuDevicePrimaryCtxRetain(ctypes.byref(context), device):
        raise NoDevice(f"the device cannot be used (error {code}{_named(driver, code)})")
    free, total = ctypes.c_size_t(), ctypes.c_size_t()
    driver.cuCtxSetCurrent(context)
    failed = driver.cuMemGetInfo_v2(ctypes.byref(free), ctypes.byref(total))
    driver.cuCtxSetCurrent(before)
    release = getattr(driver, "cuDevicePrimaryCtxRelease_v2", None)
    if release is not None:
        release(device)
    if failed:
        raise NoDevice(f"the device does not tell its memory (error {failed}{_named(driver, failed)})")
    return int(free.value), int(total.value)


def _named(driver: Any, code: int) -> str:
    text = ctypes.c_char_p()
    if driver.cuGetErrorName(code, ctypes.byref(text)) or text.value is None:
        return ""
    return f", {text.value.decode(errors='replace')}"
