"""`tcontact bench`: it measures what a step costs on this machine, against what it could cost, beside its errors."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..base.errors import InputError
from ..device.atomic_file import refuse_special
from ..device.runtime import MOST
from ..lab.bench import chart
from ..lab.bench.configuration import CONTACTS, KINDS, LAWS, grid
from ..results.report import write_json
from . import options, words
from .doctor import cores
from .folder import writable

RANKS_A_CORE = 8  # more of them are no measurement, and may take all memory
LEAVES = ("bench.json", "bench.csv", "bench.png", "alternatives.json", "alternatives.csv", "solvers.json", "pairs.json")
QUICK: dict[str, Any] = {
    "kinds": ["hex8", "tet4"],
    "laws": ["neo-hookean"],
    "sizes": [8],
    "threads": [1],
    "contact": ["none", "normal"],
    "seconds": 1.0,
}
ONLY = {
    "--ranks": "only measures neo-Hookean hex8 cubes on the CPU, one thread a rank: leave it out",
    "--solvers": "only compares both removals of linear hex8 cubes on the CPU: leave it out",
    "--pairs": "only measures neo-Hookean hex8 cubes with full removal on the CPU: leave it out",
    "--alternatives": "only measures the force of its own cells and laws on the CPU: leave it out",
}


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "bench",
        help="measure what a step costs on this machine",
        description="Time the whole explicit step, a process per configuration, beside the plain kernel, the copy"
        " bandwidth; then friction, gap queries, set-up, frames, start, and the force beside FElupe and a SciPy matrix"
        " where they are installed (pip install felupe). Leaves bench.json, bench.csv, alternatives.csv and bench.png.",
    )
    lists: dict[str, tuple[Callable[[str], Any], str]] = {
        "kinds": (_among(KINDS), "kinds of cells"),
        "laws": (_among(LAWS), "elastic laws"),
        "sizes": (words.whole, "hexes along an edge of the cube (six tets or two prisms for each)"),
        "threads": (words.whole, "CPU threads"),
        "contact": (_among(CONTACTS), "removal of the massless contact on one face"),
    }
    for name, (convert, text) in lists.items():
        shown = ",".join(map(str, _defaults()[name]))
        parser.add_argument(f"--{name}", metavar="A,B", type=words.several(convert), help=f"{text} (default: {shown})")
    parser.add_argument(
        "--steps", metavar="N", type=words.whole, help="steps per batch (default: about a quarter second)"
    )
    parser.add_argument(
        "--seconds", metavar="S", type=words.positive, help="time budget per configuration (default: 10)"
    )
    options.add(parser, "--arch", "--precision")
    options.add(parser, "--out", default=Path("runs/bench"), help="(default: runs/bench)")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="a look within a minute: hex8 and tet4, neo-Hookean, 8^3, one thread, no full removal unless given;"
        " no compile times, and beside the steps the other ways to the force alone",
    )
    parser.add_argument(
        "--solvers",
        action="store_true",
        help="only compare the solvers of the static solve, for one of --sizes and --threads; leaves solvers.json",
    )
    parser.add_argument(
        "--pairs",
        action="store_true",
        help="only measure two cubes in contact: search, coupling and solve, for one of --sizes; leaves pairs.json",
    )
    parser.add_argument(
        "--alternatives",
        action="store_true",
        help="only compare the internal force with FElupe, a SciPy matrix and the plain kernel, for one of --sizes;"
        " leaves alternatives.json and alternatives.csv",
    )
    parser.add_argument(
        "--ranks",
        metavar="A,B",
        type=words.several(words.whole),
        help="only measure a cube of one of --sizes (default: 24) on so many ranks, with one of --contact, beside one"
        " rank with a part of the cells; leaves ranks.json",
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Measure, write the files, print the table; return 1 if a configuration failed."""
    from ..lab.bench import pairs, static_solvers, table
    from ..lab.bench.collect import collect, machine, other_ways, pairs_of_bodies

    _check(arguments)
    if arguments.ranks:
        return _on_ranks(arguments)
    for name, value in (_defaults() | (QUICK if arguments.quick else {})).items():
        if getattr(arguments, name) is None:
            setattr(arguments, name, value)
    sizes, threads = arguments.sizes, arguments.threads
    out: Path = arguments.out
    with writable(out):
        out.mkdir(parents=True, exist_ok=True)
    if arguments.solvers:
        rows = static_solvers.compare(sizes[0], threads[0])
        write_json(out / "solvers.json", {"rows": rows})
        print(*static_solvers.lines(rows), sep="\n")
        return 0 if all(row["ok"] for row in rows) else 1
    if arguments.pairs:
        rows = pairs_of_bodies(sizes[0], threads, arguments.arch, lambda text: print(f"  {text}", flush=True))
        write_json(out / "pairs.json", {"rows": rows})
        print(*pairs.lines(rows), sep="\n")
        return 0 if all(row["ok"] for row in rows) else 1
    if arguments.alternatives:
        found = other_ways(sizes[0], threads, arguments.arch, lambda text: print(f"  {text}", flush=True))
        rows = table.rows_of(found)
        write_json(out / "alternatives.json", {"machine": machine(), "rows": found})
        table.write_csv(out / "alternatives.csv", rows)
        print(*table.lines({"machine": machine(), "rows": [], "alternatives": found}), sep="\n")
        return 0 if all(row["ok"] for row in [*found, *rows]) else 1
    configurations = grid(
        arguments.kinds,
        arguments.laws,
        sizes,
        threads[:1] if arguments.arch == "cuda" else threads,
        contacts=tuple(arguments.contact),
        arch=arguments.arch,
        precision=arguments.precision,
        steps=arguments.steps,
        seconds=arguments.seconds,
        batches=3 if arguments.quick else 5,
    )
    report = collect(configurations, lambda text: print(f"  {text}", flush=True), quick=arguments.quick)
    write_json(out / "bench.json", report)
    table.write_csv(out / "bench.csv", report["rows"])
    if report.get("alternatives"):
        table.write_csv(out / "alternatives.csv", table.rows_of(report["alternatives"]))
    drawn = chart.draw(out / "bench.png", report)
    print(*table.lines(report), sep="\n")
    print(f"\nfiles in {out}" + ("" if drawn else " (no chart: nothing was measured)"))
    measured = (found for part, found in report.items() if part not in ("machine", "rows", "model"))
    others = [row for found in measured for row in found]
    others += table.rows_of(report.get("alternatives", []))
    return 0 if all(row["ok"] for row in [*report["rows"], *others]) else 1


