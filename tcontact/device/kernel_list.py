"""Taichi's list of the kernels that it has stored: those whose files are lost are struck out.

Taichi compiles a kernel of its list whose file is missing or damaged, and does not store it again: every run would be a
cold one, for example where a folder for temporary files was cleaned, or after a power failure. The list,
`ticache.tcb`, is its length [bytes], Taichi's version (three numbers of 16 bits), the bytes of all files, the number of
kernels, and for every kernel its key twice (each with its length), the bytes of its file, and when it was made and last
used. Other numbers have 64 bits. A list of any other form is left as it is.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

LIST, LOCK = "ticache.tcb", "ticache.lock"
HEAD = struct.Struct("<Q3HQQ")
KERNEL = struct.Struct("<Q65sQ65sQQQ")


def strike_lost(folder: Path) -> None:
    """Strike out of the list in a folder the kernels whose file there is missing, or has another length."""
    with suppress(OSError, struct.error, ValueError):
        if _without_lost(folder) is None:
            return
        with _locked(folder):
            left = _without_lost(folder)  # another process may have added kernels meanwhile
            if left is not None:
                beside = folder / f"{LIST}.{os.getpid()}"
                beside.write_bytes(left)
                beside.replace(folder / LIST)


def _without_lost(folder: Path) -> bytes | None:
    """Return the list in a folder without the kernels that are lost; None if none is, or its form is another one."""
    data = (folder / LIST).read_bytes()
    length, *version, _, count = HEAD.unpack_from(data)
    if length != len(data) or length != HEAD.size + count * KERNEL.size:
        return None
    kernels = list(KERNEL.iter_unpack(data[HEAD.size :]))
    left = [kernel for kernel in kernels if _is_there(folder, kernel)]
    if len(left) == len(kernels):
        return None
    total = sum(kernel[4] for kernel in left)
    head = HEAD.pack(HEAD.size + len(left) * KERNEL.size, *version, total, len(left))
    return head + b"".join(KERNEL.pack(*kernel) for kernel in left)


def _is_there(folder: Path, kernel: tuple) -> bool:
    """Return whether the file of a kernel of the list is whole by its length."""
    file = folder / f"{kernel[1].decode('ascii')}.tic"
    if not file.exists():
        return False
    return not file.is_file() or file.stat().st_size == kernel[4]  # Taichi aborts where it cannot store a file


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the lock of Taichi on the list. Raises `OSError` where another process does."""
    os.close(os.open(folder / LOCK, os.O_CREAT | os.O_EXCL))
    try:
        yield
    finally:
        (folder / LOCK).unlink()
