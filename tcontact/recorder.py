"""Writes frames into result.vtkhdf while a run goes on; everything complete survives a stop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .errors import InputError
from .fields import von_mises
from .obstacles.description import describe
from .scene import Scene
from .state import BodyState
from .vtkhdf import ResultFile

FILE = "result.vtkhdf"


def check_folder(out: Any) -> Path:
    """The output folder, checked before anything starts. Raises `InputError` if it cannot take a new result."""
    try:
        folder = Path(out)
    except TypeError as error:
        raise InputError("out", out, "give a folder name or None") from error
    if "\0" in str(folder):
        raise InputError("out", out, "a folder name has no null characters")
    try:
        is_file = folder.exists() and not folder.is_dir()
    except OSError as error:
        raise InputError("out", str(folder), f"no folder can have this name ({error.strerror})") from error
    if is_file:
        raise InputError("out", str(folder), "this is a file; give a folder")
    if (folder / FILE).exists():
        raise InputError(
            "out", str(folder), f"it already holds {FILE} of another run; choose another folder or remove it"
        )
    return folder


def make_folder(folder: Path) -> None:
    """Make the output folder, before time is spent on the run. Raises `InputError` where that is impossible."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("out", str(folder), f"cannot be made ({error.strerror}); name another folder") from error


class Recorder:
    """Frames of a run: displacement, velocity, contact force and pressure of nodes, von Mises stress of cells."""

    def __init__(self, folder: Path, scene: Scene, states: list[BodyState], title: str) -> None:
        self.states = states
        points = np.concatenate([body.mesh.nodes for body in scene.bodies])
        blocks, start = [], 0
        for body in scene.bodies:
            blocks.append((body.mesh.kind, body.mesh.cells + start))
            start += body.mesh.node_count
        bodies = np.concatenate([np.full(body.mesh.cell_count, i) for i, body in enumerate(scene.bodies)])
        self.obstacles, self.times = scene.obstacles, [0.0]
        self.attributes: dict[str, Any] = {"title": title, "obstacles": describe(scene.obstacles)}
        self.file = ResultFile.create(
            folder / FILE,
            points,
            blocks,
            attributes=self.attributes,
            static_cell_data={"body": bodies} if len(scene.bodies) > 1 else None,
        )

    def frame(
        self, time: float, displacements: list[np.ndarray], velocities: list[np.ndarray], forces: list[np.ndarray]
    ) -> None:
        """Append a frame; lists hold one array [n, 3] per body in the user's numbering."""
        self.times.append(float(time))
        force = np.concatenate(forces)
        area = np.concatenate([state.contact_areas() for state in self.states])
        size = np.linalg.norm(force, axis=1)
        pressure = np.where(area > 0.0, size / np.where(area > 0.0, area, 1.0), 0.0)
        stress = [
            von_mises(state.plan.body.mesh, state.plan.body.material, displacement, state.plan.body.formulation)
            for state, displacement in zip(self.states, displacements, strict=True)
        ]
        self.file.append(
            time,
            {
                "displacement": np.concatenate(displacements),
                "velocity": np.concatenate(velocities),
                "contact_force": force,
                "contact_pressure": pressure,
            },
            {"von_mises": np.concatenate(stress)},
        )

    def close(self, history: dict[str, np.ndarray], attributes: dict[str, Any]) -> None:
        """Store the history and the scalars of the run, and close the file."""
        self.file.write_history(history)
        there = describe(self.obstacles, sorted(set(self.times)))
        self.file.write_attributes(self.attributes | {"obstacles": there} | attributes)
        self.file.close()
