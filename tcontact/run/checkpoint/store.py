"""Keep two checkpoint files in a folder: a new one, once complete, replaces the older one by renaming."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...device.atomic_file import part_of, replaced

FILES = ("checkpoint-a.npz", "checkpoint-b.npz")
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


class OtherFormat(Exception):
    """A checkpoint has the format of another version of the program; the text says which."""


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


def remove(folder: Path) -> None:
    """Remove the checkpoints of a folder and temporary files left by a kill."""
    for name in FILES:
        (folder / name).unlink(missing_ok=True)
        part_of(folder / name).unlink(missing_ok=True)


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
