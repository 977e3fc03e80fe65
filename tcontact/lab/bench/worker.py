"""The process that measures: it reads a task as JSON and prints what it found as one line of JSON.

python -m tcontact.lab.bench.worker '{"task": "measure", "kind": "hex8", ...}'
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from typing import Any

from ...results.report import plain
from . import alternatives, layer, queries
from .configuration import Configuration


def perform(task: str, options: dict[str, Any]) -> dict[str, Any]:
    """Return what the named task finds: measure, compilation, bar, layer, rubbing, queries,
    setup, frames, alternatives or pairs."""
    if task == "measure":
        from .measure import measure

        return measure(Configuration.from_dict(options))
    from . import pairs, rubbing, small, waiting

    tasks: dict[str, Callable[..., dict[str, Any]]] = {
        "compilation": small.compilation,
        "bar": small.bar,
        "layer": layer.layer,
        "rubbing": rubbing.rubbing,
        "queries": queries.queries,
        "pairs": pairs.pairs,
        "setup": waiting.setup,
        "frames": waiting.frames,
        "alternatives": alternatives.alternatives,
    }
    return tasks[task](**options)


def main(text: str) -> int:
    """Perform a task; answer a failure, too, with a line of JSON."""
    options = json.loads(text)
    try:
        found = perform(options.pop("task"), options)
    except Exception as error:  # whatever goes wrong becomes the reason of a row
        found = {"failed": f"{type(error).__name__}: {error}"}
    print(json.dumps(plain(found)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
