"""Keep two checkpoint files in a folder: a new one, once complete, replaces the older one by renaming."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...device.atomic_file import part_of, replaced

FILES = ("checkpoint-a.npz", "checkpoint-b.npz")
RANKS = "checkpoint-ranks"  # folder of those of the other ranks, one below it for each
FORMAT = 4
HEAD = "head"


@dataclass(frozen=True)
class Stored:
    """A checkpoint that was read: head and values are plain data, found holds the arrays; path: its file."""

    path: Path
    head: dict[str, Any]
    values: dict[str, Any]
    found: dict[str, np.ndarray]

    @property
    def row(self) -> int:
        """Row of the history at which it was written."""
        return int(self.head["row"])

    @property
    def ranks(self) -> int:
        """Number of ranks of the run, which have written a checkpoint each; 1 for one process."""
        return int(self.head.get("ranks", 1))


class OtherFormat(Exception):
    """A checkpoint has the format of another version of the program; the text says which."""


@contextmanager
def taken_over(stored: Stored) -> Iterator[None]:
    """Raise `InputError` where the state in a checkpoint does not fit the run that takes it over."""
    try:
        yield
    except InputError:  # a function of time differs
        raise
    except (KeyError, ValueError, IndexError) as error:
        made = stored.head.get("versions", {})
        remedy = f"was left by another version of the program ({made}): {error.args[0] if error.args else error}"
        raise InputError("folder", str(stored.path), f"{remedy}; resume it with that one, or run it again") from error


def write(folder: Path, head: dict[str, Any], values: dict[str, Any], found: dict[str, np.ndarray]) -> Path:
    """Replace the older of the two checkpoints by a new one; return its file. Raises `OSError`."""
    rows = {name: -1 if (stored := _head(folder / name)) is None else int(stored["row"]) for name in FILES}
    path = folder / min(FILES, key=lambda name: rows[name])
    text = json.dumps({"format": FORMAT, **head, "values": values, "names": list(found)})
    parts = {str(number): array for number, array in enumerate(found.values())}
    with replaced(path) as part, part.open("wb") as file:
        parts[HEAD] = np.frombuffer(text.encode(), dtype=np.uint8)
        np.savez(file, allow_pickle=False, **parts)
        file.flush()
    return path


def read_all(folder: Path) -> tuple[list[Stored], list[Path]]:
    """Read the complete checkpoints of a folder, latest first; also return the damaged files.

    Raises `InputError` if all that are complete have another format.
    """
    good, bad, other = [], [], None
    for path in (folder / name for name in FILES):
        if path.is_file():
            try:
                good.append(_read(path))
            except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, NotImplementedError):
                bad.append(path)
            except OtherFormat as error:
                other = path, str(error)
    if other and not good:
        raise InputError("folder", str(other[0]), other[1])
    return sorted(good, key=lambda stored: -stored.row), bad


def head(folder: Path) -> dict[str, Any]:
    """Return the plain data of the latest checkpoint of a folder, {} where there is none that can be read."""
    found = (_head(folder / name) for name in FILES)
    return max((one for one in found if one is not None), key=lambda one: int(one["row"]), default={})


def place_of(folder: Path, rank: int) -> Path:
    """Return the folder for the checkpoints of a rank."""
    return folder if rank == 0 else folder / RANKS / str(rank)


def others(folder: Path) -> list[int]:
    """Return the numbers of the ranks beside the first one that have left checkpoints, ascending."""
    return sorted(int(found.name) for found in (folder / RANKS).glob("*") if found.name.isdigit())


def last_complete(known: Iterable[tuple[int, int, int]]) -> tuple[int, int] | None:
    """Return row and number of ranks of the last checkpoint that every rank of its run has written, None without any.

    known: rank, row and number of ranks of all checkpoints that were read.
    """
    have: dict[tuple[int, int], set[int]] = {}
    for rank, row, ranks in known:
        have.setdefault((row, ranks), set()).add(rank)
    return max((one for one, ranks in have.items() if ranks == set(range(one[1]))), default=None)


def at(folder: Path, rank: int, place: tuple[int, int], known: Sequence[Stored] | None = None) -> Stored:
    """Return the checkpoint of a rank at a row of a run on some ranks, as `last_complete` names them.

    known: checkpoints of this rank that were read already.
    """
    there = read_all(place_of(folder, rank))[0] if known is None else known
    return next(one for one in there if (one.row, one.ranks) == place)


def remove(folder: Path) -> None:
    """Remove the checkpoints of a folder and temporary files left by a kill."""
    for name in FILES:
        (folder / name).unlink(missing_ok=True)
        part_of(folder / name).unlink(missing_ok=True)
    for other in sorted((folder / RANKS).glob("*")):
        remove(other)
        with suppress(OSError):
            other.rmdir()
    with suppress(OSError):
        (folder / RANKS).rmdir()


def _read(path: Path) -> Stored:
    """Read a checkpoint. Raises one of several errors for a damaged file; zip checks a sum of every part.

    Raises `OtherFormat` for a file of another version.
    """
    data = path.read_bytes()
    with zipfile.ZipFile(io.BytesIO(data)) as parts:
        if parts.testzip() is not None:
            raise zipfile.BadZipFile(f"{path} is damaged")
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        head = json.loads(stored[HEAD].tobytes())
        if (form := head.pop("format")) != FORMAT:
            made = dict(head.get("versions", {})).get("tcontact", "unknown")
            remedy = f"has format {form}, written by version {made}, and this one reads {FORMAT}"
            raise OtherFormat(f"{remedy}; resume the run with that version, or run it again")
        found = {name: stored[str(number)] for number, name in enumerate(head.pop("names"))}
    values = head.pop("values")
    return Stored(path, head, values, found)


def _head(path: Path) -> dict[str, Any] | None:
    """Read the plain data of a checkpoint; None if it is missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            return dict(json.loads(stored[HEAD].tobytes()))
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, NotImplementedError):
        return None
