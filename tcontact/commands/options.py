"""Options that several commands have, each declared once."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from . import words

SHARED: dict[str, dict[str, Any]] = {
    "FILE": {"dest": "file", "type": Path, "help": "a result.vtkhdf or the folder of a run"},
    "--arch": {"choices": ("cpu", "cuda"), "help": "where to compute (default: cpu)"},
    "--checkpoint": {"metavar": "SECONDS", "type": words.not_negative, "default": 60.0},
    "--force": {"action": "store_true", "help": "replace the files of another run in DIR"},
    "--import": {
        "dest": "imported",
        "metavar": "FILE",
        "action": "append",
        "type": words.module,
        "help": "a Python file or module to run first, which registers own laws (tcontact.register_law); repeatable",
    },
    "--out": {"metavar": "DIR", "type": words.folder},
    "--precision": {
        "choices": ("f64", "mixed"),
        "help": "arithmetic of the ordinary cells: float64, or float32 on differences in float64 (default: f64)",
    },
    "--quiet": {"action": "store_true", "help": "no progress bar, no table: only failures are printed"},
    "--set": {"metavar": "KEY=VALUE", "action": "append", "default": []},
    "--threads": {"metavar": "N", "type": words.whole, "help": "CPU threads (default: all cores)"},
}


def add(parser: argparse.ArgumentParser, *names: str, **changes: Any) -> None:
    """Declare the named options; changes: what differs here, such as help or default."""
    for name in names:
        options = SHARED[name] | changes
        if name.startswith("--"):
            parser.add_argument(name, **options)
        else:
            parser.add_argument(options.pop("dest"), metavar=name, **options)
