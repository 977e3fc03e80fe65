"""Worker processes: those that `multiprocessing` starts, and copies that a program makes of itself (fork).

Taichi stores the kernels that it has compiled where its program is taken apart. Workers end without that: copies leave
by `os._exit`, and a pool ends its workers by SIGTERM when it has their answers. Here they store the kernels first.
A pool waits for its workers after that signal, and they can get no further task: a worker that goes on after a run that
the signal has stopped would wait for one, and its pool for it, for ever.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any

POOLS = ("multiprocessing.pool", "concurrent.futures.process")  # modules whose workers end by SIGTERM

_keep: Callable[[], None] | None = None


def prepare(keep: Callable[[], None]) -> None:
    """Let a worker call `keep` where it ends; in any other process nothing happens."""
    global _keep
    if not is_worker():
        return
    from multiprocessing import util

    _keep = keep
    util.Finalize(None, keep, exitpriority=-1000)  # behind what others do at the end
    main = threading.current_thread() is threading.main_thread()
    if in_pool() and main and signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, end)


def is_worker() -> bool:
    """Return whether `multiprocessing` has started this process."""
    process: Any = sys.modules.get("multiprocessing.process")
    return process is not None and process.parent_process() is not None


def in_pool() -> bool:
    """Return whether this process is a worker of a pool or of a `ProcessPoolExecutor`."""
    if not is_worker():
        return False
    current: Any = sys.modules["multiprocessing.process"]
    task = getattr(current.current_process(), "_target", None)
    return getattr(task, "__module__", None) in POOLS


def end(_number: int = signal.SIGTERM, _frame: Any = None) -> None:
    """End this worker as SIGTERM does, once it has stored its kernels."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if _keep is not None:
        _keep()
    os.kill(os.getpid(), signal.SIGTERM)
