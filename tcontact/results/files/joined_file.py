"""Make one result file of a file that shows the parts of ranks, for a run that goes on with another number of ranks."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from .part_places import FOLDER
from .vtkhdf import ResultFile
from .vtkhdf_reader import ResultData


def join_parts(path: Path, frames: int) -> None:
    """Put the first `frames` frames of a result file that shows parts into a file of its own, and remove the parts.

    Until it is complete everything stays as it is; a file without parts does too. Raises `InputError` for damaged or
    missing parts, `OSError` where the file cannot be written.
    """
    data = ResultData.open(path)
    if not data.parts:
        return
    new = path.with_name(f".{path.name}.joined")
    static = data.static_fields()
    try:
        with data.opened() as read, ResultFile.create(new, data.points, data.blocks, data.attributes, static) as file:
            for index in range(frames):
                frame = read(index)
                moving = {name: array for name, array in frame.cell_data.items() if name not in static}
                file.append(frame.time, frame.point_data, moving)
        os.replace(new, path)
    finally:
        new.unlink(missing_ok=True)
    shutil.rmtree(path.parent / FOLDER, ignore_errors=True)
