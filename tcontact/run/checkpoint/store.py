"""Keep two checkpoint files in a folder: a new one, once complete, replaces the older one by renaming."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...device.atomic_file import part_of, replaced
from ...results.files.checkpoint_heads import (
    FILES,
    HEAD,
    RANKS,
    UNREADABLE,
    Place,
    head_of,
    others,
    place_in_run,
    place_of,
)

FORMAT = 4


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
        return self.place[0]

    @property
    def ranks(self) -> int:
        """Number of ranks of the run, which have written a checkpoint each; 1 for one process."""
        return self.place[1]

    @property
    def place(self) -> Place:
        """Row and number of ranks."""
        return place_in_run(self.head)


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


def write(
    folder: Path,
    head: dict[str, Any],
    values: dict[str, Any],
    found: dict[str, np.ndarray],
    spared: Place | None = None,
) -> Path:
    """Replace one of the two checkpoints by a new one; return its file. Raises `OSError`.

    spared: of the last checkpoint that is complete, which stays; of others the older one goes.
    """
    places = {name: (-1, 0) if (stored := head_of(folder / name)) is None else place_in_run(stored) for name in FILES}
    path = folder / min(FILES, key=lambda name: (places[name] == spared, places[name]))
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
            except UNREADABLE:
                bad.append(path)
            except OtherFormat as error:
                other = path, str(error)
    if other and not good:
        raise InputError("folder", str(other[0]), other[1])
    return sorted(good, key=lambda stored: -stored.row), bad


def at(folder: Path, rank: int, place: Place, known: Sequence[Stored] | None = None) -> Stored:
    """Return the checkpoint of a rank at a row of a run on some ranks, as `last_complete` names them.

    known: checkpoints of this rank that were read already.
    """
    there = read_all(place_of(folder, rank))[0] if known is None else known
    return next(one for one in there if one.place == place)


def remove_later(folder: Path, place: Place, rank: int = 0, ranks: int = 1) -> None:
    """Remove the checkpoints that a run leaves behind which goes on from the complete one at `place`.

    They are as late or later, and some rank has not written them, or they cannot be used: left there they would stand
    beside those that the run writes at the same rows. rank, ranks: of this process, which looks after every `ranks`-th
    folder of ranks. A file that cannot be removed is overwritten by the next checkpoint.
    """
    for number in (0, *others(folder)):
        for path in (place_of(folder, number) / name for name in FILES if number % ranks == rank):
            stored = head_of(path)
            if stored is not None and int(stored["row"]) >= place[0] and place_in_run(stored) != place:
                with suppress(OSError):
                    path.unlink()


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
