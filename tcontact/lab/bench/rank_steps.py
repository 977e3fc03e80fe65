"""CPU seconds of a step on several ranks, beside one rank with as many cells as each of them has.

    python -m tcontact.lab.bench.rank_steps SIZE CELLS_UP CONTACT [CONTACT_RANKS]        alone or under mpiexec

prints a line of JSON: for every rank its cells, milliseconds of a step, of which in MPI, messages, bytes, peak memory.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from time import process_time
from typing import Any, ClassVar

from ...base.errors import InputError
from ...device import ranks
from ...device.exchange import Exchange, Handover
from ...device.team import Team, team
from ...mesh.box import box_mesh
from ...planning.partition.cut import EXCHANGE, EXCHANGES, EXTRA_WORK, contact_ranks
from ...run.simulation import simulate
from ...scene.body import Body
from ...scene.contact_models import MasslessContact
from ...scene.materials import NeoHookean
from ...scene.obstacles import Plane
from ...scene.scene import Scene
from ...schemes.explicit.central_difference import CentralDifference

STEPS, FIRST = 200, 40  # steps of a run, and the first ones that are not counted
LENGTH, SPEED = 0.1, 10.0 / 3.6
LATENCY, BANDWIDTH = 1.5e-6, 12e9 / 16  # [s], [byte/s] of the model: a message, a rank of 16 on a machine
EXTRA = {"none": 0.0} | EXTRA_WORK


@dataclass(frozen=True)
class Timed(CentralDifference):
    """The scheme with a note of the CPU time before every launch, and of the rows done by then."""

    notes: ClassVar[list[tuple[int, float, float]]] = []
    rows: ClassVar[list[int]] = [0]

    def step(self, *given: Any, **stop_at: Any) -> int:
        """Step as the scheme does."""
        self.notes.append((self.rows[0], process_time(), waited[0]))
        done = super().step(*given, **stop_at)
        self.rows[0] += done
        return done


waited = [0.0]  # CPU seconds in MPI


def _timed(function: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(function)
    def called(*given: Any) -> Any:
        start = process_time()
        found = function(*given)
        waited[0] += process_time() - start
        return found

    return called


def scene(size: int, up: int, contact: str) -> Scene:
    """Return a column of size x size x up cubes above a plane, whose foot is in contact from the start."""
    cell = LENGTH / size
    mesh = box_mesh((LENGTH, LENGTH, up * cell), (size, size, up))
    material = NeoHookean(1e7, 0.3, 1000.0)
    limit = cell / material.wave_speed
    if contact == "none":
        return Scene([Body(mesh, material, velocity=(0.0, 0.0, -SPEED))], [], 0.5 * STEPS * limit)
    body = Body(mesh, material, velocity=(0.0, 0.0, -SPEED), contact="zmin")
    return Scene([body], [Plane()], 0.5 * STEPS * limit, contact=MasslessContact(contact))


def main(size: int, up: int, contact: str, shared: int | None = None) -> None:
    """Run and print what every rank measured; shared: number of ranks with contact, None: chosen."""
    Handover.move = _timed(Handover.move)  # type: ignore[method-assign]
    Exchange.add = _timed(Exchange.add)  # type: ignore[method-assign]
    Team.gathered = _timed(Team.gathered)  # type: ignore[method-assign]
    Team.joined = _timed(Team.joined)  # type: ignore[method-assign]
    Team.from_first = _timed(Team.from_first)  # type: ignore[method-assign]
    limit = LENGTH / size / NeoHookean(1e7, 0.3, 1000.0).wave_speed
    result = simulate(scene(size, up, contact), Timed(dt=0.5 * limit), threads=1, contact_ranks=shared)
    (row, start, waiting), (last, end, late) = (Timed.notes[at] for at in (_after(FIRST), -1))
    own: dict[str, Any] = {"ms": 1e3 * (end - start) / (last - row), "mpi_ms": 1e3 * (late - waiting) / (last - row)}
    own["peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    own |= {"messages": Exchange.all_messages / result.steps, "bytes": Exchange.all_bytes / result.steps}
    together = team()
    everyone = [own] if together is None else together.comm.gather(own)
    if ranks.is_first_rank():
        print(json.dumps({"steps": result.steps, "energy_error": float(result.history["energy_error"].max()),
                          "ranks": everyone}))  # fmt: skip


def _after(rows: int) -> int:
    return next(at for at, note in enumerate(Timed.notes) if note[0] >= rows)


def compare(counts: Sequence[int], size: int, contact: str, say: Callable[[str], None]) -> list[dict[str, Any]]:
    """Return a row for each number of ranks: the cube of size^3 cells on them, and one rank with a part of the cells.

    Raises `InputError` if several ranks are asked for and there is no mpiexec.
    """
    launcher = shutil.which("mpiexec") or shutil.which("mpiexec", path=str(Path(sys.executable).parent))
    if max(counts) > 1 and launcher is None:
        raise InputError("--ranks", list(counts), "there is no mpiexec: pip install 'tcontact[mpi]' mpich")
    rows = []
    for count in counts:
        up = max(1, round(size / count))
        say(f"{size}^3 cells on {count} ranks, contact {contact}")
        found = _answer([] if count == 1 else [str(launcher), "-n", str(count)], size, size, contact)
        say(f"{size}^2 x {up} cells on one rank")
        part = _answer([], size, up, contact)
        row = {"ranks": count, "size": size, "contact": contact, "cells": size**3, "part": size * size * up}
        if "failed" in found or "failed" in part:
            rows.append(row | {"ok": False, "reason": found.get("failed") or part.get("failed")})
            continue
        busy = [one["ms"] - one["mpi_ms"] for one in found["ranks"]]
        alone = part["ranks"][0]
        row |= {"ok": True, "ms": max(busy), "mpi_ms": max(one["mpi_ms"] for one in found["ranks"])}
        row |= {"alone_ms": alone["ms"], "ratio": max(busy) / alone["ms"]}
        row |= {"messages": max(one["messages"] for one in found["ranks"])}
        row |= {"bytes": max(one["bytes"] for one in found["ranks"])}
        row |= {"peak_mb": max(one["peak_mb"] for one in found["ranks"]), "energy_error": found["energy_error"]}
        rows.append(row)
    return rows


def _answer(launcher: list[str], size: int, up: int, contact: str) -> dict[str, Any]:
    words = [sys.executable, "-W", "ignore", "-m", "tcontact.lab.bench.rank_steps", str(size), str(up), contact]
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    root = str(Path(__file__).resolve().parents[3])
    environment["PYTHONPATH"] = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run([*launcher, *words], env=environment, capture_output=True, text=True, check=False)
    try:
        return dict(json.loads(done.stdout.splitlines()[-1]))
    except (IndexError, ValueError):
        return {"failed": f"exit code {done.returncode}: {(done.stderr.strip().splitlines() or [''])[-1]}"}


def model(row: dict[str, Any], counts: Sequence[int] = (1, 2, 8, 64, 512)) -> list[dict[str, float]]:
    """Return efficiencies of a cube on more ranks by the model of docs/SCALING.md; row: measured, of one rank.

    A rank with contact has the larger work of its contact cells and an equal share of all; ranks that share the contact
    exchange increments.
    """
    work, found = EXTRA[row["contact"]], []
    face = 0 if row["contact"] == "none" else row["size"] ** 2
    for cells in (64**3, 128**3, 256**3):
        contact = cells ** (2 / 3) if face else 0.0
        total = cells + work * contact
        unit = 1e-3 * row["ms"] / (row["cells"] + work * face)
        for count in counts:
            sharing = 1
            if contact:
                sharing = contact_ranks(cells, round(contact), round(contact), count, row["contact"], cells)
            share = max(total / count, (1.0 + work) * contact / sharing)
            nodes = 0.0 if count == 1 else 6.0 * (cells / count) ** (2 / 3)
            wire = 0.0 if count == 1 else 26 * LATENCY + 24.0 * nodes / BANDWIDTH + 2 * LATENCY * count.bit_length()
            wire += EXCHANGE * EXCHANGES[row["contact"]] if sharing > 1 else 0.0
            found.append({"cells": cells, "ranks": count, "efficiency": total * unit / count / (share * unit + wire)})
    return found


def lines(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return a table of the rows, and of the model if a row of one rank was measured."""
    found = ["ranks      cells    ms/step   in MPI    alone   ratio  messages   kB/step   peak MB   energy error"]
    for row in rows:
        if not row["ok"]:
            found.append(f"{row['ranks']:5d} {row['cells']:10d}  {row['reason']}")
            continue
        text = f"{row['ranks']:5d} {row['cells']:10d} {row['ms']:10.3f} {row['mpi_ms']:8.3f} {row['alone_ms']:8.3f}"
        text += f" {row['ratio']:7.2f} {row['messages']:9.1f} {row['bytes'] / 1e3:9.2f} {row['peak_mb']:9.0f}"
        found.append(f"{text} {row['energy_error']:14.1e}")
    found.append("ms/step: CPU of the busiest rank without MPI; alone: one rank with one part of the cells")
    first = next((row for row in rows if row["ok"] and row["ranks"] == 1), None)
    if first is not None:
        found.append("a model, not measured (docs/SCALING.md): efficiency of cubes on more ranks")
        for cells in (64**3, 128**3, 256**3):
            ones = [one for one in model(first) if one["cells"] == cells]
            found.append(f"{round(cells ** (1 / 3)):5d}^3  " + "  ".join(
                f"{one['ranks']:.0f}: {one['efficiency']:.2f}" for one in ones))  # fmt: skip
    return found


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], int(sys.argv[4]) if len(sys.argv) > 4 else None)
