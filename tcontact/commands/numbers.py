"""`tcontact numbers`: it makes the figures of README.md and docs/NUMBERS.md again and compares or replaces them."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..base.errors import InputError
from ..lab.numbers import pages, pictures, times
from ..lab.numbers.pages import different
from ..lab.numbers.reports import Reports
from ..lab.numbers.tables import TABLES
from . import words

PICTURES, TIMES = "pictures", "times"


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser(
        "numbers",
        help="make the figures of the documents again",
        description="Run every command whose figures stand in README.md and docs/NUMBERS.md (some minutes) and print"
        " their tables. --check compares those that every machine makes alike with the documents, --write replaces"
        " them, speeds and pictures too.",
    )
    parser.add_argument(
        "--only",
        metavar="A,B",
        type=words.names,
        help="tables by name, pictures, or times (of the cases, for `tcontact list -v`); a wrong name lists them",
    )
    parser.add_argument("--check", action="store_true", help="compare with the documents; exit code 1 if they differ")
    parser.add_argument("--write", action="store_true", help="replace tables and pictures in the documents")
    parser.add_argument("--docs", metavar="DIR", type=Path, help="folder of README.md and docs/ (.)")
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=words.folder,
        default=Path("runs/numbers"),
        help="folder of the runs (runs/numbers)",
    )
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Make the tables and print, compare or write them; returns the exit code."""
    if arguments.check and arguments.write:
        raise InputError("--check, --write", True, "give one of them")
    known = [*TABLES, PICTURES, TIMES]
    if unknown := sorted(set(arguments.only or ()) - set(known)):
        raise InputError("--only", unknown[0], "use some of " + ", ".join(known))
    docs: Path = arguments.docs or Path(".")
    stated = pages.tables(docs) if arguments.check or arguments.write or arguments.docs else {}
    chosen = arguments.only or known
    wanted = [name for name in TABLES if name in chosen and (TABLES[name].repeats or not arguments.check)]
    reports = Reports(arguments.out, arguments.main, lambda text: print(f"  {text}", flush=True))
    new = {name: TABLES[name].lines(reports) for name in wanted}
    if arguments.check:
        return _compare(stated, new)
    if arguments.write:
        changed = pages.replace(docs, new)
        if PICTURES in chosen:
            changed += pictures.draw(docs, reports)
        if TIMES in chosen:
            changed.append(times.write(docs, times.measure(arguments.out / TIMES, reports.say)))
        print(*(f"changed: {path}" for path in changed), sep="\n")
        return 0
    for name, lines in new.items():
        print("", f"{name}:", *lines, sep="\n")
    if TIMES in (arguments.only or ()):
        times.measure(arguments.out / TIMES, reports.say)
    return 0


def _compare(stated: dict[str, list[str]], new: dict[str, list[str]]) -> int:
    """Print the lines that differ; return 1 if there are any."""
    found = [(name, pair) for name, lines in new.items() for pair in different(stated.get(name, []), lines)]
    for name, (old, present) in found:
        print(f"{name}:\n  stated {old}\n  now    {present}")
    print(
        "all figures as stated" if not found else f"{len(found)} lines differ; `tcontact numbers --write` replaces them"
    )
    return 1 if found else 0
