"""Write frames into result.vtkhdf during a run; complete frames survive a stop."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..base import validate
from ..base.errors import FunctionError, InputError, OutputError
from ..cells.cell_stress import CellStress, pressure_of
from ..cells.point_state import has_state, metal_field
from ..cells.stress import VonMises
from ..device.atomic_file import refuse_special
from ..mesh.geometry import joined
from ..results.files.checkpoint_heads import FILES as CHECKPOINTS
from ..results.files.checkpoint_heads import goes_on
from ..results.files.frame_process import FrameProcess
from ..results.files.joined_file import join_parts
from ..results.files.late_fields import LateField, whole
from ..results.files.vtkhdf import ResultData, ResultFile
from ..results.frame_fields import FRICTION, LAYERS, METAL, STRESS, frame_size
from ..scene.obstacles.description import describe
from ..scene.scene import Scene
from ..schemes.explicit.body_view import BodyView
from .contact_fields import ContactFields
from .folder_lock import check_free, held
from .snapshot import Snapshot

FILE = "result.vtkhdf"
CONTACT = "contact_force", "contact_pressure"


def check_folder(out: Any) -> Path:
    """Check and return the output folder before a run. Raises `InputError` if it cannot hold a new result."""
    validate.working_directory()
    try:
        folder = Path(out)
    except TypeError as error:
        raise InputError("out", out, "give a folder name or None") from error
    if out == "":
        raise InputError("out", out, "give a folder name, '.' for this one")
    if "\0" in str(folder):
        raise InputError("out", out, "a folder name has no null characters")
    try:
        is_file = folder.exists() and not folder.is_dir()
    except OSError as error:
        raise InputError("out", str(folder), f"no folder can have this name ({error.strerror})") from error
    if is_file:
        raise InputError("out", str(folder), "this is a file; give a folder")
    check_free(folder)
    for name in ("summary.json", "history.csv", *CHECKPOINTS):
        refuse_special(folder / name)
    if os.path.lexists(folder / FILE):
        raise InputError(
            "out", str(folder), f"it already holds {FILE} of another run; choose another folder or remove it"
        )
    return folder


@contextmanager
def writing_beside(folder: Path, scene: Scene, fields: Sequence[str], frames: int) -> Iterator[FrameProcess | None]:
    """Start the process that writes so many frames in a locked folder, None where it does not pay; end it."""
    process = FrameProcess.start(frame_size(scene, fields), frames, held(folder))
    try:
        yield process
    finally:
        if process is not None:
            with suppress(OSError):
                process.close()


class Recorder:
    """Writes the frames: displacement, velocity, contact force and pressure of nodes, von Mises stress of cells.

    With friction layers also their surface temperature [K] and shear stress [Pa], with metals the plastic strain and
    temperature [K] of cells; where they are named, the pressure of cells, slip distance and friction work of nodes.
    """

    def __init__(
        self,
        folder: Path,
        scene: Scene,
        states: list[BodyView],
        title: str,
        fields: Sequence[str],
        frames: int | None = None,
    ) -> None:
        """Open the file; fields: those of the frames; frames: number of frames to keep in the file, None = new file.

        Raises `InputError` if the file cannot be made or continued.
        """
        self.states, self.folder = states, folder
        self.fields = fields
        self.process: FrameProcess | None = None  # takes over the file as soon as it has started
        self.file: ResultFile | FrameProcess
        meshes = [state.plan.body.mesh for state in states]
        self._celled = [number for number, mesh in enumerate(meshes) if mesh.cell_count]  # a rank may have nodes alone
        several, counts = len(scene.bodies) > 1, [mesh.cell_count for mesh in meshes]
        self._static = {"body": np.repeat(self._numbers, counts)} if several else {}
        self.obstacles, self.times = scene.obstacles, [0.0]
        self._paired = bool(scene.body_pairs)
        self._stateful = has_state(scene) and not {"von_mises", *METAL, *STRESS}.isdisjoint(fields)
        self._contact: ContactFields | None = None
        self.stress: list[VonMises] = []
        self.whole_stress: list[CellStress] = []
        self.attributes: dict[str, Any] = {"title": title, "obstacles": describe(scene.obstacles)}
        if several or scene.bodies[0].name:
            self.attributes["bodies"] = [scene.label(number) for number in range(len(scene.bodies))]
        try:
            self.file = self._opened(frames)
        except OSError as error:
            raise self._refusal(error) from error

    def _refusal(self, error: OSError) -> InputError:
        """Return the error for a file that cannot be made."""
        remedy = f"{FILE} cannot be written there ({error.strerror}); make room or name another folder"
        return InputError("out", str(self.folder), remedy)

    @property
    def _numbers(self) -> Sequence[int]:
        """Numbers in the scene of the bodies that it writes."""
        return range(len(self.states))

    def _opened(self, frames: int | None) -> ResultFile | FrameProcess:
        """Open a new file, or that of a run which goes on after so many frames."""
        if frames is None:
            meshes = [state.plan.body.mesh for state in self.states]
            starts = np.cumsum([0, *(mesh.node_count for mesh in meshes)])
            pairs = zip(meshes, starts, strict=False)
            blocks = [(kind, cells + start) for mesh, start in pairs for kind, cells in mesh.blocks]
            points = np.concatenate([mesh.nodes for mesh in meshes])
            return ResultFile.create(self.folder / FILE, points, blocks, self.attributes, self._static)
        join_parts(self.folder / FILE, frames)
        self.times += [float(time) for time in ResultData.open(self.folder / FILE).times[:frames]]
        return ResultFile.reopen(self.folder / FILE, frames, self.attributes)

    def prepare(self) -> None:
        """Prepare for the fields of the frames, before the first one."""
        if not set(CONTACT).isdisjoint(self.fields):
            self._contact = ContactFields(self.states, self._paired)
        if "von_mises" in self.fields:
            self.stress = [VonMises(state.plan.body, state.plan.node_order) for state in self._with_cells]
        if "pressure" in self.fields:
            self.whole_stress = [state.cell_stress() for state in self._with_cells]

    @property
    def _with_cells(self) -> list[BodyView]:
        return [self.states[number] for number in self._celled]

    def frame(self, time: float, snapshot: Snapshot) -> None:
        """Append the state at `time` [s] in the user's numbering. Raises `OutputError`."""
        self.times.append(float(time))
        nodal: dict[str, np.ndarray | LateField] = {"displacement": snapshot.displacement_field()}
        if "velocity" in self.fields:
            nodal["velocity"] = snapshot.velocity_field()
        if self._contact is not None:
            contact = dict(zip(CONTACT, self._contact.fields(), strict=True))
            nodal |= {name: contact[name] for name in CONTACT if name in self.fields}
        if not LAYERS.keys().isdisjoint(self.fields):
            layers = [state.layer_fields() for state in self.states]
            nodal |= {name: joined([one[name] for one in layers]) for name in layers[0] if name in self.fields}
        if not FRICTION.keys().isdisjoint(self.fields):
            rubbed = [state.friction_fields() for state in self.states]
            nodal |= {name: joined([one[name] for one in rubbed]) for name in FRICTION if name in self.fields}
        cellwise = {}
        kept: list[Sequence[np.ndarray] | None] = [None] * len(self._celled)
        if self._stateful:
            kept = [state.points() for state in self._with_cells]
        if self.stress:
            moved = [snapshot.moved[number] for number in self._celled]
            parts = zip(self.stress, moved, kept, strict=True)
            cellwise["von_mises"] = joined([of(part, state) for of, part, state in parts])
        if self.whole_stress:
            shapes = [snapshot.displacements[number] for number in self._celled]
            own = zip(self.whole_stress, shapes, kept, strict=True)
            cellwise["pressure"] = joined([pressure_of(of(part[None], state)[0]) for of, part, state in own])
        for name in METAL:
            if name in self.fields:
                values = zip(self._with_cells, kept, strict=True)
                cellwise[name] = joined([metal_field(state.plan.body, name, one) for state, one in values])
        try:
            self._append(time, nodal, cellwise)
        except OSError as error:
            raise self._unwritten_frame(error) from error

    def _append(
        self, time: float, nodal: Mapping[str, np.ndarray | LateField], cellwise: Mapping[str, np.ndarray]
    ) -> None:
        """Append a frame to the file, or hand it to the process that writes."""
        if isinstance(self.file, ResultFile) and self.process is not None and self.process.ready():
            self.process.take_over(self.file, self.folder / FILE, self.attributes)
            self.file = self.process
        if isinstance(self.file, FrameProcess):
            self.file.append(time, nodal, cellwise)
        else:
            self.file.append(time, {name: whole(field) for name, field in nodal.items()}, cellwise)

    def settle(self) -> None:
        """Wait until every frame is in the file. Raises `OutputError`."""
        if isinstance(self.file, FrameProcess):
            try:
                self.file.wait()
            except OSError as error:
                raise self._unwritten_frame(error) from error

    def close(self, history: dict[str, np.ndarray], attributes: dict[str, Any]) -> None:
        """Store the history and the scalars of the run, and close the file. Raises `OutputError`."""
        self._close(self.file, history, attributes)

    def _close(
        self, file: ResultFile | FrameProcess, history: dict[str, np.ndarray], attributes: dict[str, Any]
    ) -> None:
        try:
            there = describe(self.obstacles, sorted(set(self.times)), history)
        except FunctionError:  # at a time at which the run did not evaluate it: without the motion
            there = self.attributes["obstacles"]
        try:
            file.write_history(history)
            file.write_attributes(self.attributes | {"obstacles": there} | attributes)
            file.close()
        except OSError as error:
            raise unwritten(self.folder, "the history", "all frames are", error) from error

    def abandon(self) -> None:
        """Close the file as it is on disk; what a full disk does not take is lost, and the run tells that by itself."""
        with suppress(OSError):
            self.file.close()

    def _unwritten_frame(self, error: OSError) -> OutputError:
        """Return the error for the first frame that is not in the file, and forget it and those after it."""
        kept = self.file.kept
        lost = self.times[kept + 1 :]
        del self.times[kept + 1 :]
        what = f"the frame at t = {lost[0]:.6g} s" if lost else "what follows the last frame"
        return unwritten(self.folder, what, f"the {kept} frames before it are", error)


def unwritten(folder: Path, what: str, kept: str, error: OSError) -> OutputError:
    """Return the error for a file that cannot be written."""
    if not (folder / FILE).exists():
        where = "the folder" if not folder.is_dir() else "the file"
        text = f"{what} cannot be written: {where} was removed or renamed while the run went on; run again"
        return OutputError(f"{folder / FILE}: {text}")
    go_on = f"then `tcontact resume {folder}`" if goes_on(folder) else "run again"
    return OutputError(f"{folder / FILE}: {what} cannot be written ({error.strerror}); {kept} kept; make room, {go_on}")
