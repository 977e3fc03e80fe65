"""Writer of a series as .xdmf, an index in XML, with its numbers in one .h5 file beside it.

Format: https://www.xdmf.org/index.php/XDMF_Model_and_Format (cells of several kinds: their code before their nodes).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from xml.sax.saxutils import quoteattr

import h5py
import numpy as np

from ...device.atomic_file import AtomicFile, replaced
from ...mesh.elements import ELEMENTS
from .vtkhdf import Frame

RANK = {1: "Scalar", 3: "Vector"}


def write_series(
    path: Path, points: np.ndarray, blocks: Sequence[tuple[str, np.ndarray]], frames: Iterable[Frame]
) -> list[Path]:
    """Write `path` (.xdmf) and the .h5 file with its numbers in place of older ones; returns both.

    Raises `OSError` with the word of the system, where HDF5 has its own.
    """
    store = path.with_suffix(".h5")
    grids = []
    with replaced(store, synced=False) as part, _numbers(part) as file:

        def item(name: str, array: np.ndarray) -> str:
            file[name] = array
            kind = "Float" if array.dtype.kind == "f" else "Int"
            shape = " ".join(str(size) for size in array.shape)
            place = f"{store.name}:/{name}"
            return (
                f'<DataItem DataType="{kind}" Precision="8" Dimensions="{shape}" Format="HDF">'
                f"{place.replace('&', '&amp;').replace('<', '&lt;')}</DataItem>"
            )

        mesh = _topology(blocks, item)
        mesh.append(f'<Geometry GeometryType="XYZ">{item("points", points)}</Geometry>')
        for index, frame in enumerate(frames):
            rows = ['<Grid Name="frame" GridType="Uniform">', *mesh, f'<Time Value="{frame.time!r}"/>']
            for centre, fields in (("Node", frame.point_data), ("Cell", frame.cell_data)):
                rows += _attributes(centre, index, fields, item)
            grids += [*rows, "</Grid>"]
    text = ['<?xml version="1.0"?>', '<Xdmf Version="3.0"><Domain>']
    text += ['<Grid Name="series" GridType="Collection" CollectionType="Temporal">', *grids, "</Grid>"]
    with replaced(path, synced=False) as part:
        part.write_text("\n".join([*text, "</Domain></Xdmf>", ""]), encoding="utf-8")
    return [path, store]


@contextmanager
def _numbers(path: Path) -> Iterator[h5py.File]:
    """Open a new file for the numbers. Raises the `OSError` of the disk rather than what HDF5 makes of it."""
    disk = AtomicFile(path, "w")
    try:
        with h5py.File(disk, "w", libver="earliest") as file:
            yield file
        disk.commit()
    except Exception:
        if disk.failed is not None:
            raise disk.failed from None
        raise
    finally:
        disk.close()


def _attributes(centre: str, index: int, fields: Mapping[str, np.ndarray], item: object) -> list[str]:
    assert callable(item)
    rows = []
    for name, array in fields.items():
        rank = RANK.get(1 if array.ndim == 1 else array.shape[1], "Matrix")
        rows.append(
            f'<Attribute Name={quoteattr(name)} AttributeType="{rank}" Center="{centre}">'
            f"{item(f'frame-{index:04d}/{centre}/{name}', array)}</Attribute>"
        )
    return rows


def _topology(blocks: Sequence[tuple[str, np.ndarray]], item: object) -> list[str]:
    assert callable(item)
    count = sum(len(cells) for _, cells in blocks)
    if len({kind for kind, _ in blocks}) == 1:
        cells = np.concatenate([cells for _, cells in blocks])
        name = ELEMENTS[blocks[0][0]].xdmf[0]
        topology = item("cells", cells)
        return [f'<Topology TopologyType="{name}" NumberOfElements="{count}">{topology}</Topology>']
    rows = [np.insert(cells, 0, ELEMENTS[kind].xdmf[1], axis=1).ravel() for kind, cells in blocks]
    topology = item("cells", np.concatenate(rows))
    return [f'<Topology TopologyType="Mixed" NumberOfElements="{count}">{topology}</Topology>']
