"""The folder of a run: which files in it the program wrote, and how a new run takes the place of an old one."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..base import validate
from ..base.errors import InputError, OutputError
from ..device.atomic_file import part_of, refuse_special
from ..run.folder_lock import ASIDE, PUT_ASIDE, made_and_locked

NO_RESULT = "no such file; give a result.vtkhdf or the folder of a run"
KEPT = ("summary.json", "history.csv", "checkpoint-?.npz")  # what a run leaves that has begun
OURS = (
    "summary.json",
    "history.csv",
    "profile.csv",
    "yield-limit.png",
    "surface.png",
    "result.vtkhdf",
    "result.vtkhdf.undo",
    "result-parts/*.vtkhdf",
    "result-parts/*.vtkhdf.undo",
    ".result.vtkhdf.joined",
    ".result.vtkhdf.joined.undo",
    "checkpoint-?.npz",
    "checkpoint-ranks/*/checkpoint-?.npz",
    "contact-force.png",
    "gap.png",
    "energy.png",
    "comparison.png",
    "bodies.png",
    "deflection.png",
    "forces.png",
    "friction.png",
    "motion.png",
    "profile.png",
    "spin.png",
    "sliding.png",
    "tractions.png",
    "work.png",
    "layer_*/contact-face.png",
    "layer_*/frames/frame-*.png",
    "plastic_strain/bodies.png",
    "plastic_strain/frames/frame-*.png",
    "temperature/bodies.png",
    "temperature/frames/frame-*.png",
    "contact-face.png",
    "animation.gif",
    "animation.mp4",
    "frames/frame-*.png",
    "report.html",
    "side-by-side.html",
    "export/frame-*.vtu",
    "export/series.*",
    "study.json",
    "study.csv",
    "study.png",
)
HALF = tuple(str(part_of(Path(pattern))) for pattern in OURS)  # those that a kill has left while they were written


def result_file(given: Path) -> Path:
    """Return the result file that a word names: itself, or that of a folder.

    Raises `InputError` if there is none, with the runs of a comparison where the folder holds one.
    """
    path = given / "result.vtkhdf" if validate.is_folder(given) else given
    if path != given and not path.is_file() and (runs := _runs(given)):
        names = ", ".join(str(given / name) for name in runs)
        raise InputError("file", str(given), f"holds a comparison; name one of its runs: {names}")
    validate.file_exists("file", path, PUT_ASIDE if (path.parent / ASIDE / path.name).is_file() else NO_RESULT)
    return path


def our_files(folder: Path) -> list[Path]:
    """Return the files in the folder that a run wrote, those of the runs of a comparison included; nothing else.

    A symbolic link counts as itself, wherever it leads; nothing behind one to a folder is ours.
    """
    if not folder.is_dir():
        return []
    places = [folder, *(folder / name for name in _runs(folder))]
    found = [path for place in places for pattern in OURS + HALF for path in sorted(place.glob(pattern))]
    return [path for path in found if (path.is_file() or path.is_symlink()) and not _behind_a_link(path, folder)]


def _behind_a_link(path: Path, folder: Path) -> bool:
    """Tell whether a folder between `folder` and the file is a symbolic link."""
    parents = path.relative_to(folder).parents
    return any((folder / parent).is_symlink() for parent in parents if parent != Path("."))


def _runs(folder: Path) -> list[str]:
    """Return the subfolders that the summary of a comparison names."""
    try:
        names = json.loads((folder / "summary.json").read_text(encoding="utf-8")).get("runs", [])
    except (OSError, ValueError, AttributeError):
        return []
    return [name for name in names if isinstance(name, str) and name == Path(name).name and name not in ("", ".", "..")]


@contextmanager
def writable(folder: Path) -> Iterator[None]:
    """Refuse the folder if an `OSError` says that it takes no files; an `OutputError` of a run says more itself."""
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        raise InputError("--out", str(folder), f"cannot be written ({error}); name another folder") from error


@contextmanager
def replacing(folder: Path, force: bool) -> Iterator[None]:
    """Let a new run write into the folder; the files of an older run go when the new one has succeeded.

    The folder is made and locked until the block has ended, pictures included; no other run is let in.
    If the new run is refused before it has begun, the older files come back; where a kill has ended one at its start,
    the next run puts them back. Files that are not ours stay where they are. Raises `InputError` if the folder holds
    a run and force is False, if it is no folder or takes no files, or if a device or pipe is where a file is to be.
    """
    with writable(folder):
        if folder.exists() and not folder.is_dir():
            raise InputError("--out", str(folder), "is a file; name a folder")
        for path in (path for pattern in OURS for path in folder.glob(pattern)):
            refuse_special(path, "--out")
        with made_and_locked(folder):
            yield from _replacing(folder, force)


def _replacing(folder: Path, force: bool) -> Iterator[None]:
    aside = folder / ASIDE
    if aside.is_symlink():
        remedy = "is a symbolic link, which is not followed; remove it, or name another folder"
        raise InputError("--out", str(aside), remedy)
    if our_files(aside) and not our_files(folder):  # a kill has ended the run that was to replace them
        _put_back(folder)
    old = our_files(folder)
    if old and not force:
        raise InputError("--out", str(folder), "holds another run; name another folder or add --force to replace it")
    shutil.rmtree(aside, ignore_errors=True)
    for path in old:
        _move(path, aside / path.relative_to(folder))
    try:
        yield
    except BaseException as error:
        new = our_files(folder)
        begun = any(path.match(pattern) for path in new for pattern in KEPT) or not isinstance(error, InputError)
        if not (new and begun):
            _put_back(folder)
        raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)
        for path in old:
            if (
                path.parent != folder
                and path.parent.is_dir()
                and not path.parent.is_symlink()
                and not any(path.parent.iterdir())
            ):
                path.parent.rmdir()


def _put_back(folder: Path) -> None:
    """Remove the files of a run that has not begun, and give the older run its place again, if there is one."""
    for path in our_files(folder):
        path.unlink()
    aside = folder / ASIDE
    for path in our_files(aside):
        _move(path, folder / path.relative_to(aside))
    shutil.rmtree(aside, ignore_errors=True)


def _move(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    source.replace(target)
