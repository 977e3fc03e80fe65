"""Import matplotlib for the curves of a command without the docstrings that it writes for every class of its artists.

They take more than a third of its import, and nobody reads them in a command. The names replaced here are internal to
matplotlib: where one is missing, the import stays slow.
"""

from __future__ import annotations

import sys
from typing import Any

from ..base.window_backend import import_matplotlib


def load_matplotlib() -> None:
    """Import what draws curves into files, unless it is there already."""
    if "matplotlib.figure" in sys.modules:
        return
    import_matplotlib()
    from matplotlib import artist

    name, base = "_update_set_signature_and_docstring", artist.Artist
    described, listed = vars(base).get(name), getattr(artist, "kwdoc", None)
    if described is not None and listed is not None:
        setattr(base, name, classmethod(_nothing))
        artist.kwdoc = _no_text  # type: ignore[assignment]
    try:
        from matplotlib.backends import backend_agg  # noqa: F401 - imports the rest
        from matplotlib.figure import Figure  # noqa: F401
    finally:
        if described is not None and listed is not None:
            setattr(base, name, described)
            artist.kwdoc = listed


def _nothing(_class: Any) -> None:
    """Leave the method `set` of a class without a signature and a docstring of its own."""


def _no_text(_artist: Any) -> str:
    """Return no text in place of the list of an artist's properties."""
    return ""
