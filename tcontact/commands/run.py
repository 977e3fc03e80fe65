"""`tcontact run CASE`: it runs a case, checks it, and leaves numbers, result file and pictures in a folder."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tcontact import cases

from ..base import stages
from ..base.errors import InputError
from ..device import ranks
from ..results import frame_fields, report
from ..results.acting_force import largest_energy_error
from ..results.result import Result
from ..run.checkpoint import store
from ..run.folder_lock import made_and_locked
from ..run.history import MOST_ROWS
from ..show import plots
from . import curves, folder, options, origins, report_page, same_scene, settings, words
from .no_room import kept_all_the_same, remedy_of_comparison, remedy_of_run
from .run_own import run_own
from .run_scene import is_scene, run_scene
from .together import on_first_rank


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "run",
        help="run a case",
        description="Run a case; leave summary.json, history.csv, result.vtkhdf, plots and frames in a folder.",
    )
    parser.add_argument("case", metavar="CASE", help="name of a case (tcontact list), or a scene.toml")
    keys = "set a parameter of the case (tcontact list -v) or of the scheme: cfl, dt, scheme; repeatable"
    options.add(parser, "--set", help=keys)
    options.add(parser, "--out", help="folder to write into (default: runs/CASE)")
    parser.add_argument("--frames", metavar="N", type=words.count, help="pictures over the run, 0 = none (default: 60)")
    parser.add_argument(
        "--fields",
        metavar="A,B",
        type=words.names,
        help="fields in the frames, with the displacement ('all': also those that cost more during the run)",
    )
    between = "wall time between checkpoints for `tcontact resume`, 0 = none (default: 60)"
    options.add(parser, "--checkpoint", help=between)
    options.add(parser, "--arch", "--precision", "--threads", "--quiet", "--force", "--import")
    parser.add_argument("--open", action="store_true", help="show the run as a web page when it has ended")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the case and return the exit code."""
    arguments.quiet = arguments.quiet or not ranks.is_first_rank()
    arguments.out = arguments.out or Path("runs") / (
        Path(arguments.case).stem if is_scene(arguments.case) else arguments.case
    )
    code = run_scene(arguments, _start, finish) if is_scene(arguments.case) else _run_case(arguments)
    if arguments.open and ranks.is_first_rank():
        report_page.show(report_page.page_of(arguments.out))
    return code


def _run_case(arguments: argparse.Namespace) -> int:
    """Run a case and return the exit code."""
    arguments.frames = 60 if arguments.frames is None else arguments.frames
    arguments.arch, arguments.precision = arguments.arch or "cpu", arguments.precision or "f64"
    case = cases.load(arguments.case)
    wanted = settings.read(arguments.case, case, arguments.set)
    out = arguments.out
    if not hasattr(case, "scene"):
        if arguments.open:
            raise InputError("--open", arguments.case, "is no mechanical scene, which the page shows; leave it away")
        ranks.check_single(f"the case {arguments.case}")
        return run_own(case, settings.defaults(case) | wanted.scene, out, arguments, show)
    scheme = settings.scheme(wanted.scheme, case)
    parameters = settings.defaults(case) | wanted.scene
    if wanted.compare:
        scenes = settings.built(case.comparison, wanted.scene)
        places = {label: out / re.sub(r"[^a-z0-9]+", "-", label.lower()).strip("-") for label in scenes}
    else:
        scenes = {"": settings.built(case.scene, wanted.scene)}
        places = {"": out}
    with on_first_rank(lambda: folder.replacing(out, arguments.force)):
        runs: dict[str, tuple[bool, Result]] = {}
        for label, chosen in scenes.items():
            scene, own = chosen if isinstance(chosen, tuple) else (chosen, scheme)
            title = f"{arguments.case} {label}".strip()
            known = parameters | wanted.scheme
            go, origin = _start(arguments, scene, own, places[label], label)
            runs[label] = finish(go, title, case, known, places[label], arguments, origin)
            if runs[label][1].reason == "interrupted":
                break
        if wanted.compare and ranks.is_first_rank():
            with kept_all_the_same(out, lambda: remedy_of_comparison(out)):
                _compare(arguments, case, parameters | wanted.scheme, runs, places, out)
    return 0 if all(passed for passed, _ in runs.values()) else 1


def _start(
    arguments: argparse.Namespace, scene: Any, scheme: Any, out: Path, label: str
) -> tuple[Callable[[], Result], dict[str, Any]]:
    """Return the function that runs one scene from its start, and the origin of the run."""
    import tcontact as tc

    count = ranks.launched()[0]
    if not arguments.quiet:
        several = f"; {count} ranks" if count > 1 else ""
        print(f"{arguments.case}: {_size(scene, arguments)}{several}", flush=True)
    origin = {"case": arguments.case, "set": arguments.set, "label": label}
    if hasattr(arguments, "scene"):
        origin |= {"scene": arguments.scene} | origins.relative(arguments.case, out)
    checkpoint = tc.Checkpoint(arguments.checkpoint, origin=origin, keep=True) if arguments.checkpoint else None

    def go() -> Result:
        return tc.simulate(
            scene,
            scheme=scheme,
            out=out,
            frames=arguments.frames,
            threads=arguments.threads,
            arch=arguments.arch,
            precision=arguments.precision,
            progress=not arguments.quiet,
            pressures=True,
            history_every=getattr(arguments, "history_every", 1),
            history_rows=getattr(arguments, "history_rows", MOST_ROWS),
            checkpoint=checkpoint,
            fields=arguments.fields,
        )

    return go, origin


