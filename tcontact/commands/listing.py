"""`tcontact list`: it prints the cases, and reads their sources only, so that it is instant."""

from __future__ import annotations

import argparse
import textwrap
from typing import Any

from tcontact import cases


def add(subparsers: Any) -> None:
    """Declare the command."""
    parser = subparsers.add_parser("list", help="list the cases", description="List the cases and what each is about.")
    parser.add_argument(
        "-v", "--verbose", action="store_true", help="explain each, with its parameters, their types and defaults"
    )
    parser.add_argument("cases", metavar="CASE", nargs="*", help="only these (default: all)")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print the cases."""
    width = max(len(name) for name in cases.names())
    titles = {name: cases.title(name) for name in arguments.cases or cases.names()}  # refuses others
    for name, title in titles.items():
        print(f"{name:<{width}}  {title}")
        if not arguments.verbose:
            continue
        for text in (cases.about(name), cases.about_parameters(name)):
            print(textwrap.indent(text, "    "), end="\n\n" if text else "")
        found = cases.parameters(name)
        space = max((len(key) for key in found), default=0)
        for key, (kind, default) in found.items():
            print(f"    {key:<{space}} = {default:<14} {kind}")
        if cases.compares(name):
            print(f"    {'compare':<{space}} = {'False':<14} bool: {cases.compares(name)}")
        print(f"    {cases.took(name)}\n" if cases.took(name) else "")
    return 0
