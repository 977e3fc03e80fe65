"""Whether the scene that is made again from a case or scene file is the one that was run: both may have been edited.

summary.json holds the fingerprint of what was run, with numbers rounded so that another processor finds the same. Runs
that were killed have one in their checkpoint, with all digits, as `tcontact resume` compares it. Runs of versions that
stored none are compared by the nodes in their result file.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..base.version import __version__
from ..results.files import checkpoint_heads
from ..results.files.vtkhdf import ResultData
from ..results.stored import NotStored
from ..run.checkpoint.fingerprint import differences, fingerprint

KEY = "fingerprint"  # in summary.json
NEAR = 1e-9  # of the size of the bodies, to which nodes agree


def kept(scene: Any, scheme: Any, rounded: bool = True) -> dict[str, Any]:
    """Return what summary.json keeps of a scene and its scheme; nothing if a function gives two values at one time.

    rounded: False = with all digits, as checkpoints keep it.
    """
    try:
        return {KEY: fingerprint(scene, scheme, rounded=rounded)}
    except InputError:
        return {}


def check_same(scene: Any, scheme: Any, source: str, summary: Mapping[str, Any], data: ResultData) -> None:
    """Raise `NotStored` if the scene made from `source` (a case or scene file) is not the one that was run."""
    known, text = summary or checkpoint_heads.head(data.path.parent), ""
    rounded = KEY in known
    stored = known.get(KEY if rounded else "physics")
    if isinstance(stored, Mapping):
        present = kept(scene.for_scheme(getattr(scheme, "implicit", False)), scheme, rounded).get(KEY, {})
        if known.get("versions", {}).get("tcontact") != __version__:  # others have other options
            stored, present = ({name: one[name] for name in stored if name in present} for one in (stored, present))
        names = differences(stored, present)
        if names:
            more = f"; {', '.join(names[1:4])}{', ...' if len(names) > 4 else ''} differ too" if len(names) > 1 else ""
            now, was = (one.get(names[0], "not there") for one in (present, stored))
            text = f"{names[0]} is {now}, where the run had {was}{more}"
    elif not data.parts:
        text = _other_nodes(scene, data.points)
    if text:
        remedy = "give the scene that was run to open_result(folder, scene=...), restore the file, or run again"
        where = str(data.path)
        raise NotStored("scene", where, f"{source} makes another scene than the one that was run: {text}; {remedy}")


def _other_nodes(scene: Any, points: np.ndarray) -> str:
    """Return how the nodes differ from those of the result file, "" if they do not."""
    count = sum(body.mesh.node_count for body in scene.bodies)
    if count != len(points):
        return f"it has {count} nodes, where the run had {len(points)}"
    away = np.abs(np.concatenate([body.mesh.nodes for body in scene.bodies]) - points).max(initial=0.0)
    return f"nodes lie up to {away:.3g} m away from those of the run" if away > NEAR * np.abs(points).max() else ""
