"""Start Taichi, once per process."""

from __future__ import annotations

import gc
import io
import mmap
import os
import shutil
import tempfile
import threading
import time
import warnings
import weakref
from contextlib import redirect_stdout
from pathlib import Path
from types import ModuleType
from typing import Any

from ..base.errors import InputError
from ..base.validate import whole, working_directory
from . import workers
from .cuda import NoDevice, count_devices
from .kernel_list import strike_lost
from .ranks import cores_of_a_rank
from .tracing import quick_import, quicken

STALE_LOCK = 60.0  # seconds; a lock is held for milliseconds
CACHE_ROOM = 2**26  # bytes that must be free for compiled kernels; one of them takes up to 2 MB
KEPT = 2**30  # bytes of compiled kernels, above which Taichi removes a quarter; all cases have some 100 MB
MOST = 1024  # threads; many thousands take every process that the system can have
ADDRESS_ROOM = 3 * 2**29  # bytes of address space: Taichi reserves 1 GiB, its threads and the compiler take the rest

turn = threading.RLock()  # held by the thread that computes: Taichi serves one at a time
_started: tuple[str, int] | None = None
_begun: weakref.ref[Any] | None = None  # the state of Taichi since its start here; each `ti.init` makes a new one
_copied = False  # from a process in which Taichi had been started
APART = "start a new process, and keep tcontact apart from what calls ti.init or ti.reset, each in one of its own"


def load() -> ModuleType:
    """Import Taichi and return the module; the error for a missing system library names it.

    Raises `ImportError` with the package to install when libX11 is absent (Taichi links it even without a screen).
    """
    try:
        with quick_import(), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Taichi's own, which a program that makes errors of warnings would die of
            from ..kernels.engine import ti
    except ImportError as error:
        if "libX11" in str(error):
            raise ImportError(
                "Taichi needs the system library libX11.so.6; install it: apt-get install libx11-6"
            ) from error
        if engine := os.environ.get("TCONTACT_ENGINE"):
            raise ImportError(f"TCONTACT_ENGINE={engine}: {error}; install it, or unset this variable") from error
        raise
    return ti


def start(arch: str = "cpu", threads: int | None = None) -> ModuleType:
    """Start Taichi once per process and return the module.

    arch: "cpu" or "cuda"; threads: CPU threads, None = all cores, those of a rank its share of them. float64, no fast
    math; compiled kernels are kept in `kernel_cache()` where files can be written there. A second call with the same
    options is free; other options raise `InputError`: Taichi cannot be restarted safely. Raises `MemoryError` where the
    process may not take enough memory, `InputError` in a copy (fork) of a process in which Taichi had been started,
    where the program has started it itself, before (`_check_unused`) or since, and without a working directory.
    """
    global _started, _begun
    if arch not in ("cpu", "cuda"):
        raise InputError("arch", arch, "use 'cpu' or 'cuda'")
    if threads is not None:
        try:
            threads = whole("threads", threads, 1, high=MOST)
        except InputError as error:
            remedy = f"give a whole number from 1 to {MOST}, or leave it out for all cores"
            raise InputError("threads", threads, remedy) from error
    if _copied:
        remedy = "it has no threads; start workers before the first run, or by multiprocessing.get_context('spawn')"
        raise InputError("process", "a copy (fork) of one that has computed", remedy)
    if _started is not None:
        if _started[0] != arch or (threads is not None and threads != _started[1]):
            raise InputError(
                "arch, threads",
                (arch, threads),
                f"this process already runs on {_started[0]} with {_started[1]} threads; start a new process",
            )
        ti = load()
        if not _runs_on():
            raise InputError("process", "Taichi was started anew in it after tcontact", APART)
        return ti
    working_directory()  # Taichi asks for it
    if arch == "cuda":
        _check_device(arch)
    ti = load()
    _check_unused(ti)
    quicken()
    wanted = threads or cores_of_a_rank()
    cache = kernel_cache()
    _check_address_space()
    cached = takes_files(cache)
    if cached:
        _drop_stale_lock(cache)
        strike_lost(cache)
    try:
        with redirect_stdout(io.StringIO()):  # Taichi prints a banner
            ti.init(
                arch=ti.cuda if arch == "cuda" else ti.cpu,
                default_fp=ti.f64,
                default_ip=ti.i32,
                fast_math=False,
                offline_cache=cached,
                **_room(),
                # Taichi crashes at the end if this folder does not exist, even if it stores nothing there
                offline_cache_file_path=str(cache if cached else Path(__file__).parent),
                cpu_max_num_threads=wanted,
                log_level=ti.ERROR,
            )
    except RuntimeError as error:
        raise MemoryError(f"Taichi cannot be started: {error}") from error
    if arch == "cuda" and ti.cfg.arch != ti.cuda:
        raise InputError("arch", arch, "Taichi cannot use the device (it loads libcuda.so); use arch='cpu'")
    _started, _begun = (arch, wanted), weakref.ref(ti.lang.impl.get_runtime())
    workers.prepare(keep_kernels)
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=_be_copied)
    return ti


