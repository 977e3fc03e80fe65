"""Why a folder has no checkpoint to go on with, in the words of errors and warnings."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

from ..results.files.vtkhdf import ResultData
from .folder_lock import ASIDE, PUT_ASIDE
from .recorder import FILE

NOT_ON_ALL = "holds no checkpoint that all ranks have; run again"


def warn_of_damage(files: Sequence[Path]) -> None:
    """Warn of damaged checkpoints."""
    for path in files:
        warnings.warn(f"{path} is damaged and passed over", RuntimeWarning, stacklevel=4)


def nothing(folder: Path, damaged: bool) -> str:
    """Return why a folder has no checkpoint to go on with, and what to do; damaged: there are damaged ones."""
    if damaged:
        return "its checkpoints are damaged; run again"
    if not (folder / FILE).is_file():
        aside = (folder / ASIDE / FILE).is_file()
        return PUT_ASIDE if aside else "holds no run; give the folder of a run that stopped"
    reason = ResultData.open(folder / FILE).attributes.get("reason")
    if reason == "interrupted":
        return "the run there was interrupted and left no checkpoint: run again, with checkpoint= (--checkpoint)"
    if reason is not None:
        return f"the run there has ended; there is nothing to go on with (`tcontact render {folder} --plots` draws it)"
    return "holds no checkpoint: it stopped before the first one, or was run without; run again"
