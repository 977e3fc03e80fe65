"""A run that was read back from its files."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, NoReturn

import numpy as np

from ..base import validate
from ..base.errors import InputError
from ..kernels.columns import COLUMNS
from .files.checkpoint_heads import goes_on
from .files.vtkhdf import Frame, ResultData
from .outcome import Outcome
from .result import Maximum

METALS = ("plastic_strain", "temperature")  # cell fields of metals
ELSEWHERE = "is in checkpoints and in the Result of `simulate` alone"
NUMBERS = ("time", "dt", "dt_limit", "wall_s", "compile_s", "cell_updates_per_s")

PARTS = {"parameters": dict, "versions": dict, "figures": dict, "checks": list, "runs": list, "warnings": list}
CHECK = {"name", "value", "bound", "passed"}  # of a check in a summary


class NotStored(InputError, AttributeError):
    """What was asked for is not in the files of the run."""


class StoredResult(Outcome):
    """A run that was read back from its files: it has what a `Result` has, frames are read when asked for.

    frames: the stored frames (`ResultData`), from which `position`, `velocity`, `contact_node_force` [n, 3] and
    `metals` at the end are read; summary: what summary.json holds, such as "case", "parameters", "checks" and
    "versions"; scene, scheme: those of a run of the command line, made again from the case or scene file that
    summary.json or a checkpoint names, or what was given to `open_result`.
    The numbers ok, reason, message, steps, time, dt, dt_limit, wall_s, compile_s, cell_updates_per_s, terms, warnings
    and precision are those of `Result`. `layers`, `points` and `contact_pressures` are not stored. A run that has not
    ended has reason "running".
    Raises `InputError` (`NotStored`) for what is not in the files.
    """

    made_again: ClassVar[Callable[[Mapping[str, Any], Path], Any]]  # by the command line, above; the package sets it

    def __init__(self, data: ResultData, summary: Mapping[str, Any], scene: Any = None, scheme: Any = None) -> None:
        self.data, self.summary = data, dict(summary)
        self._given = (scene, scheme) if scene is not None else None
        known: Mapping[str, Any] = data.attributes
        if "reason" not in known and summary.get("reason") == "not-written":
            known = summary  # the result file found no room for its end
        self.ok = bool(known.get("ok", False))
        self.reason = str(known.get("reason", "running"))
        self.message = str(known.get("message") or ("" if "reason" in known else unended(data)))
        self.steps = int(known.get("steps", 0))
        self.time, self.dt, self.dt_limit, self.wall_s, self.compile_s, self.cell_updates_per_s = (
            float(known.get(name, "nan")) for name in NUMBERS
        )
        self.memory = {str(name): int(size) for name, size in known.get("memory_bytes", {}).items()}
        self.terms = tuple(known.get("terms", ()))
        self.warnings = list(known.get("warnings", ()))
        self.precision = str(known.get("precision", "f64"))

    @property
    def file(self) -> Path:
        """The result file."""
        return self.data.path

    @property
    def frames(self) -> ResultData:
        """The stored frames, read when asked for: times [s], frame(index), points, point_fields, cell_fields."""
        return self.data

    @cached_property
    def history(self) -> dict[str, np.ndarray]:  # type: ignore[override]
        """One row per step, columns as in docs/COLUMNS.md. Raises `InputError` where the run has not ended."""
        history = self.data.history
        if not history or not len(history["time"]):
            why = unended(self.data)
            if self.reason == "not-written":
                why = f"{self.message}{_rows_beside(self.data.path.parent)}"
            raise InputError("file", str(self.data.path), f"it holds no history: {why}")
        order = {column.name: number for number, column in enumerate(COLUMNS)}
        names = sorted(history, key=lambda name: order.get(name.partition(":")[0], len(order)))
        return {name: history[name] for name in names}

    @cached_property
    def _found(self) -> Any:
        """Return what the command line makes again, None where it does not know."""
        return None if self._given is not None else type(self).made_again(self.summary, self.data.path.parent)

    @cached_property
    def _made(self) -> tuple[Any, Any]:
        """Return scene and scheme, None for what is not known. Raises `NotStored` if they are not those of the run."""
        if self._given is not None or self._found is None:
            return self._given or (None, None)
        self._found.check_same(self.summary, self.data)
        return self._found.scene, self._found.scheme

    @property
    def case(self) -> Any:
        """The module of the case, None where no case was run or it is no longer there."""
        return getattr(self._found, "case", None)

    @property
    def scene(self) -> Any:
        """The scene. Raises `NotStored` where it is not known, or its case or scene file was edited after the run."""
        if self._made[0] is None:
            self._refuse("scene", f"{self._maker}: give it to open_result(folder, scene=...)")
        return self._made[0]

    @property
    def scheme(self) -> Any:
        """The scheme. Raises `NotStored` as `scene` does."""
        if self._made[0] is None:
            self._refuse("scheme", f"{self._maker}: give it to open_result(folder, scene=..., scheme=...)")
        return self._made[1]

    @property
    def _maker(self) -> str:
        """Return what is known of who made the scene, where it cannot be made again."""
        if self.summary:
            return "a program made it"
        if self.reason == "running":
            return "the run goes on, or was killed before it wrote summary.json, and no checkpoint names its case"
        return "there is no summary.json that says what made it"

    @property
    def layers(self) -> Any:
        """Not stored."""
        self._refuse("layers", f"the state of friction layers {ELSEWHERE}")

    @property
    def points(self) -> Any:
        """Not stored."""
        self._refuse("points", f"the state of material points {ELSEWHERE}")

    @property
    def contact_pressures(self) -> Any:
        """Not stored."""
        self._refuse("contact_pressures", "only the Result of `simulate` has the pressures of all nodes in all steps")

    @property
    def maxima(self) -> dict[str, Maximum]:
        """The largest values of the quantities in `Scene.maxima`, by name."""
        return {name: Maximum(**one) for name, one in self.data.attributes.get("maxima", {}).items()}

    @property
    def peaks(self) -> dict[str, float]:
        """The largest values of all steps, as in `Result`; {} in files of earlier versions."""
        return stored_peaks(self.data)

    @property
    def position(self) -> np.ndarray:
        """Positions [n, 3] [m] of the nodes in the last frame, in the user's numbering, bodies stacked in order."""
        return np.asarray(self.data.points + self._last("position", "displacement"))

    @property
    def velocity(self) -> np.ndarray:
        """Velocities [n, 3] [m/s] of the nodes in the last frame."""
        return self._last("velocity", "velocity")

    @property
    def contact_node_force(self) -> np.ndarray:
        """Contact force [n, 3] [N] on the nodes in the last frame."""
        return self._last("contact_node_force", "contact_force")

    @property
    def metals(self) -> dict[str, np.ndarray]:
        """With metals "plastic_strain" and "temperature" [K] of every cell in the last frame."""
        known = [name for name in METALS if name in self.data.cell_fields]
        return {name: np.asarray(self._end.cell_data[name]) for name in known} if known else {}

    def nodes_of(self, name: str) -> slice:
        """Return the rows of a body in position, velocity and contact_node_force; `InputError` for an unknown name."""
        names = self.data.attributes.get("bodies") or ["body-0"]
        number = names.index(validate.choice("name", name, names))
        if len(names) == 1:
            return slice(0, len(self.data.points))
        body, first = self._end.cell_data["body"], 0
        ends = np.zeros(len(names), dtype=int)
        for _, cells in self.data.blocks:
            np.maximum.at(ends, body[first : first + len(cells)].astype(int), cells.max(axis=1) + 1)
            first += len(cells)
        ends[-1] = len(self.data.points)
        return slice(int(ends[number - 1]) if number else 0, int(ends[number]))

    @property
    def _end(self) -> Frame:
        if not len(self.data):
            self._refuse("frames", "the run stored none; run it again with frames > 0")
        return self.data.frame(len(self.data) - 1)

    def _last(self, name: str, field: str) -> np.ndarray:
        frame = self._end
        if field not in frame.point_data:
            self._refuse(name, f"the frames have no {field}; run it again with this field")
        return np.asarray(frame.point_data[field])

    def _refuse(self, name: str, remedy: str) -> NoReturn:
        raise NotStored(name, str(self.data.path), f"is not stored: {remedy}")

    def __repr__(self) -> str:
        if self.reason == "running":
            return f"StoredResult({self.data.path}, {self.message}, {len(self.data)} frames)"
        error = float(self.data.attributes.get("energy_error_max", "nan"))
        return (
            f"StoredResult({self.data.path}, {self.reason}, {self.steps} steps to {self.time:.6g} s,"
            f" energy error {error:.2g}, {len(self.data)} frames)"
        )


