"""A result file written as a run writes it, with fields that are known from the number of the frame; to be killed."""

import functools
import sys

import numpy as np

from tcontact.results.files.vtkhdf import ResultFile

POINTS = np.random.default_rng(1).normal(size=(300, 3))
CELLS = np.arange(296).reshape(-1, 8)
DROPPED = 3
ROWS = (3000, 5000)  # of the history, when the run stops and when it ends


def frame(index):
    """Fields of a frame."""
    generator = np.random.default_rng(index)
    return {"displacement": generator.normal(size=(300, 3)), "pressure": generator.normal(size=300)}


def write_run(path, frames, done=lambda count: None):
    """Frames, history and attributes; then the last frames are dropped and written again, as after a resume.

    done: called with the number of frames that are on disk from now on.
    """
    with ResultFile.create(path, POINTS, [("hex8", CELLS)]) as file:
        for index in range(frames):
            file.append(0.5 * index, frame(index))
            done(index + 1)
        file.write_history({"time": np.arange(float(ROWS[0]))})
        file.write_attributes({"reason": "interrupted", "text": "x" * 900})
    done(frames - DROPPED)
    with ResultFile.reopen(path, frames - DROPPED, {"text": "again"}) as file:
        for index in range(frames - DROPPED, frames):
            file.append(0.5 * index, frame(index))
            done(index + 1)
        file.write_history({"time": np.arange(float(ROWS[1])), "extra": np.ones((ROWS[1], 3))})
        file.write_attributes({"reason": "finished", "text": "y" * 2000})


if __name__ == "__main__":
    number = 0
    while True:
        write_run(f"{sys.argv[1]}/{number}.vtkhdf", 14, functools.partial(print, number, flush=True))
        number += 1
