"""The one place that starts Taichi."""

from __future__ import annotations

import io
import os
from contextlib import redirect_stdout
from types import ModuleType

from .errors import InputError

_started: tuple[str, int] | None = None


def load() -> ModuleType:
    """Import Taichi and return the module; a missing system library is named.

    Raises `ImportError` with the package to install when libX11 is absent (Taichi links it even without a screen).
    """
    os.environ.setdefault("TI_LOG_LEVEL", "error")
    os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")
    try:
        import taichi
    except ImportError as error:
        if "libX11" in str(error):
            raise ImportError(
                "Taichi needs the system library libX11.so.6; install it: apt-get install libx11-6"
            ) from error
        raise
    return taichi


def start(arch: str = "cpu", threads: int | None = None) -> ModuleType:
    """Start Taichi once per process and return the module.

    arch: "cpu" or "cuda"; threads: CPU threads, None = all cores. float64, no fast math, offline kernel cache on.
    A second call with the same wishes is free; other wishes raise `InputError`: Taichi cannot be restarted safely.
    """
    global _started
    if arch not in ("cpu", "cuda"):
        raise InputError("arch", arch, "use 'cpu' or 'cuda'")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise InputError("threads", threads, "give a positive whole number, or None for all cores")
    if _started is not None:
        if _started[0] != arch or (threads is not None and threads != _started[1]):
            raise InputError(
                "arch, threads",
                (arch, threads),
                f"this process already runs on {_started[0]} with {_started[1]} threads; start a new process",
            )
        return load()
    ti = load()
    wanted = threads or cores
    with redirect_stdout(io.StringIO()):  # it announces itself
        ti.init(
            arch=ti.cuda if arch == "cuda" else ti.cpu,
            default_fp=ti.f64,
            default_ip=ti.i32,
            fast_math=False,
            offline_cache=True,
            cpu_max_num_threads=wanted,
            log_level=ti.ERROR,
            verbose=False,
        )
    if arch == "cuda" and ti.cfg.arch != ti.cuda:
        raise InputError("arch", arch, "no usable CUDA device was found; use arch='cpu'")
    _started = (arch, wanted)
    return ti


def threads() -> int:
    """CPU threads in use; 0 before the start."""
    return _started[1] if _started else 0


def arch() -> str:
    """Backend in use, "cpu" or "cuda"; "cpu" before the start."""
    return _started[0] if _started else "cpu"
