"""Read surfaces in Wavefront OBJ files: `v` and `f` lines among any others.

meshio takes texture coordinates and normals for data of the points, which they are not (there may be fewer or more of
them), and knows no ids that count backwards.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np


def read_wavefront(file: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return points [k, 3] in the unit of the file and triangles [m, 3], polygons cut into fans; ids may be wrong.

    Raises `ValueError` naming the line for one that cannot be read.
    """
    points: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    lines = file.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ").splitlines()
    for number, line in enumerate(lines, 1):
        words = line.split("#", 1)[0].split()
        if not words or words[0] not in ("v", "f"):
            continue
        try:
            if words[0] == "v":
                x, y, z = (float(word) for word in words[1:4])  # a weight or a colour may follow
                points.append([x, y, z])
            else:
                ids = [int(word.split("/", 1)[0]) for word in words[1:]]
                corners = [id - 1 if id > 0 else (len(points) + id if id < 0 else -1) for id in ids]
                triangles += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
        except ValueError as error:
            raise ValueError(f"line {number}: {line.strip()[:60]!r}") from error
    return np.array(points).reshape(-1, 3), np.array(triangles, dtype=np.int64).reshape(-1, 3)
