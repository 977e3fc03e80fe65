"""The one place that starts Taichi."""

from __future__ import annotations

import io
import os
import time
from contextlib import redirect_stdout
from pathlib import Path
from types import ModuleType

from .errors import InputError
from .tracing import quicken

STALE_LOCK = 60.0  # seconds; a lock is held for milliseconds

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
    quicken()
    wanted = threads or cores
    cache = kernel_cache()
    _drop_stale_lock(cache)
    with redirect_stdout(io.StringIO()):  # it announces itself
        ti.init(
            arch=ti.cuda if arch == "cuda" else ti.cpu,
            default_fp=ti.f64,
            default_ip=ti.i32,
            fast_math=False,
            offline_cache=True,
            offline_cache_file_path=str(cache),
            cpu_max_num_threads=wanted,
            log_level=ti.ERROR,
            verbose=False,
        )
    if arch == "cuda" and ti.cfg.arch != ti.cuda:
        raise InputError("arch", arch, "no usable CUDA device was found; use arch='cpu'")
    _started = (arch, wanted)
    return ti


def kernel_cache() -> Path:
    """Folder of compiled kernels: TI_OFFLINE_CACHE_FILE_PATH, or tcontact in the user's cache folder."""
    named = os.environ.get("TI_OFFLINE_CACHE_FILE_PATH")
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(named) if named else Path(home) / "tcontact" / "kernels"


def _drop_stale_lock(cache: Path) -> None:
    """Remove the lock a killed process left: with it nobody reads or writes the cache any more."""
    for lock in cache.glob("**/*.lock"):
        try:
            if time.time() - lock.stat().st_mtime > STALE_LOCK:
                lock.unlink()
        except OSError:
            pass  # it went away, or is not ours to remove: kernels are compiled anew then


def threads() -> int:
    """CPU threads in use; 0 before the start."""
    return _started[1] if _started else 0


def arch() -> str:
    """Backend in use, "cpu" or "cuda"; "cpu" before the start."""
    return _started[0] if _started else "cpu"
