"""A small series of frames with two kinds of cells and two bodies, for what reads result files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tcontact.results.files.vtkhdf import ResultFile

POINTS = np.random.default_rng(3).random((12, 3))
HEXES = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]])
TETS = np.array([[0, 1, 2, 8], [3, 4, 5, 9], [9, 10, 11, 0]])
TIMES = [0.0, 1e-4, 3e-4, 7e-4]


def fields(index: int) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """What frame `index` holds."""
    rng = np.random.default_rng(index)
    return {"displacement": rng.normal(size=(12, 3)), "contact_pressure": rng.random(12)}, {"von_mises": rng.random(5)}


def written(folder: Path) -> Path:
    """A result file of hexahedra and tetrahedra in the folder."""
    body = {"body": np.array([0, 0, 1, 1, 1])}
    with ResultFile.create(folder / "result.vtkhdf", POINTS, [("hex8", HEXES), ("tet4", TETS)], {}, body) as file:
        for index, time in enumerate(TIMES):
            file.append(time, *fields(index))
        file.write_history({"time": np.array(TIMES)})
    return folder / "result.vtkhdf"
