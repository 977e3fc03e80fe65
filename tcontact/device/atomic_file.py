"""Files with atomic commits: after a kill, a full disk or a crash they hold all of the last commit or none of it.

Data beyond the old end of an `AtomicFile` is written at once: nothing refers to it yet. Data changed in place stays in
memory until `commit` has written an undo file with the old content and the device has stored it; then it goes to disk,
and when the device has stored that too the undo file is emptied. An undo file that is not empty means that a commit was
interrupted; its content is then restored (rollback journal as in SQLite, https://www.sqlite.org/atomiccommit.html).

Writing follows no symbolic link: a link in place of a new file is replaced, one in place of an existing file is
refused. A device, pipe or socket in place of a file is refused and stays, also where a link leads to it.
"""

from __future__ import annotations

import errno
import os
import stat
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..base.errors import InputError

DEVICES = Path("/dev")
PAGE = 4096
MAGIC = b"tcontact undo 1\n"
HEAD = struct.Struct("<QQ")  # size of the file before the commit [bytes]; number of pages that follow
ENTRY = struct.Struct("<QI")  # number of a page, its bytes
CHECK = struct.Struct("<I")


class AtomicFile:
    """A binary file for h5py that changes on disk only by `commit`.

    path: the file; mode: "w" new, "r+" existing, "r" to read, without an interrupted commit. If the disk fails, the
    next commit raises `OSError` and leaves the file as it was; from then on nothing is written.
    """

    def __init__(self, path: Path | str, mode: str) -> None:
        self.path = Path(path).absolute()
        if mode == "r+":
            roll_back(self.path)
        if mode == "r":
            self._file = os.open(self.path, os.O_RDONLY)
        else:
            self._file = _new(self.path) if mode == "w" else _known(self.path)
        self.failed: OSError | None = None
        self._pages: dict[int, bytearray] = {}  # changed pages within the committed size
        self._stages: list[dict[int, bytes]] = []  # earlier states of them, in the order of writing
        self._at = 0
        self._undo = -1  # undo file, if one is open
        if mode == "w":
            undo_path(self.path).unlink(missing_ok=True)
        self._end = os.fstat(self._file).st_size  # committed size [bytes]
        undo = read_undo(self.path) if mode == "r" else None
        if undo is not None:
            self._end, pages = undo
            self._pages = {number: bytearray(old) for number, old in pages.items()}
        self._size = self._end

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the position and return it."""
        start = (0, self._at, self._size)[whence]
        self._at = start + offset
        return self._at

    def tell(self) -> int:
        """Return the position."""
        return self._at

    def read(self, size: int = -1) -> bytes:
        """Read bytes from the present position."""
        left = max(0, self._size - self._at)
        buffer = bytearray(left if size < 0 else min(size, left))
        self.readinto(buffer)
        return bytes(buffer)

    def readinto(self, buffer: Any) -> int:
        """Fill the buffer from the present position; return the number of bytes read."""
        view = memoryview(buffer).cast("B")
        done = 0
        while done < len(view) and self._at < self._end:
            number, inside = divmod(self._at, PAGE)
            page = self._pages.get(number)
            if page is None:
                span = min(len(view) - done, self._clean(number) - self._at)
                data: Any = os.pread(self._file, span, self._at)
            else:
                data = memoryview(page)[inside : inside + len(view) - done]
            if not len(data):
                break
            view[done : done + len(data)] = data
            done, self._at = done + len(data), self._at + len(data)
        span = min(len(view) - done, self._size - self._at)
        if span > 0:
            data = os.pread(self._file, span, self._at)
            view[done : done + span] = data + bytes(span - len(data))
            done, self._at = done + span, self._at + span
        return done

    def _clean(self, number: int) -> int:
        """Return the place of the next changed page, or the end."""
        if not self._pages:
            return self._end
        return min((page * PAGE for page in self._pages if page > number), default=self._end)

    def write(self, data: Any) -> int:
        """Write bytes at the present position."""
        view = memoryview(data).cast("B")
        done = 0
        while done < len(view) and self._at < self._end:
            number, inside = divmod(self._at, PAGE)
            page = self._pages.get(number)
            if page is None:
                page = self._pages[number] = bytearray(self._old(number))
            part = view[done : done + len(page) - inside]
            page[inside : inside + len(part)] = part
            done, self._at = done + len(part), self._at + len(part)
        if done < len(view):
            try:
                if self.failed is None:
                    _write_at(self._file, view[done:], self._at)
            except OSError as error:
                self._restore(error)
            self._at += len(view) - done
            self._size = max(self._size, self._at)
        return len(view)

    def _old(self, number: int) -> bytes:
        """Return a page as it is on disk."""
        first = number * PAGE
        return os.pread(self._file, min(PAGE, self._end - first), first)

    def truncate(self, size: int) -> int:
        """Set the size; committed data stays allocated."""
        self._size = max(size, self._end)
        try:
            if self.failed is None and os.fstat(self._file).st_size != self._size:
                os.ftruncate(self._file, self._size)
        except OSError as error:
            self._restore(error)
        return size

    def flush(self) -> None:
        """Do nothing: only `commit` writes to disk."""

    def stage(self) -> None:
        """Order the next commit: data written so far goes to disk before data written from now on."""
        self._stages.append({number: bytes(page) for number, page in self._pages.items()})

    def commit(self) -> None:
        """Write all changes to the file, or none of them. Raises `OSError`."""
        if self.failed is not None:
            raise self.failed
        try:
            self._check_there()
            if self._pages:
                old = {number: self._old(number) for number in sorted(self._pages)}
                self._keep(_undo_bytes(self._end, old))
                for stage in self._stages:
                    self._bring(stage, old)
                self._bring(self._pages, old)
                os.fsync(self._file)
                os.ftruncate(self._undo, 0)
        except OSError as error:
            self._restore(error)
            raise
        self._end, self._pages, self._stages = self._size, {}, []

    def _bring(self, pages: Mapping[int, bytes] | Mapping[int, bytearray], there: dict[int, bytes]) -> None:
        """Write the pages that differ from those on disk."""
        for number, page in pages.items():
            if there[number] != page:
                _write_at(self._file, page, number * PAGE)
                there[number] = bytes(page)

    def _check_there(self) -> None:
        """Raise `OSError` if the file or its folder has been removed or replaced."""
        mine, found = os.fstat(self._file), os.stat(self.path, follow_symlinks=False)
        if (mine.st_dev, mine.st_ino) != (found.st_dev, found.st_ino):
            raise FileNotFoundError(errno.ENOENT, "another file has taken its place", str(self.path))

    def _keep(self, undo: bytes) -> None:
        """Store the undo file on the device."""
        if self._undo < 0:
            self._undo = _new(undo_path(self.path))
            sync_folder(self.path.parent)
        _write_at(self._undo, undo, 0)
        os.fsync(self._undo)

    def _restore(self, error: OSError) -> None:
        """Restore the file to the last commit."""
        self.failed = error
        with suppress(OSError):
            os.ftruncate(self._file, self._end)
            roll_back(self.path)

    def sync(self) -> None:
        """Wait until the device has stored the committed data."""
        os.fsync(self._file)

    def close(self) -> None:
        """Close the file; changes without commit are lost."""
        if self._undo >= 0:
            if os.fstat(self._undo).st_size == 0:  # else it is still needed
                undo_path(self.path).unlink(missing_ok=True)
            os.close(self._undo)
            self._undo = -1
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def undo_path(path: Path) -> Path:
    """Return the path of the undo file of a file."""
    return path.with_name(path.name + ".undo")


def read_undo(path: Path) -> tuple[int, dict[int, bytes]] | None:
    """Read the size and the changed pages of the file before an interrupted commit; None if there was none.

    An incomplete undo file was never in use: the changes in place had not begun.
    """
    try:
        data = undo_path(path).read_bytes()
    except OSError:
        return None
    if not data.startswith(MAGIC) or len(data) < len(MAGIC) + HEAD.size + CHECK.size:
        return None
    if CHECK.unpack(data[-CHECK.size :])[0] != zlib.crc32(data[: -CHECK.size]):
        return None
    end, count = HEAD.unpack_from(data, len(MAGIC))
    at, pages = len(MAGIC) + HEAD.size, {}
    for _ in range(count):
        number, length = ENTRY.unpack_from(data, at)
        pages[number] = data[at + ENTRY.size : at + ENTRY.size + length]
        at += ENTRY.size + length
    return end, pages


def roll_back(path: Path) -> None:
    """Undo an interrupted commit."""
    undo = read_undo(path)
    if undo is not None:
        end, pages = undo
        file = _known(path)
        try:
            for number, old in pages.items():
                _write_at(file, old, number * PAGE)
            os.ftruncate(file, end)
            os.fsync(file)
        finally:
            os.close(file)
    undo_path(path).unlink(missing_ok=True)


def part_of(path: Path) -> Path:
    """Return the temporary name of a file that is being written."""
    return path.with_name(f".{path.name}.part")


@contextmanager
def replaced(path: Path, synced: bool = True) -> Iterator[Path]:
    """Yield a temporary name to write to; after the block that file replaces `path` atomically.

    synced: wait until the device has stored it. What can be drawn again needs no wait: a full disk or a kill leaves the
    older file all the same, a loss of power may not. Raises `InputError` where no file may be, see `refuse_special`.
    """
    refuse_special(path)
    part = part_of(path)
    part.unlink(missing_ok=True)  # left by a run that was killed; or a link, which must not be followed
    try:
        yield part
        if synced:
            with part.open("rb") as file:
                os.fsync(file.fileno())
        part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def unlinked(path: Path) -> Path:
    """Return the path after removing a symbolic link there, so that a new file does not follow it."""
    if path.is_symlink():
        path.unlink()
    return path


def refuse_link(folder: Path) -> None:
    """Raise `InputError` if a folder that a run makes is a symbolic link: files behind it must not be replaced."""
    if folder.is_symlink():
        remedy = "is a symbolic link, which is not followed; remove it, or name another place"
        raise InputError("out", str(folder), remedy)


def lost_link(place: Path) -> str | None:
    """Return why no folder can be made at a place: it, or a folder above it, is a link to nothing; None if none is."""
    for path in (place, *place.parents):
        if os.path.islink(path) and not os.path.exists(path):  # pathlib raises errors
            of_it = "" if path == place else f"{str(path)!r} "
            return f"{of_it}is a symbolic link that leads nowhere; make what it leads to, or name another place"
    return None


def refuse_lost_link(place: Path, field: str = "out") -> None:
    """Raise `InputError` for the place of a folder that is, or lies behind, a symbolic link to nothing."""
    remedy = lost_link(place)
    if remedy is not None:
        raise InputError(field, str(place), remedy)


def refuse_special(path: Path, field: str = "out") -> None:
    """Raise `InputError` if a device, a pipe or a socket is where a file is to be written, or if a link leads to one.

    A file of this name would take its place. field: what names the file. In the folder of devices nothing is replaced,
    not even a link there that leads to an ordinary file, such as the standard output.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):  # nothing there yet; or the name is wrong, which the one who writes says
        mode = stat.S_IFREG
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)) or path.absolute().parent == DEVICES:
        raise InputError(field, str(path), "is no ordinary file; name another")


def sync_folder(folder: Path) -> None:
    """Wait until the device has stored the names in a folder, where the system can do so."""
    with suppress(OSError):
        file = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(file)
        finally:
            os.close(file)


NO_LINK = getattr(os, "O_NOFOLLOW", 0)


def _new(path: Path) -> int:
    """Open a new file in place of an existing one."""
    refuse_special(path)
    path.unlink(missing_ok=True)
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | NO_LINK, 0o666)


def _known(path: Path) -> int:
    """Open an existing file for changes. Raises `OSError`, also for a symbolic link."""
    if path.is_symlink():
        raise OSError(errno.ELOOP, "a symbolic link, which is not followed; put the file itself there", str(path))
    return os.open(path, os.O_RDWR | NO_LINK)


def _undo_bytes(end: int, pages: dict[int, bytes]) -> bytes:
    parts = [MAGIC, HEAD.pack(end, len(pages))]
    for number, old in pages.items():
        parts += [ENTRY.pack(number, len(old)), old]
    data = b"".join(parts)
    return data + CHECK.pack(zlib.crc32(data))


def _write_at(file: int, data: Any, place: int) -> None:
    view = memoryview(data)
    while len(view):
        done = os.pwrite(file, view, place)
        view, place = view[done:], place + done