def finish(
    go: Callable[[], Result],
    title: str,
    case: Any,
    parameters: dict[str, Any],
    out: Path,
    arguments: argparse.Namespace,
    origin: dict[str, Any],
) -> tuple[bool, Result]:
    """Run one scene, write all about it into `out`, print its table; return whether all is well, and the result.

    go: starts the run or goes on with it; arguments: its set, quiet and frames are used. The checkpoints of a run that
    has ended go when the pictures are there: until then `tcontact resume` draws them, and no other run is let in.
    """
    with on_first_rank(lambda: made_and_locked(out)):
        result = go()
        if not ranks.is_first_rank():
            return True, result
        checks = case.checks(result)
        data = report.summary(result, case=title, parameters=parameters, checks=checks) | {"origin": origin}
        if ranks.launched()[0] > 1:
            data["ranks"] = ranks.launched()[0]
        with kept_all_the_same(out, lambda: remedy_of_run(out, origin, bool(arguments.frames))):
            report.write_json(out / "summary.json", data | same_scene.kept(result.scene, result.scheme))
            caption = curves.caption_of(title, arguments.set)
            scene = result.scene
            curves.draw(out, result, case, curves.normals_of(scene), caption, curves.size_of(scene))
            if arguments.frames:
                from ..results.files.vtkhdf import ResultData
                from ..show.render import render_frames
                from ..show.render.series import command_field

                stored = ResultData.open(out / "result.vtkhdf")
                render_frames(stored, out, field=command_field(stored), title=caption)
        if result.reason != "interrupted":
            store.remove(out)
        if not arguments.quiet:
            show(report.lines(data))
            print(f"  files in {out}")
        elif not data["passed"]:
            show([line for line in report.lines(data) if "FAIL" in line or not result.ok])
        return data["passed"], result


def _size(scene: Any, arguments: argparse.Namespace) -> str:
    """Return the line on what the frames will take on the disk; without any, on what is computed."""
    if not arguments.frames:
        cells = sum(body.mesh.cell_count for body in scene.bodies)
        return f"{cells} cells, {sum(body.mesh.node_count for body in scene.bodies)} nodes, no frames"
    fields = frame_fields.chosen(scene, arguments.fields)
    size = frame_fields.size(scene, arguments.frames, fields) / 1e6
    return f"{arguments.frames} frames of {', '.join(fields)} take {size:.3g} MB"


def _compare(
    arguments: argparse.Namespace,
    case: Any,
    parameters: dict[str, Any],
    runs: dict[str, Any],
    places: dict[str, Path],
    out: Path,
) -> None:
    """Name the runs of a comparison in a summary, by which `render` draws them too, and plot them side by side."""
    picture = out / "comparison.png"
    normals = curves.normals_of(next(iter(runs.values()))[1].scene)
    figures = {
        label: {
            "reason": result.reason,
            "time": result.time,
            "steps": result.steps,
            "energy_end": float(result.history["energy"][-1] / max(result.history["energy"][0], 1e-300)),
            "force_changes": plots.unrest(plots.force_component(result.history, normals)),
            "energy_error_max": largest_energy_error(result.history, result.peaks),
            **report.smoothness_of(result),
        }
        for label, (_, result) in runs.items()
    }
    report.write_json(
        out / "summary.json",
        {
            "case": arguments.case,
            "parameters": parameters,
            "runs": [places[label].name for label in runs],
            "labels": list(runs),
            "figures": figures,
            "passed": len(runs) == len(places) and all(passed for passed, _ in runs.values()),
            "versions": report.versions(),
        },
    )
    if len(runs) == len(places):
        curves.draw_comparison(picture, case, {label: result for label, (_, result) in runs.items()}, normals)
    if not arguments.quiet and picture.exists():
        print(f"  side by side in {picture}")


def show(lines: list[str]) -> None:
    """Print lines; pass and FAIL in colour on a terminal."""
    import sys

    stages.say("")
    if not sys.stdout.isatty():
        print("\n".join(lines))
        return
    from rich.console import Console
    from rich.text import Text

    console = Console(soft_wrap=True, highlight=False)
    for line in lines:
        text = Text(line)
        text.highlight_regex(r"^  pass\b", "green")
        text.highlight_regex(r"^  FAIL\b", "bold red")
        console.print(text)