def _on_ranks(arguments: argparse.Namespace) -> int:
    """Measure steps on several ranks; return 1 if a run failed."""
    from ..lab.bench import rank_steps
    from ..lab.bench.collect import machine

    with writable(arguments.out):
        arguments.out.mkdir(parents=True, exist_ok=True)
    size, contact = (arguments.sizes or [24])[0], (arguments.contact or ["normal"])[0]
    rows = rank_steps.compare(arguments.ranks, size, contact, lambda text: print(f"  {text}", flush=True))
    write_json(arguments.out / "ranks.json", {"machine": machine(), "rows": rows})
    print(*rank_steps.lines(rows), sep="\n")
    return 0 if all(row["ok"] for row in rows) else 1


def _defaults() -> dict[str, Any]:
    """Return the values of the options that are not given."""
    available = cores()
    return {
        "kinds": ["hex8", "hex8-reduced", "tet4"],
        "laws": ["neo-hookean", "linear"],
        "sizes": [32],
        "threads": [1, available] if available > 1 else [1],
        "contact": ["none", "normal", "full"],
        "seconds": 10.0,
        "arch": "cpu",
        "precision": "f64",
    }


def _check(arguments: argparse.Namespace) -> None:
    """Refuse options that would be ignored, and more threads than a process can have. Raises `InputError`."""
    for file in (*LEAVES, "ranks.json"):
        refuse_special(arguments.out / file, "--out")
    for count in arguments.threads or ():
        if count > MOST:
            raise InputError("--threads", count, f"give at most {MOST}")
    for count in arguments.ranks or ():
        if count > (most := RANKS_A_CORE * cores()):
            raise InputError("--ranks", count, f"give at most {most}, {RANKS_A_CORE} for each core of this machine")
    asked = [name for name in ONLY if getattr(arguments, name.removeprefix("--"))]
    if len(asked) > 1:
        raise InputError(asked[1], True, f"{asked[0]} measures something else: give one of them")
    alone = asked[0] if asked else ""
    given = ["kinds", "laws", "steps", "seconds", "arch", "precision", *["contact"] * (alone != "--ranks")]
    for name in [*given, *["threads"] * (alone == "--ranks")] if alone else ():
        if getattr(arguments, name) is not None:
            raise InputError(f"--{name}", getattr(arguments, name), f"{alone} {ONLY[alone]}")
    one = {"": (), "--solvers": ("sizes", "threads"), "--ranks": ("sizes", "contact")}.get(alone, ("sizes",))
    for name in one or (("threads",) if arguments.arch == "cuda" else ()):
        if len(getattr(arguments, name) or ()) > 1:
            reason = alone or "--arch cuda"
            raise InputError(f"--{name}", getattr(arguments, name), f"{reason} takes one value: give it alone")


def _among(known: tuple[str, ...]) -> Callable[[str], str]:
    def read(text: str) -> str:
        if text not in known:
            raise argparse.ArgumentTypeError(f"{text!r}: use {', '.join(known)}")
        return text

    return read
