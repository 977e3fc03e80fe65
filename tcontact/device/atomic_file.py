"""Files that a kill, a full disk or a crash leave either as they were or as they were meant to be.

What HDF5 writes beyond the old end of an `AtomicFile` goes there at once: nothing refers to it yet. What it changes in
place stays in memory until `commit` has written an undo file with the old content and the device has it; then it goes
to disk, and when the device has that too the undo file is emptied. An undo file with a content that is found means that
a commit was cut short: what it holds is the truth (rollback journal as in SQLite,
https://www.sqlite.org/atomiccommit.html).

No symbolic link is followed to a file that is written: a link at its place is replaced, or refused where the file is to
be gone on with.
"""

from __future__ import annotations

import errno
import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..base.errors import InputError

PAGE = 4096
MAGIC = b"tcontact undo 1\n"
HEAD = struct.Struct("<QQ")  # bytes of the file before the commit; pages that follow
ENTRY = struct.Struct("<QI")  # number of a page, its bytes
CHECK = struct.Struct("<I")


class AtomicFile:
    """A binary file of which the disk sees only what was committed; what h5py wants of a file object.

    path: the file; mode: "w" a new one, "r+" an existing one, "r" to look at one, as it was before a commit that was
    cut short. If the disk fails the next commit raises `OSError` and leaves the file as it was; from then on nothing
    reaches it.
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
        self._pages: dict[int, bytearray] = {}  # changed, within the committed size
        self._stages: list[dict[int, bytes]] = []  # earlier states of them, in the order in which they go to disk
        self._at = 0
        self._undo = -1  # the undo file, once there is one
        if mode == "w":
            undo_path(self.path).unlink(missing_ok=True)
        self._end = os.fstat(self._file).st_size  # of what was committed
        undo = read_undo(self.path) if mode == "r" else None
        if undo is not None:
            self._end, pages = undo
            self._pages = {number: bytearray(old) for number, old in pages.items()}
        self._size = self._end

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """As of any file."""
        start = (0, self._at, self._size)[whence]
        self._at = start + offset
        return self._at

    def tell(self) -> int:
        """As of any file."""
        return self._at

    def read(self, size: int = -1) -> bytes:
        """As of any file."""
        left = max(0, self._size - self._at)
        buffer = bytearray(left if size < 0 else min(size, left))
        self.readinto(buffer)
        return bytes(buffer)

    def readinto(self, buffer: Any) -> int:
        """Fill the buffer from the present place; bytes read."""
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
        """Where the next changed page begins, or the end."""
        if not self._pages:
            return self._end
        return min((page * PAGE for page in self._pages if page > number), default=self._end)

    def write(self, data: Any) -> int:
        """Take the bytes at the present place."""
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
                self._give_up(error)
            self._at += len(view) - done
            self._size = max(self._size, self._at)
        return len(view)

    def _old(self, number: int) -> bytes:
        """A page as the disk has it."""
        first = number * PAGE
        return os.pread(self._file, min(PAGE, self._end - first), first)

    def truncate(self, size: int) -> int:
        """Set the size; what was committed stays allocated."""
        self._size = max(size, self._end)
        try:
            if self.failed is None and os.fstat(self._file).st_size != self._size:
                os.ftruncate(self._file, self._size)
        except OSError as error:
            self._give_up(error)
        return size

    def flush(self) -> None:
        """Nothing: only `commit` goes to disk."""

    def stage(self) -> None:
        """Let the next commit bring what was written so far to the file before all that is written from now on."""
        self._stages.append({number: bytes(page) for number, page in self._pages.items()})

    def commit(self) -> None:
        """Bring all that was written to the file, or nothing of it. Raises `OSError`."""
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
            self._give_up(error)
            raise
        self._end, self._pages, self._stages = self._size, {}, []

    def _bring(self, pages: Mapping[int, bytes] | Mapping[int, bytearray], there: dict[int, bytes]) -> None:
        """Write the pages that differ from those of the disk."""
        for number, page in pages.items():
            if there[number] != page:
                _write_at(self._file, page, number * PAGE)
                there[number] = bytes(page)

    def _check_there(self) -> None:
        """Raise `OSError` if the file has been removed or replaced, by itself or with its folder."""
        mine, found = os.fstat(self._file), os.stat(self.path, follow_symlinks=False)
        if (mine.st_dev, mine.st_ino) != (found.st_dev, found.st_ino):
            raise FileNotFoundError(errno.ENOENT, "another file has taken its place", str(self.path))

    def _keep(self, undo: bytes) -> None:
        """Bring the undo file to the device."""
        if self._undo < 0:
            self._undo = _new(undo_path(self.path))
            sync_folder(self.path.parent)
        _write_at(self._undo, undo, 0)
        os.fsync(self._undo)

    def _give_up(self, error: OSError) -> None:
        """Leave the file as the last commit did."""
        self.failed = error
        with suppress(OSError):
            os.ftruncate(self._file, self._end)
            roll_back(self.path)

    def sync(self) -> None:
        """Wait until the device has what was committed."""
        os.fsync(self._file)

    def close(self) -> None:
        """Let go of the file; what was not committed is forgotten."""
        if self._undo >= 0:
            if os.fstat(self._undo).st_size == 0:  # else it is still needed
                undo_path(self.path).unlink(missing_ok=True)
            os.close(self._undo)
            self._undo = -1
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def undo_path(path: Path) -> Path:
    """The undo file of a file."""
    return path.with_name(path.name + ".undo")


def read_undo(path: Path) -> tuple[int, dict[int, bytes]] | None:
    """Size and changed pages of the file before a commit that was cut short; None if there was none.

    An undo file that is not whole was never in use: the changes in place had not begun.
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
    """Take back a commit that was cut short."""
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
    """The temporary name of a file that is being written."""
    return path.with_name(f".{path.name}.part")


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary name to write to; after the block it takes the place of `path`, at once and safely on the device."""
    part = part_of(path)
    part.unlink(missing_ok=True)  # of a run that was killed; or a link, which is not ours to follow
    try:
        yield part
        with part.open("rb") as file:
            os.fsync(file.fileno())
        part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def unlinked(path: Path) -> Path:
    """The path, free for a new file where it was a symbolic link: a file written there does not follow it."""
    if path.is_symlink():
        path.unlink()
    return path


def refuse_link(folder: Path) -> None:
    """Raise `InputError` if a folder that a run makes is a symbolic link: files behind it are not ours to replace."""
    if folder.is_symlink():
        remedy = "is a symbolic link, which is not followed; remove it, or name another place"
        raise InputError("out", str(folder), remedy)


def sync_folder(folder: Path) -> None:
    """Wait until the device has the names in a folder, where folders can be waited for."""
    with suppress(OSError):
        file = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(file)
        finally:
            os.close(file)


NO_LINK = getattr(os, "O_NOFOLLOW", 0)


def _new(path: Path) -> int:
    """Open a new file in place of what is there, which goes."""
    path.unlink(missing_ok=True)
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | NO_LINK, 0o666)


def _known(path: Path) -> int:
    """Open a file that is there, to be changed. Raises `OSError`, also for a symbolic link."""
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
