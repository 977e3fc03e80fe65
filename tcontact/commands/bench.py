"""`tcontact bench`: it measures what a step costs on this machine, against what it could cost, beside its errors."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..base.errors import InputError
from ..lab.bench import chart
from ..lab.bench.configuration import CONTACTS, KINDS, LAWS, grid
from ..results.report import write_json
from . import words
from .doctor import cores


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "bench",
        help="measure what a step costs on this machine",
        description="Time the whole explicit step, a process per configuration, beside the plain kernel, the copy"
        " bandwidth and an assembled matrix. Leaves bench.json, bench.csv and bench.png in a folder.",
    )
    available = cores()
    threads = [1, available] if available > 1 else [1]
    lists: dict[str, tuple[Callable[[str], Any], list[Any], str]] = {
        "--kinds": (_among(KINDS), ["hex8", "hex8-reduced", "tet4"], "kinds of cells"),
        "--laws": (_among(LAWS), ["neo-hookean", "linear"], "elastic laws"),
        "--sizes": (words.whole, [32], "hexes along an edge of the cube (six tets for each)"),
        "--threads": (words.whole, threads, "CPU threads"),
        "--contact": (_among(CONTACTS), ["none", "normal", "full"], "removal of the massless contact on one face"),
    }
    for option, (convert, default, text) in lists.items():
        shown = ",".join(map(str, default))
        parser.add_argument(
            option, metavar="A,B", type=words.several(convert), default=default, help=f"{text} (default: {shown})"
        )
    parser.add_argument(
        "--steps", metavar="N", type=words.whole, help="steps per batch (default: about a quarter second)"
    )
    parser.add_argument(
        "--seconds", metavar="S", type=words.positive, default=10.0, help="time budget per configuration (default: 10)"
    )
    parser.add_argument("--arch", choices=("cpu", "cuda"), default="cpu", help="where to compute (default: cpu)")
    parser.add_argument(
        "--out", metavar="DIR", type=words.folder, default=Path("runs/bench"), help="(default: runs/bench)"
    )
    parser.add_argument("--quick", action="store_true", help="8^3 cells, one law, one thread, a minute: a look only")
    parser.add_argument(
        "--solvers",
        action="store_true",
        help="only compare the solvers of the static solve, on the first of --sizes and --threads; leaves solvers.json",
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Measure, write the files, print the table; return 1 if a configuration failed."""
    from ..lab.bench import static_solvers, table
    from ..lab.bench.collect import collect

    laws, sizes, threads, batches = arguments.laws, arguments.sizes, arguments.threads, 5
    if arguments.quick:
        laws, sizes, threads, batches = laws[:1], [8], threads[:1], 3
    if arguments.arch == "cuda":
        threads = threads[:1]
    out: Path = arguments.out
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("--out", str(out), f"cannot be written ({error}); name another folder") from error
    if arguments.solvers:
        rows = static_solvers.compare(sizes[0], threads[0])
        write_json(out / "solvers.json", {"rows": rows})
        print(*static_solvers.lines(rows), sep="\n")
        return 0 if all(row["ok"] for row in rows) else 1
    configurations = grid(
        arguments.kinds,
        laws,
        sizes,
        threads,
        contacts=tuple(arguments.contact),
        arch=arguments.arch,
        steps=arguments.steps,
        seconds=1.0 if arguments.quick else arguments.seconds,
        batches=batches,
    )
    report = collect(configurations, lambda text: print(f"  {text}", flush=True), extras=not arguments.quick)
    write_json(out / "bench.json", report)
    table.write_csv(out / "bench.csv", report["rows"])
    drawn = chart.draw(out / "bench.png", report)
    print(*table.lines(report), sep="\n")
    print(f"\nfiles in {out}" + ("" if drawn else " (no chart: nothing was measured)"))
    others = [row for part in ("bar", "layer", "rubbing", "queries", "start") for row in report.get(part, ())]
    return 0 if all(row["ok"] for row in [*report["rows"], *others]) else 1


def _among(known: tuple[str, ...]) -> Callable[[str], str]:
    def read(text: str) -> str:
        if text not in known:
            raise argparse.ArgumentTypeError(f"{text!r}: use {', '.join(known)}")
        return text

    return read
