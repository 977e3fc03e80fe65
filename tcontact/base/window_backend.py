"""Import matplotlib whatever backend the variable MPLBACKEND names: pictures in files need no backend for windows.

Jupyter sets that variable for all programs started from a notebook, and matplotlib refuses to be imported where the
package that it names is missing.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress

VARIABLE = "MPLBACKEND"


def import_matplotlib() -> None:
    """Import matplotlib, with the backend that the variable names if there is such a one, else with its own choice."""
    if "matplotlib" in sys.modules:
        return
    name = os.environ.pop(VARIABLE, None)
    try:
        import matplotlib
    finally:
        if name is not None:
            os.environ[VARIABLE] = name  # programs started from here find it
    if name:
        with suppress(ValueError):  # no such backend
            matplotlib.rcParams["backend"] = name
