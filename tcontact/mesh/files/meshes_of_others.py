"""Meshes of other packages in memory: those of meshio and of PyVista."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...base.validate import number
from ...base.warning_kinds import MeshWarning, warn
from ..checks import checked_members
from ..geometry import IntArray
from ..mesh import Mesh
from .content import FileMesh, MeshFileError, mesh_from_file
from .meshio_files import DIMENSION, region_sets, typed_blocks
from .second_order import first_order

VOXEL = 11  # VTK's type of a box along the axes
NO_SET = "gmsh:bounding_entities"  # numbers of entities, which meshio keeps among the cell sets


def from_meshio(mesh: Any, scale: float) -> Mesh:
    """Make a mesh of a `meshio.Mesh`; see `Mesh.from_meshio`."""
    factor = number("scale", scale, low=0.0)
    try:
        content = FileMesh(np.asarray(mesh.points, dtype=np.float64), typed_blocks(mesh))
        _add_sets(content, mesh)
    except InputError:
        raise
    except (AttributeError, TypeError, ValueError, KeyError, IndexError) as error:
        raise InputError("mesh", mesh, f"give a meshio.Mesh of volume cells ({error})") from error
    try:
        return mesh_from_file(first_order(content, None), factor, None)
    except MeshFileError as error:
        raise InputError("mesh", mesh, str(error)) from error


def from_pyvista(grid: Any, scale: float) -> Mesh:
    """Make a mesh of a grid of PyVista; see `Mesh.from_pyvista`."""
    try:
        grid = grid if hasattr(grid, "cells_dict") else grid.cast_to_unstructured_grid()
        kinds = np.asarray(grid.celltypes)
        parts = {kind: np.flatnonzero(kinds == kind) for kind in grid.cells_dict}
        cells = [_block(int(kind), np.asarray(rows)) for kind, rows in grid.cells_dict.items()]
        data = {name: [np.asarray(grid.cell_data[name])[rows] for rows in parts.values()] for name in grid.cell_data}
        points = np.asarray(grid.points, dtype=np.float64)
    except (AttributeError, TypeError, ValueError, KeyError) as error:
        raise InputError("grid", grid, f"give a pyvista.UnstructuredGrid of volume cells ({error})") from error
    try:
        return from_meshio(
            SimpleNamespace(points=points, cells=cells, cell_data=data, cell_sets={}, point_sets={}), scale
        )
    except InputError as error:
        raise error if error.field != "mesh" else InputError("grid", grid, error.remedy) from error


def _block(kind: int, rows: np.ndarray) -> SimpleNamespace:
    """Return cells of a type of VTK as a block of meshio; a voxel is a hexahedron with its corners in another order."""
    from meshio._vtk_common import vtk_to_meshio_type

    if kind == VOXEL:
        return SimpleNamespace(type="hexahedron", data=rows[:, [0, 1, 3, 2, 4, 5, 7, 6]])
    return SimpleNamespace(type=vtk_to_meshio_type[kind], data=rows)


def _add_sets(content: FileMesh, mesh: Any) -> None:
    """Take over point sets, cell sets by the dimension of their cells, and regions by whole numbers of the cells.

    The nodes of cells of other dimensions make a node set where no point set has the name, whole numbers of the cells a
    cell set where no cell set has it.
    """
    for name, ids in mesh.point_sets.items():
        content.node_sets[name] = checked_members(f"point_sets[{name!r}]", ids, len(content.points), "nodes")
    content.cell_sets = {name: parts for name, parts in region_sets(mesh).items() if name not in mesh.cell_sets}
    for name, members in mesh.cell_sets.items():
        if name == NO_SET:
            continue
        nodes: list[IntArray] = []
        parts = _parts(name, members, content.blocks)
        if not any(len(chosen) for chosen in parts):
            warn(f"set {name!r} is left out: it holds no cells", MeshWarning)
        for place, ((kind, rows), chosen) in enumerate(zip(content.blocks, parts, strict=True)):
            if not len(chosen):
                continue
            if DIMENSION.get(kind, -1) == 2:
                content.face_sets.setdefault(name, []).append(rows[chosen])
            elif DIMENSION.get(kind, -1) == 3:
                content.cell_sets.setdefault(name, {})[place] = chosen
            else:
                nodes.append(rows[chosen].reshape(-1))
        if nodes and name not in mesh.point_sets:
            content.node_sets[name] = np.unique(np.concatenate(nodes))


def _parts(name: str, members: Any, blocks: list[tuple[str, IntArray]]) -> list[IntArray]:
    """Return the cells of a cell set in every block."""
    field = f"cell_sets[{name!r}]"
    if not hasattr(members, "__len__") or isinstance(members, (str, dict)) or len(members) != len(blocks):
        remedy = f"give a list with the cells of each of the {len(blocks)} blocks, None for a block without any"
        raise InputError(field, members, remedy)
    return [
        checked_members(
            f"{field}[{place}]", [] if chosen is None else chosen, len(rows), f"cells of this block ({kind})"
        )
        for place, ((kind, rows), chosen) in enumerate(zip(blocks, members, strict=True))
    ]
