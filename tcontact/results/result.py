"""The result of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ..base.errors import InputError, hint
from ..device.ending import ending_all
from ..device.team import Team, team
from ..friction_layer import LayerState
from ..scene.scene import Scene
from .acting_force import largest_energy_error
from .outcome import Outcome
from .pair_memory import PairMemory
from .smoothness import PressureRecord

# fields with values of nodes and cells, which of several ranks the first one alone has (elsewhere.py)
ON_FIRST = ("position", "velocity", "contact_node_force", "layers", "metals", "points", "pairs")


@dataclass(frozen=True)
class Maximum:
    """The largest value of a quantity in a run: its time [s], the name of the body and the number of the cell in it."""

    value: float
    time: float
    body: str
    cell: int


@dataclass(frozen=True, eq=False)
class Result(Outcome):
    """Result of a run: its end, how it went, and its history.

    ok: the run reached its end; reason: finished | diverged | inverted-cell | not-converged | bodies-meet |
    missed-contact | interrupted | function-failed (a function of time that the scene holds) | not-written (only in
    `OutputError.result`); message: what happened and what to try; steps: how many were taken; time [s]: of the end; dt
    [s]: the first step; dt_limit [s]: the stable step of the start; wall_s, compile_s [s]: time of the steps without
    writing frames, and of everything before (planning, compiling, the first step); cell_updates_per_s: cells times
    steps over wall_s; memory: bytes by term; terms: names of the physics built; position, velocity, contact_node_force
    [n, 3] [m, m/s, N]: in the user's numbering, bodies stacked in order; history: dict of arrays, one row per step (row
    0 = start), columns as in docs/COLUMNS.md; warnings: texts of all warnings; scene, scheme: what was run;
    contact_pressures: contact force over area of the contact nodes at every row of the history, a record per body that
    can touch, if `simulate` was asked for `pressures`; layers: the friction layers of every body at the end, None for
    one without (`friction_layer.LayerState`); metals: with metals "plastic_strain" and "temperature" [K] of every cell
    at the end, in the user's numbering, bodies stacked in order, NaN in cells of other materials; points: where a law
    keeps a state, of every body the numbers of each of its blocks [cells, points, numbers], and pairs: where bodies are
    in contact with each other, what that remembers (`PairMemory`): with both `simulate(initial=)` goes on; maxima: by
    the names in `Scene.maxima` the largest value of all cells and all steps, also those that the history does not keep;
    peaks: by column the largest energy_error, and the largest length [N] of contact_force and of the force of each
    obstacle and pair that has a column, of all steps alike;
    precision: "f64" or "mixed", as `simulate` was asked for; file: the
    result file, if `simulate` was asked for `out`. `tcontact.open_result` reads such a run back.
    Of several ranks that share a run the first one has all this; on the others what belongs to nodes and cells
    (position, velocity, contact_node_force, layers, metals, points, pairs) raises `InputError`, see `on_all_ranks`.
    """

    ok: bool
    reason: str
    message: str
    steps: int
    time: float
    dt: float
    dt_limit: float
    wall_s: float
    compile_s: float
    cell_updates_per_s: float
    memory: dict[str, int]
    terms: tuple[str, ...]
    position: np.ndarray
    velocity: np.ndarray
    contact_node_force: np.ndarray
    history: dict[str, np.ndarray]
    scene: Scene
    warnings: list[str] = field(default_factory=list)
    contact_pressures: tuple[PressureRecord, ...] = ()
    scheme: Any = None
    layers: tuple[LayerState | None, ...] = ()
    metals: dict[str, np.ndarray] = field(default_factory=dict)
    points: tuple[tuple[np.ndarray, ...], ...] = ()
    pairs: PairMemory | None = None
    maxima: dict[str, Maximum] = field(default_factory=dict)
    peaks: dict[str, float] = field(default_factory=dict)
    precision: str = "f64"
    file: Path | None = None

    whole: ClassVar[bool] = True  # has the values of nodes and cells, unlike results of other ranks (elsewhere.py)
    notebook: ClassVar[Any]  # shows a result in a notebook; pictures stand above results, so the package sets it

    def nodes_of(self, name: str) -> slice:
        """Return the rows of a body in position, velocity and contact_node_force; `InputError` for an unknown name."""
        start = 0
        known = []
        for index, body in enumerate(self.scene.bodies):
            known.append(self.scene.label(index))
            if known[-1] == name:
                return slice(start, start + body.mesh.node_count)
            start += body.mesh.node_count
        raise InputError("name", name, hint(name, known) + "use one of " + ", ".join(map(repr, known)))

    @property
    def frames(self) -> Any:
        """The stored frames, read when asked for: times [s], frame(index), points, point_fields, cell_fields
        (`ResultData`).

        A run without `out`, or with frames=0, has one frame, its end.
        """
        if self.file is not None:
            from .files.vtkhdf import ResultData

            data = ResultData.open(self.file)
            if len(data):
                return data
        return self.views.end_of(self)

    def on_all_ranks(self, comm: Any = None) -> Result:
        """Return the result with the values of nodes and cells on every rank; all ranks of its run call it.

        A run that processes share under mpiexec leaves position, velocity, contact_node_force, layers, metals and
        points on the first rank; the result of one process is returned as it is. comm: communicator of the run, as in
        `simulate`. Raises `InputError` where these ranks have not shared one run, and if a rank does something else.
        """
        together = team(comm, "shares a result")
        with ending_all(together):
            whole = [True] if together is None else together.comm.allgather(self.whole)
            if together is None or all(whole):
                return self
            if not whole[0] or any(whole[1:]):
                raise InputError("comm", comm, "these ranks have not shared one run; give the communicator that it had")
            return self.shared_by(together)

    def shared_by(self, together: Team) -> Result:
        """Return the result with the values of nodes and cells that the first of some ranks has, on all of them."""
        values: dict[str, Any] = {}
        error: InputError | None = None
        try:
            values = {name: getattr(self, name) for name in ON_FIRST} if together.leads else {}
        except InputError as found:
            error = found
        together.agree(error)
        values = together.from_first(values)
        return self if together.leads else self.with_values(values)

    def with_values(self, values: Mapping[str, Any]) -> Result:
        """Return the result with these values of nodes and cells."""
        return replace(self, **values)

    def reversed(self) -> Result:
        """Return the same state with all velocities negated: given as `initial`, it runs backwards in time."""
        return replace(self, velocity=-self.velocity)

    def _repr_html_(self) -> str:
        """Return how it went as a table, and a picture of the end, for a notebook."""
        return str(self.notebook.html(self))

    def _repr_png_(self) -> bytes:
        """Return a picture of the end, coloured by the von Mises stress, for a notebook."""
        return bytes(self.notebook.picture(self))

    def __repr__(self) -> str:
        rows = len(self.history.get("energy_error", ()))
        error = largest_energy_error(self.history, self.peaks) if rows else float("nan")
        return (
            f"Result({self.reason}, {self.steps} steps to {self.time:.6g} s, dt {self.dt:.3g} s,"
            f" energy error {error:.2g}, {self.wall_s:.3g} s)"
        )
