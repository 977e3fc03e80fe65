"""Read surfaces in PLY files, text or binary: the elements `vertex` and `face` among any others.

meshio knows `vertex_indices` but not `vertex_index`, by which the format was introduced (Turk 1994), and in binary
files neither numbers beside the list of a face nor further elements.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4"}
TYPES |= {"double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"}
TYPES |= {"float32": "f4", "float64": "f8", "int64": "i8", "uint64": "u8"}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
FEWEST = 64  # rows of a binary file read together
CORNERS = ("vertex_indices", "vertex_index")


class Element(NamedTuple):
    """An element of the header: properties by name, (type of the count, type of the items) for a list."""

    name: str
    rows: int
    properties: dict[str, tuple[str, ...]]


def read_polygons(file: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return points [k, 3] in the unit of the file and triangles [m, 3], polygons cut into fans; ids may be wrong.

    Raises `ValueError` saying what is wrong with the file.
    """
    data = file.read_bytes()
    head = re.match(rb"ply\s.*?^\s*end_header[^\S\n]*\n", data, re.DOTALL | re.MULTILINE)
    if head is None:
        raise ValueError("no header from 'ply' to 'end_header'")
    order, elements = _declared(head.group().decode("ascii", errors="replace"))
    rows = _text(data[head.end() :], elements) if order == "" else _binary(data[head.end() :], elements, order)
    points, triangles = np.zeros((0, 3)), [np.zeros((0, 3), dtype=np.int64)]
    for element, columns in rows:
        if element.name == "vertex":
            points = np.stack([np.asarray(columns[axis], dtype=np.float64) for axis in "xyz"], axis=1)
        if element.name == "face":
            for corners in columns.get(CORNERS[0], columns.get(CORNERS[1], [])):
                ids = np.asarray(corners).astype(np.int64)
                triangles += [np.stack([ids[..., 0], ids[..., i], ids[..., i + 1]], axis=-1).reshape(-1, 3)
                              for i in range(1, ids.shape[-1] - 1)]  # fmt: skip
    return points, np.concatenate(triangles)


def _declared(header: str) -> tuple[str, list[Element]]:
    order, elements = None, []
    for line in header.splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            order = ORDERS.get(words[1])
        elif words[:1] == ["element"]:
            elements.append(Element(words[1], int(words[2]), {}))
        elif words[:1] == ["property"]:
            types = words[2:4] if words[1] == "list" else words[1:2]
            if not elements or not set(types) <= set(TYPES):
                raise ValueError(f"unknown property: {line.strip()!r}")
            elements[-1].properties[words[-1]] = tuple(TYPES[word] for word in types)
    if order is None:
        raise ValueError("no format that is known")
    return order, elements


def _text(body: bytes, elements: list[Element]) -> Iterator[tuple[Element, dict[str, Any]]]:
    """Read the columns of each element from text: arrays [count], or rows of items for a list."""
    words, at = body.split(), 0
    for element in elements:
        columns: dict[str, Any] = {name: [] for name in element.properties}
        for _ in range(element.rows if columns else 0):  # a header may promise any number of empty rows
            for name, types in element.properties.items():
                if at >= len(words):
                    raise ValueError("the file ends too early")
                length = 1 if len(types) == 1 else int(words[at])
                at += len(types) - 1
                values = [float(word) for word in words[at : at + length]]
                if len(values) < length:
                    raise ValueError("the file ends too early")
                columns[name].append(values[0] if len(types) == 1 else values)
                at += length
        yield element, columns


def _binary(body: bytes, elements: list[Element], order: str) -> Iterator[tuple[Element, dict[str, Any]]]:
    """Read them from binary data; rows of a list come in blocks [rows, items] of equal length."""
    at = 0
    for element in elements:
        columns: dict[str, Any] = {name: [] for name in element.properties}
        left, window = element.rows, FEWEST
        while left:  # read rows of the same length at once; twice as many if all had it
            length, fields = at, list[tuple[Any, ...]]()
            for name, types in element.properties.items():
                items = 1
                if len(types) == 2:
                    fields.append((f"{name}:count", order + types[0]))
                    items = int(_values(body, order + types[0], 1, length)[0])
                    length += np.dtype(types[0]).itemsize
                fields.append((name, order + types[-1], (items,)) if len(types) == 2 else (name, order + types[0]))
                length += items * np.dtype(types[-1]).itemsize
            kind = np.dtype(fields)
            rows = _values(body, kind, max(1, min(left, window, (len(body) - at) // max(kind.itemsize, 1))), at)
            like = np.ones(len(rows), dtype=bool)
            for name in (name for name in kind.names or () if name.endswith(":count")):
                like &= rows[name] == rows[name][0]
            same = len(rows) if like.all() else int(np.argmin(like))
            for name in element.properties:
                columns[name].append(rows[name][:same])
            at, left = at + same * kind.itemsize, left - same
            window = 2 * window if same == len(rows) else FEWEST
        plain = {name for name, types in element.properties.items() if len(types) == 1 and columns[name]}
        yield element, {name: np.concatenate(parts) if name in plain else parts for name, parts in columns.items()}


def _values(body: bytes, kind: Any, count: int, at: int) -> np.ndarray:
    if at + count * np.dtype(kind).itemsize > len(body):
        raise ValueError("the file ends too early")
    return np.frombuffer(body, kind, count, at)
