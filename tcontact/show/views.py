"""Curves and pictures that a result gives of itself: `Outcome.plot` and `Outcome.render`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import validate
from ..base.errors import InputError, hint
from ..base.window_backend import import_matplotlib
from ..kernels.columns import COLUMNS
from ..mesh.mesh import Mesh
from ..results.outcome import Outcome
from ..results.result import Result
from ..scene.obstacles.description import describe
from ..scene.scene import Scene
from . import plots
from .notebook import EndState, start_picture
from .texts import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OWN = ("contact_force", "energy", "gap")  # quantities with a plot of their own
OPTIONS = ("camera", "deformation_scale", "obstacles", "range", "view", "title", "colours", "clip")


def end_of(result: Result) -> EndState:
    """Return the end of a run in memory as a series of one frame."""
    return EndState(result)


def plot(result: Outcome, quantity: str, axes: Axes | None) -> Axes:
    """Draw a quantity of the history on axes, None = new ones; return them.

    Raises `InputError` for an unknown quantity and for what is no axes.
    """
    history = result.history
    shown = [name for name in history if name != "time"]
    validate.choice("quantity", quantity, (*OWN, *(name for name in shown if name not in OWN)))
    import_matplotlib()
    if axes is None:
        from matplotlib import pyplot

        _, axes = pyplot.subplots(layout="constrained")
    else:
        from matplotlib.axes import Axes

        _refuse_other(axes, Axes, "give axes of matplotlib, such as matplotlib.pyplot.gca()")
    if quantity == "contact_force":
        frames = result.frames
        plots.draw_force(axes, history, normals_of(frames.attributes), size=length_of(frames.points))
    elif quantity == "energy":
        plots.draw_energies(axes, history)
    elif quantity == "gap":
        plots.draw_gap(axes, history, length_of(result.frames.points))
    else:
        plots.draw_column(axes, history, quantity, unit_of(quantity))
    plots.time_axis(axes, history)
    return axes


def render(
    result: Outcome,
    path: Path | str | None,
    time: float | None,
    field: str | None,
    size: tuple[int, int],
    options: Mapping[str, Any],
) -> np.ndarray:
    """Draw the frame of a result nearest to a time [s], into a file too if one is named; return the picture."""
    from .render.series import drawn_picture, stored_picture, usual_field

    for name in options:
        if name not in OPTIONS:
            remedy = f"render() has no such option; {hint(name, OPTIONS)}use one of {', '.join(OPTIONS)}"
            raise InputError(name, options[name], remedy)
    frames = result.frames
    field = usual_field(frames, "von_mises") if field is None else field
    picture = drawn_picture(frames, time, field, size, **options)
    if path is not None:
        stored_picture(picture, path)
    return np.asarray(picture)


def plot_mesh(mesh: Mesh, sets: tuple[str, ...], axes: Any) -> Any:
    """Draw the boundary of a mesh on axes in three dimensions, None = new ones; return them.

    Raises `InputError` for an unknown set and for what is no such axes.
    """
    import_matplotlib()
    from matplotlib import pyplot
    from matplotlib.patches import Patch
    from mpl_toolkits.mplot3d import Axes3D
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    chosen = {name: mesh.faces_of(name) for name in sets}  # refuses an unknown one before anything is drawn
    if axes is None:
        axes = pyplot.figure(layout="constrained").add_subplot(projection="3d")
    else:
        remedy = 'give axes of matplotlib in three dimensions, such as pyplot.figure().add_subplot(projection="3d")'
        _refuse_other(axes, Axes3D, remedy)
    shown = {"": mesh.boundary_faces(), **chosen}
    colours = ("#c9d4e3", plots.BLUE, plots.ORANGE, plots.GREEN, plots.RED, plots.PURPLE, plots.BROWN)
    for number, faces in enumerate(shown.values()):
        colour, line = colours[number % len(colours)], "#30394566" if number == 0 else "#000000"
        axes.add_collection3d(Poly3DCollection(mesh.nodes[faces], facecolors=colour, edgecolors=line, linewidths=0.3))
    low, high = mesh.bounds
    for axis, start, end in zip("xyz", low, high, strict=True):
        getattr(axes, f"set_{axis}lim")(start, end if end > start else start + 1e-12)
        getattr(axes, f"set_{axis}label")(f"{axis} [m]")
    axes.set_box_aspect(np.maximum(high - low, 1e-3 * mesh.size))
    if sets:
        patches = [Patch(color=colours[1 + k % 6], label=plain(name)) for k, name in enumerate(sets)]
        axes.legend(handles=patches, loc="best")
    return axes


def _refuse_other(axes: Any, kind: type, remedy: str) -> None:
    """Raise `InputError` for what is no axes of this kind."""
    if not isinstance(axes, kind):
        raise InputError("axes", axes, remedy)


def mesh_picture(mesh: Mesh) -> bytes:
    """Return a PNG of a mesh."""
    return start_picture([mesh], ["mesh"], [])


def scene_picture(scene: Scene) -> bytes:
    """Return a PNG of the bodies of a scene where they start, and its obstacles."""
    names = [scene.label(index) for index in range(len(scene.bodies))]
    meshes = [replace(body.mesh, nodes=body.initial_nodes) for body in scene.bodies]
    return start_picture(meshes, names, describe(scene.obstacles, ()))


def normals_of(attributes: Mapping[str, Any]) -> list[np.ndarray]:
    """Return the normals of the obstacles in the attributes of a series, if each is a plane at rest, else none."""
    described = attributes.get("obstacles", ())
    flat = all(one.get("kind") == "plane" and "motion" not in one for one in described)
    return [np.asarray(one["normal"]) for one in described] if flat else []


def length_of(points: np.ndarray) -> float:
    """Return the length [m] of the box around points [n, 3], corner to corner."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def unit_of(name: str) -> str:
    """Return the unit of a column of the history, "" for one that is not in the table of columns."""
    known = {column.name: column.unit for column in COLUMNS}
    return known.get(name.partition(":")[0], "")
