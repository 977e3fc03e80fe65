"""`tcontact study CASE`: it measures what accuracy costs, method by method, or runs the hard cases (`hard-cases`).

`tcontact study friction-layer` studies a layer alone, without a mechanical scene.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..base.errors import InputError
from ..device import ranks
from ..friction_layer.study import draw
from ..lab.study import figure, hard_register, hard_table, methods, problems, table
from ..lab.study import layer_study as friction_layer
from ..lab.study.runner import collect
from ..lab.study.setting import Study
from ..results.report import write_json
from . import folder, options, settings, words

HARD, LAYER = "hard-cases", "friction-layer"


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "study",
        help="error against wall time of several methods, or the table of hard cases",
        description="Run methods x sizes x steps on a problem with a reference; leave study.json, study.csv and"
        " study.png in a folder. CASE hard-cases: run the register of hard cases and print its table.",
    )
    parser.add_argument(
        "case", metavar="CASE", help="a problem with a reference, hard-cases or friction-layer; a wrong name lists them"
    )
    parser.add_argument(
        "--methods",
        metavar="A,B",
        type=words.names,
        help="methods, a wrong name lists them (default: the problem's); or hard cases by name",
    )
    parser.add_argument(
        "--sizes", metavar="N,M", type=words.several(words.whole), help="cells (default: the problem's)"
    )
    parser.add_argument(
        "--steps",
        metavar="X,Y",
        type=words.several(words.positive),
        help="steps over the stable one, cfl (default: 0.9; hard cases: own)",
    )
    options.add(parser, "--set", help="set a parameter of the scene; repeatable")
    parser.add_argument(
        "--error", metavar="NAME", help="error that table and figure show (default: the problem's first)"
    )
    parser.add_argument(
        "--budget", metavar="SECONDS", type=words.positive, help="leave out what would not be done in time"
    )
    parser.add_argument("--full", action="store_true", help="hard cases at their full size (minutes)")
    options.add(parser, "--out", help="folder to write into (default: runs/study-CASE)")
    options.add(parser, "--threads", "--force")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the study, write its files, print its table; return 1 if no run succeeded or a hard case came out wrong."""
    ranks.check_single("a study")
    out = arguments.out or Path("runs") / f"study-{arguments.case}"
    work = {HARD: _hard_cases, LAYER: _friction_layer}.get(arguments.case, _study)
    ready = work(arguments)  # bad input is refused here, before any file is touched
    with folder.replacing(out, arguments.force):
        return int(ready(out))


def _study(arguments: argparse.Namespace) -> Any:
    """Check the words; return what runs methods x sizes x steps into a folder and gives the exit code."""
    problem = problems.load(arguments.case)
    if arguments.full:
        raise InputError("--full", True, "is for hard-cases; give --sizes")
    wanted = settings.read(arguments.case, problem, arguments.set)
    if wanted.scheme or wanted.compare:
        raise InputError("--set", next(iter(wanted.scheme), "compare"), "use --steps and --methods NAME@SCHEME")
    study = Study(
        name=arguments.case,
        problem=problem,
        methods=arguments.methods or _methods(problem),
        sizes=arguments.sizes or problem.SIZES,
        cfls=arguments.steps or (0.9,),
        parameters=wanted.scene,
        budget=arguments.budget,
        threads=arguments.threads,
        error=arguments.error,
    )

    def go(out: Path) -> int:
        report = collect(study, lambda text: print(f"  {text}", flush=True))
        write_json(out / "study.json", report)
        table.write_csv(out / "study.csv", report)
        drawn = figure.draw(out / "study.png", report)
        print("", *table.lines(report), sep="\n")
        print(f"\nfiles in {out}" + ("" if drawn else " (no figure: nothing was measured)"))
        return 0 if any(row["ok"] for row in report["rows"]) and not report["interrupted"] else 1

    return go


def _methods(problem: Any) -> tuple[str, ...]:
    """Return the methods of a problem, with an implicit scheme where one runs it."""
    return tuple(problem.METHODS) if not getattr(problem, "SCHEMES", True) else methods.standard(problem.METHODS)


def _hard_cases(arguments: argparse.Namespace) -> Any:
    """Check the words of a study of the hard cases; return what runs them into a folder and gives the exit code."""
    _refuse(arguments, ("sizes", "steps", "set", "error"), "hard cases have their own; use --full")
    chosen = hard_register.choose(arguments.methods)

    def go(out: Path) -> int:
        report = hard_table.collect(
            chosen,
            full=arguments.full,
            budget=arguments.budget,
            threads=arguments.threads,
            say=lambda text: print(f"  {text}", flush=True),
        )
        write_json(out / "study.json", report)
        hard_table.write_csv(out / "study.csv", report["rows"])
        print("", *hard_table.lines(report), sep="\n")
        print(f"\nfiles in {out}")
        return 0 if report["passed"] and not report["interrupted"] else 1

    return go


def _friction_layer(arguments: argparse.Namespace) -> Any:
    """Check the words of a study of the layer alone; return what runs it into a folder and gives the exit code."""
    _refuse(arguments, ("sizes", "steps", "set", "error", "full"), "this study has its own grids, steps and errors")
    chosen = friction_layer.choose(arguments.methods)

    def go(out: Path) -> int:
        report = friction_layer.collect(
            chosen,
            budget=arguments.budget,
            threads=arguments.threads,
            say=lambda text: print(f"  {text}", flush=True),
        )
        write_json(out / "study.json", report)
        friction_layer.write_csv(out / "study.csv", report["rows"])
        drawn = draw(out / "study.png", report["rows"])
        print("", *friction_layer.lines(report), sep="\n")
        print(f"\nfiles in {out}" + ("" if drawn else " (no figure: nothing was measured)"))
        return 0 if report["rows"] and not report["interrupted"] else 1

    return go


def _refuse(arguments: argparse.Namespace, options: tuple[str, ...], remedy: str) -> None:
    """Raise `InputError` if one of the options was given."""
    for option in options:
        if getattr(arguments, option):
            raise InputError(f"--{option}", getattr(arguments, option), remedy)