def stored_peaks(data: ResultData) -> dict[str, float]:
    """Return `Result.peaks` of a result file; {} in files of earlier versions."""
    found = data.attributes.get("peaks", {})
    return {name: float(value) for name, value in found.items()} if isinstance(found, dict) else {}


def open_result(folder: Path | str, scene: Any = None, scheme: Any = None) -> StoredResult:
    """Read a run back that `simulate(out=...)` or `tcontact run` left in a folder.

    folder: of the run, or its result.vtkhdf; scene, scheme: those that were run, where a program made them (runs of the
    command line make them again from their case or scene file).
    Raises `InputError` if there is no run, or its file is damaged.
    """
    path = validate.path("folder", folder, "give the folder of a run, or its result.vtkhdf")
    if path.is_dir():
        summary = read_summary(path)
        if "runs" in summary:
            names = ", ".join(str(path / str(name)) for name in summary["runs"])
            raise InputError("folder", str(path), f"holds a comparison; open one of its runs: {names}")
        path = path / "result.vtkhdf"
    if not path.is_file():
        raise InputError("folder", str(folder), "holds no result.vtkhdf; give the folder of a run, or its result file")
    summary = read_summary(path.parent) if path.name == "result.vtkhdf" else {}
    return StoredResult(ResultData.open(path), summary, scene, scheme)


def unended(data: ResultData) -> str:
    """Return what there is to know of a run whose result file names no end."""
    folder = data.path.parent
    if goes_on(folder, len(data)):
        return f"the run has not ended: it goes on, or `tcontact resume {folder}` goes on with it"
    text = "the run has not ended: it goes on, or it stopped before its first checkpoint and has to be run again"
    return f"{text}{_rows_beside(folder)}"


def _rows_beside(folder: Path) -> str:
    """Return where the rows of a run are whose result file has none, to be added to a message; "" where nowhere."""
    return "; history.csv has its rows" if (folder / "history.csv").is_file() else ""


def read_summary(folder: Path) -> dict[str, Any]:
    """Return what the summary.json of a folder holds, {} where there is none that can be read as one."""
    try:
        found = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if is_summary(found) else {}


def is_summary(data: Any) -> bool:
    """Tell whether data from a summary.json are named parts, each of the type that it has there."""
    if not isinstance(data, dict) or not all(isinstance(data.get(name, kind()), kind) for name, kind in PARTS.items()):
        return False
    return all(isinstance(check, dict) and check.keys() >= CHECK for check in data.get("checks", ()))