def _be_copied() -> None:
    """Note in the copy (fork) of a process in which Taichi had been started that it cannot compute."""
    global _started, _copied, turn
    _started, _copied, turn = None, True, threading.RLock()  # another thread may have held it


def _room() -> dict[str, int]:
    """Return how many bytes of compiled kernels are kept, unless the user's environment says so."""
    return {} if os.environ.get("TI_OFFLINE_CACHE_MAX_SIZE_OF_FILES") else {"offline_cache_max_size_of_files": KEPT}


def keep_kernels() -> None:
    """Store the kernels that this process has compiled in `kernel_cache()`; no kernel may be called afterwards."""
    if _started is not None and _runs_on():
        program = load().lang.impl.get_runtime().prog
        if program is not None:
            program.finalize()


def _runs_on() -> bool:
    """Return whether Taichi is in the state that `start` has left, without a `ti.init` or `ti.reset` since."""
    return _begun is not None and load().lang.impl.get_runtime() is _begun()


def _check_unused(ti: ModuleType) -> None:
    """Refuse a start where the program has fields, arrays or kernels of its own in Taichi, which it would destroy.

    Where the program has called `ti.init` and nothing else, its options are replaced. Raises `InputError`.
    """
    state = ti.lang.impl.get_runtime()
    if vars(state).get("prog", vars(state).get("_prog")) is None:  # the second name is that of a fork
        return
    data = (ti.Field, ti.Ndarray)
    if state.materialized or any(issubclass(type(one), data) for one in gc.get_objects()):
        raise InputError("process", "Taichi is in use in it by this program, whose fields a run would destroy", APART)


def kernel_cache() -> Path:
    """Return the folder of compiled kernels: TI_OFFLINE_CACHE_FILE_PATH, or tcontact in the user's cache folder."""
    named = os.environ.get("TI_OFFLINE_CACHE_FILE_PATH")
    return Path(named) if named else user_cache() / "kernels"


def user_cache() -> Path:
    """Return the folder tcontact in the user's cache folder (XDG_CACHE_HOME); it may be impossible to make."""
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.join(_home(), ".cache")) / "tcontact"


def _home() -> str:
    """Return the home folder; for a user without one the null device, which holds no files."""
    home = os.environ["HOME"] if "HOME" in os.environ else os.path.expanduser("~")
    return home if os.path.isabs(home) else os.devnull


def takes_files(folder: Path) -> bool:
    """Make a folder and return whether it can hold compiled kernels: where it cannot, Taichi crashes at the end."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(b"0")
        return min(shutil.disk_usage(folder).free, _limit("RLIMIT_FSIZE")) >= CACHE_ROOM
    except (OSError, ValueError):
        return False


def _check_device(arch: str) -> None:
    """Refuse a GPU that is not there before Taichi starts, which would start on the CPU. Raises `InputError`."""
    try:
        count_devices()
    except NoDevice as error:
        raise InputError("arch", arch, f"no usable CUDA device was found: {error}; use arch='cpu'") from error


def _check_address_space() -> None:
    """Raise `MemoryError` where a limit leaves too little memory for Taichi, whose compiler would abort the process."""
    limit = _limit("RLIMIT_AS")
    if limit == float("inf"):
        return
    try:
        mmap.mmap(-1, ADDRESS_ROOM).close()
    except OSError as error:
        text = f"Taichi needs {ADDRESS_ROOM / 2**30:g} GiB of address space beside what is in use"
        raise MemoryError(f"{text}; this process is limited to {limit / 2**30:.3g} GiB: raise `ulimit -v`") from error


def _limit(name: str) -> float:
    """Return a limit of the process in bytes by its name in `resource`; inf without one."""
    try:
        import resource
    except ImportError:  # not a POSIX system
        return float("inf")
    soft, _ = resource.getrlimit(getattr(resource, name))
    return float("inf") if soft == resource.RLIM_INFINITY else float(soft)


def _drop_stale_lock(cache: Path) -> None:
    """Remove the lock of a killed process, which would block reading and writing of the cache."""
    for lock in cache.glob("**/*.lock"):
        try:
            if time.time() - lock.stat().st_mtime > STALE_LOCK:
                lock.unlink()
        except OSError:
            pass  # it is gone, or may not be removed: kernels are then compiled anew


def threads() -> int:
    """Return the number of CPU threads in use; 0 before the start."""
    return _started[1] if _started else 0


def arch() -> str:
    """Return the backend in use, "cpu" or "cuda"; "cpu" before the start."""
    return _started[0] if _started else "cpu"
