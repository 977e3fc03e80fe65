"""Make a folder and lock it for one run at a time, by a file that the process locks; the lock ends with its process."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..base.errors import InputError
from ..base.validate import working_directory
from ..device.atomic_file import refuse_lost_link

try:
    import fcntl
except ImportError:  # Windows: folders are not locked there
    fcntl = None  # type: ignore[assignment]

NAME = ".running"
ASIDE = ".replaced"  # folder in that of a run: the files of an older run until the new one has succeeded
PUT_ASIDE = f"a run that was to replace it was killed at its start; move the files in {ASIDE} back"
_held: dict[Path, int] = {}  # and the file that is locked


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock an existing folder; within a process the block may be entered again.

    Raises `InputError` if another process runs there, or if the folder cannot be written.
    """
    path = folder.resolve() / NAME
    if fcntl is None or path in _held:
        yield
        return
    file = _acquire(path, folder)
    _held[path] = file
    try:
        yield
    finally:
        _held.pop(path, None)
        with suppress(OSError):
            path.unlink()
        os.close(file)


def make_folder(folder: Path) -> None:
    """Make a folder where it is not there. Raises `InputError` if it cannot be made."""
    refuse_lost_link(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        working_directory()
        raise InputError("out", str(folder), f"cannot be made ({error.strerror}); name another folder") from error


@contextmanager
def made_folder(folder: Path) -> Iterator[None]:
    """Make the output folder; a run that is refused or stopped at its start leaves no new folder that is empty.

    Raises `InputError` if it cannot be made.
    """
    new = [place for place in (folder, *folder.parents) if not place.exists()]
    make_folder(folder)
    try:
        yield
    except BaseException:
        with suppress(OSError):  # it holds something
            for place in new:
                place.rmdir()
        raise


@contextmanager
def made_and_locked(folder: Path) -> Iterator[None]:
    """Make the output folder where it is not there, and keep every other run out of it in the block.

    Raises `InputError` if it cannot be made, or if another process runs there.
    """
    with made_folder(folder), locked(folder):
        yield


def held(folder: Path) -> list[int]:
    """Return the file whose lock this process holds for a folder: whoever inherits it keeps the folder locked."""
    path = folder.resolve() / NAME
    return [_held[path]] if path in _held else []


def check_free(folder: Path) -> None:
    """Raise `InputError` if another process runs in the folder; changes nothing."""
    path = folder.resolve() / NAME
    if fcntl is not None and path not in _held and os.path.lexists(path):
        with suppress(OSError):
            os.close(_acquire(path, folder))


def _acquire(path: Path, folder: Path) -> int:
    while True:
        if os.path.lexists(path) and not stat.S_ISREG(os.lstat(path).st_mode):
            remedy = f"its {NAME} is no ordinary file, as a run makes it; remove that, or name another folder"
            raise InputError("out", str(folder), remedy)
        try:
            file = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o644)
        except OSError as error:
            raise InputError(
                "out", str(folder), f"cannot be written ({error.strerror}); name another folder"
            ) from error
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            owner = os.pread(file, 32, 0).decode(errors="replace").strip() or "unknown"
            os.close(file)
            raise InputError(
                "out", str(folder), f"process {owner} is writing a run there; wait for it or name another folder"
            ) from error
        if os.fstat(file).st_nlink:  # otherwise its owner has just removed it
            with suppress(OSError):
                os.ftruncate(file, 0)
                os.pwrite(file, f"{os.getpid()}\n".encode(), 0)
            return file
        os.close(file)
