"""Display in a notebook: a result as a table and a picture of its end, scenes and meshes as pictures of their start."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..cells.stress import VonMises
from ..device import runtime
from ..mesh.mesh import Mesh
from ..results.acting_force import acting_force, largest_energy_error
from ..results.files.vtkhdf import Frame
from ..results.report import si
from ..results.result import Result
from ..scene.obstacles.description import describe

if TYPE_CHECKING:
    from PIL import Image

SIZE = (640, 480)


@dataclass(frozen=True)
class EndState:
    """The end of a run as a series of one frame: it has in memory what pictures need of `vtkhdf.ResultData`."""

    result: Result
    path: Path = Path("result")
    point_fields: tuple[str, ...] = ("displacement", "velocity", "contact_force")

    def __len__(self) -> int:
        return 1

    @cached_property
    def points(self) -> np.ndarray:
        """Reference positions [n, 3] [m] of all bodies."""
        return np.concatenate([body.mesh.nodes for body in self.result.scene.bodies])

    @cached_property
    def blocks(self) -> tuple[tuple[str, np.ndarray], ...]:
        """Kinds and connectivities [m, k] of the bodies."""
        return stacked_blocks([body.mesh for body in self.result.scene.bodies])

    @property
    def times(self) -> np.ndarray:
        """The end [s]."""
        return np.array([self.result.time])

    @property
    def cell_fields(self) -> tuple[str, ...]:
        """Names of the cell fields."""
        return ("von_mises", "body") if len(self.result.scene.bodies) > 1 else ("von_mises",)

    @cached_property
    def attributes(self) -> dict[str, Any]:
        """Title, names of the bodies, reason of the end, and obstacles, where they are then."""
        title, scene = " + ".join(self.result.terms), self.result.scene
        names = [scene.label(number) for number in range(len(scene.bodies))]
        return {
            "title": title,
            "obstacles": describe(scene.obstacles, [0.0, self.result.time], self.result.history),
            "bodies": names,
            "reason": self.result.reason,
        }

    def frame(self, _index: int) -> Frame:
        """Return the only frame."""
        return self._frame

    @cached_property
    def _frame(self) -> Frame:
        result, bodies = self.result, self.result.scene.bodies
        moved = result.position - self.points
        parts = np.split(moved, np.cumsum([body.mesh.node_count for body in bodies])[:-1])
        with runtime.turn:
            runtime.start(runtime.arch())  # the result may have come from another process
            states = result.points or [None] * len(bodies)
            triples = zip(bodies, parts, states, strict=True)
            stress = [VonMises(body)(part, points) for body, part, points in triples]
        cells = {"von_mises": np.concatenate(stress)}
        if len(bodies) > 1:
            cells["body"] = np.concatenate([np.full(body.mesh.cell_count, i) for i, body in enumerate(bodies)])
        nodal = {"displacement": moved, "velocity": result.velocity, "contact_force": result.contact_node_force}
        return Frame(result.time, nodal, cells)


@dataclass(frozen=True)
class StartState:
    """Meshes with their names, and obstacles, as a series of one frame at rest: what pictures need of `ResultData`."""

    meshes: Sequence[Mesh]
    names: Sequence[str]
    obstacles: Sequence[Any]
    path: Path = Path("start")
    point_fields: tuple[str, ...] = ()
    cell_fields: tuple[str, ...] = ("body",)

    def __len__(self) -> int:
        return 1

    @cached_property
    def points(self) -> np.ndarray:
        """Positions [n, 3] [m] of all nodes."""
        return np.concatenate([mesh.nodes for mesh in self.meshes])

    @cached_property
    def blocks(self) -> tuple[tuple[str, np.ndarray], ...]:
        """Kinds and connectivities [m, k] of the meshes."""
        return stacked_blocks(self.meshes)

    @property
    def times(self) -> np.ndarray:
        """The start [s]."""
        return np.zeros(1)

    @property
    def attributes(self) -> dict[str, Any]:
        """Names of the bodies, and obstacles."""
        return {"title": "", "obstacles": self.obstacles, "bodies": list(self.names)}

    def frame(self, _index: int) -> Frame:
        """Return the only frame."""
        numbers = [np.full(mesh.cell_count, index) for index, mesh in enumerate(self.meshes)]
        return Frame(0.0, {}, {"body": np.concatenate(numbers)})


def stacked_blocks(meshes: Sequence[Mesh]) -> tuple[tuple[str, np.ndarray], ...]:
    """Return kinds and connectivities [m, k] of meshes whose nodes are numbered one mesh after the other."""
    starts = np.cumsum([0, *(mesh.node_count for mesh in meshes)])
    pairs = zip(meshes, starts, strict=False)
    return tuple((kind, cells + start) for mesh, start in pairs for kind, cells in mesh.blocks)


def start_picture(meshes: Sequence[Mesh], names: Sequence[str], obstacles: Sequence[Any]) -> bytes:
    """Return a PNG of meshes, each in a colour with its name, and of obstacles."""
    from .render.studio import Studio

    studio = Studio(StartState(meshes, names, obstacles), SIZE, 1.0, None)  # type: ignore[arg-type]
    return _png(studio.picture(studio.data.frame(0), "body", studio.limits("body"), studio.camera("above")))


def picture(result: Result) -> bytes:
    """Return a PNG of the end of a run."""
    from .render.studio import Studio

    studio = Studio(EndState(result), SIZE, 1.0, None)  # type: ignore[arg-type]
    return _png(studio.picture(studio.data.frame(0), "von_mises", studio.limits("von_mises"), studio.camera("above")))


def _png(image: Image.Image) -> bytes:
    file = io.BytesIO()
    image.save(file, "PNG")
    return file.getvalue()


def rows(result: Result) -> dict[str, str]:
    """Return the rows of the table, by the words on its left."""
    history = result.history
    cells = sum(body.mesh.cell_count for body in result.scene.bodies)
    error = largest_energy_error(history, result.peaks)
    acting = acting_force(history, result.peaks)
    found = {
        "ended": f"{result.reason} at {si(result.time, 's', 4)} after {result.steps} steps",
        "scene": f"{cells} cells, {len(result.position)} nodes: {', '.join(result.terms)}",
        "step": f"{si(result.dt, 's')} (stable below {si(result.dt_limit, 's')})",
        "energy error": f"{error:.2g} at most",
        "contact force": f"{si(acting.largest, 'N')} at most{acting.partner}",
        "smallest gap": si(float(np.nanmin(history["gap_min"])), "m"),
        "time taken": f"{si(result.wall_s, 's')}, compiling {si(result.compile_s, 's')}",
    }
    if not result.scene.touching:
        del found["contact force"], found["smallest gap"]
    if result.message:
        found["remedy" if not result.ok else "note"] = result.message
    return found | ({"warnings": "; ".join(result.warnings)} if result.warnings else {})


def html(result: Result) -> str:
    """Return table and picture beside each other."""
    lines = [
        f'<tr><th style="text-align:left">{escape(name)}</th><td style="text-align:left">{escape(text)}</td></tr>'
        for name, text in rows(result).items()
    ]
    image = base64.b64encode(picture(result)).decode()
    style = "display:flex;flex-wrap:wrap;align-items:center;gap:1em"
    return (
        f'<div style="{style}"><table>{"".join(lines)}</table>'
        f'<img width="{SIZE[0] // 2}" alt="the end of the run" src="data:image/png;base64,{image}"></div>'
    )
