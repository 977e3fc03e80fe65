"""Frames of a run on several ranks: each writes those of its part, and the first one the file that shows all parts.

A frame counts once every rank has it on disk. A run that goes on with as many ranks goes on with their parts.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..device.team import Team
from ..results.files.late_fields import LateField, whole
from ..results.files.master_file import MasterFile, PartSize
from ..results.files.part_file import PartFile, PartMesh, holds
from ..results.files.part_places import FOLDER, part_path
from ..results.files.vtkhdf import ResultData
from ..results.files.vtkhdf_reader import glance
from ..scene.scene import Scene
from ..schemes.explicit.body_view import BodyView
from .part_mesh import RankMesh
from .rank_files import on_all, on_first
from .recorder import FILE, Recorder, unwritten
from .snapshot import Snapshot


class PartRecorder(Recorder):
    """The recorder of a rank: as `Recorder`, of what this rank has of the bodies; the first rank has the master too."""

    file: PartFile
    master: MasterFile | None = None
    _mesh: PartMesh

    def __init__(self, team: Team, mesh: RankMesh, folder: Path, *given: Any) -> None:
        """Open the part; use `started` instead."""
        self.team, self._mesh, self._order, self._here = team, mesh.mesh, mesh.order, mesh.numbers
        self._path = part_path(folder / FILE, team.rank)
        super().__init__(folder, *given)

    @classmethod
    def started(
        cls,
        team: Team,
        mesh: RankMesh,
        folder: Path,
        scene: Scene,
        views: list[BodyView],
        title: str,
        fields: Sequence[str],
        frames: int | None = None,
    ) -> PartRecorder:
        """Open the parts of all ranks, which call it, and the file that shows them.

        mesh: what this rank has of the bodies; views: values of these. Raises `InputError` on all ranks.
        """

        def begin() -> list[float]:
            if frames is None:
                shutil.rmtree(folder / FOLDER, ignore_errors=True)
                return []
            return [float(time) for time in glance(folder / FILE)[0][:frames]]

        times, error = on_first(team, begin), None
        try:
            found = cls(team, mesh, folder, scene, views, title, fields, frames)
        except InputError as own:
            error = own
        team.agree(error)
        found._show(times)
        return found

    @property
    def _numbers(self) -> Sequence[int]:
        return self._here

    def _opened(self, frames: int | None) -> PartFile:
        about = {"title": self.attributes["title"], "rank": self.team.rank}
        if frames is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            return PartFile.start(self._path, self._mesh, about, self._static)
        return PartFile.reopen(self._path, frames, about)

    def _show(self, times: list[float]) -> None:
        """Start the file that shows the parts of all ranks, which have frames of these times [s] already."""
        mesh, comm = self._mesh, self.team.comm
        del self._mesh  # the files have it
        cells = sum(len(rows) for _, rows in mesh.blocks)
        sizes = comm.gather(PartSize(len(mesh.points), mesh.place.owned, cells, mesh.corners))
        checks = comm.gather(self.file.checks)
        self.times += times
        error: InputError | None = None
        if self.team.leads:
            frames = list(zip(times, np.stack(checks, axis=1), strict=True))
            static, given = list(self._static), (frames, self.file.fields)
            try:
                self.master = MasterFile.start(self.folder / FILE, sizes, self.attributes, static, *given)
            except OSError as found:
                error = self._refusal(found)
        self.team.agree(error)

    def prepare(self) -> None:
        """Prepare for the fields of the frames, before the first one."""
        super().prepare()
        for state in self.states:
            state.plan.body.mesh.release()

    def frame(self, time: float, snapshot: Snapshot) -> None:
        """Append the state at `time` [s]. Raises `OutputError` on all ranks."""
        on_all(self.team, lambda: super(PartRecorder, self).frame(time, snapshot))
        checks = self.team.comm.gather(self.file.check)
        on_all(self.team, lambda: self._count(time, checks))

    def _append(
        self, time: float, nodal: Mapping[str, np.ndarray | LateField], cellwise: Mapping[str, np.ndarray]
    ) -> None:
        self.file.append(time, {name: whole(field)[self._order] for name, field in nodal.items()}, cellwise)

    def _count(self, time: float, checks: Sequence[int]) -> None:
        if self.master is not None:
            try:
                self.master.add(time, np.array(checks), self.file.fields)
            except OSError as error:
                what = f"the frame at t = {time:.6g} s"
                raise unwritten(self.folder, what, "the frames before it are", error) from error

    def close(self, history: dict[str, np.ndarray], attributes: dict[str, Any]) -> None:
        """Store the history and the scalars of the run, and close the files. Raises `OutputError` on all ranks."""
        on_all(self.team, self._close_part)
        on_all(self.team, lambda: None if self.master is None else self._close(self.master, history, attributes))

    def _close_part(self) -> None:
        try:
            self.file.close()
        except OSError as error:
            raise unwritten(self.folder, self._path.name, "all frames are", error) from error

    def abandon(self) -> None:
        """Close the files as they are on disk."""
        super().abandon()
        if self.master is not None:
            with suppress(OSError):
                self.master.close()


def goes_on_with_parts(team: Team, folder: Path, rank_mesh: RankMesh) -> bool:
    """Return whether the frames in a folder are parts of as many ranks, with the same cells each."""
    found = False
    count = on_first(team, lambda: glance(folder / FILE)[1])
    if count == team.size:
        with suppress(InputError):
            found = holds(ResultData.open(part_path(folder / FILE, team.rank)), rank_mesh.mesh)
    return not team.any(not found)
