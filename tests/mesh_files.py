"""A box as a gmsh file: contents, and writers after the gmsh reference manual (MSH file format)."""

from __future__ import annotations

import struct

import numpy as np

from tcontact.mesh.box import box_mesh
from tcontact.mesh.elements import ELEMENTS

TYPES = {
    "point": (15, 0),
    "line": (1, 1),
    "triangle": (2, 2),
    "quad": (3, 2),
    "tet4": (4, 3),
    "hex8": (5, 3),
    "wedge6": (6, 3),
    "triangle6": (9, 2),
    "quad8": (16, 2),
    "tet10": (11, 3),
    "hex20": (17, 3),
    "wedge15": (18, 3),
    "tet20": (29, 3),
}
SECOND = {"tet4": "tet10", "hex8": "hex20", "wedge6": "wedge15", "triangle": "triangle6", "quad": "quad8"}
NAMES = {
    (2, 1): "left",
    (2, 2): "both ends",
    (2, 5): "body",
    (3, 1): "body",
    (3, 3): "all",
    (0, 4): "corner",
    (1, 1): "edge",
}


def box(kind):
    return box_mesh((1.0, 2.0, 3.0), (3, 2, 2), kind, origin=(-1.0, 0.5, 0.0))


def second_order(points, blocks):
    """The content of a file with nodes in the middle of all edges of volume cells and faces, in edges' order."""
    middles, found = {}, []
    for word, entity, physicals, rows in blocks:
        rows = np.asarray(rows)
        if word not in SECOND:
            found.append((word, entity, physicals, rows))
            continue
        sides = [(k, (k + 1) % rows.shape[1]) for k in range(rows.shape[1])]
        edges = ELEMENTS[word].edges if word in ELEMENTS else sides
        more = [
            [middles.setdefault(frozenset((row[a], row[b])), len(points) + len(middles)) for a, b in edges]
            for row in rows.tolist()
        ]
        found.append((SECOND[word], entity, physicals, np.concatenate([rows, np.array(more)], axis=1)))
    return np.concatenate([points, [np.asarray(points)[list(pair)].mean(axis=0) for pair in middles]]), found


def faces(entity, physicals, rows):
    """A block of faces, all triangles or all quadrilaterals: a triangle with four corners has one of them twice."""
    flat = rows[:, 0] == rows[:, 1] if rows.shape[1] == 4 else np.ones(len(rows), bool)
    assert flat.all() or not flat.any()
    return ("triangle", entity, physicals, rows[:, -3:]) if flat.all() else ("quad", entity, physicals, rows)


def gmsh_content(kind, ungrouped=False):
    """A box behind an orphan point: overlapping surface groups, one without a name, one name in two dimensions."""
    mesh = box(kind)
    points = np.insert(mesh.nodes, 3, [9.0, 9.0, 9.0], axis=0)
    row = np.array([i + (i >= 3) for i in range(mesh.node_count)])
    sides = {name: row[faces][:, ::-1] for name, faces in mesh.face_sets.items()}  # orientation must not matter
    blocks = [
        ("point", 1, [4], [[row[7]]]),
        ("point", 2, [4], [[3]]),
        ("line", 1, [1], [[row[0], row[1]], [row[1], row[2]]]),
        faces(1, [1, 2], sides["xmin"]),
        faces(2, [2], sides["xmax"]),
        faces(3, [9], sides["ymin"]),
        faces(4, [5], sides["zmax"]),
        (kind, 1, [1, 3], row[mesh.cells]),
    ]
    if ungrouped:
        blocks.insert(4, faces(5, [], sides["ymax"]))
    return points, blocks


class _Out:
    """Numbers as text or as bytes, one interface for both."""

    def __init__(self, binary):
        self.binary, self.data = binary, b""

    def text(self, line):
        self.data += line.encode() + b"\n"

    def numbers(self, code, *values):
        if self.binary:
            self.data += struct.pack(f"<{len(values)}{code}", *values)
        else:
            self.data += b" ".join(repr(float(v) if code == "d" else int(v)).encode() for v in values) + b" "

    def end(self):
        self.data += b"\n"


def _head(out, version, names):
    out.text("$MeshFormat")
    out.text(f"{version} {int(out.binary)} 8")
    if out.binary:
        out.numbers("i", 1)
        out.end()
    out.text("$EndMeshFormat")
    if names:
        out.text("$PhysicalNames")
        out.text(str(len(names)))
        for (dimension, tag), name in names.items():
            out.text(f'{dimension} {tag} "{name}"')
        out.text("$EndPhysicalNames")


def write_gmsh22(path, points, tags, blocks, names, binary):
    """blocks: (type word, entity, physical tags, rows into points). An element in two groups is written twice."""
    out = _Out(binary)
    _head(out, "2.2", names)
    out.text("$Nodes")
    out.text(str(len(points)))
    for tag, x in zip(tags, points, strict=True):
        out.numbers("i", tag)
        out.numbers("d", *x)
        if not binary:
            out.end()
    if binary:
        out.end()
    out.text("$EndNodes")
    out.text("$Elements")
    elements = [
        (word, physical, entity, row)
        for word, entity, physicals, rows in blocks
        for row in rows
        for physical in physicals or [0]
    ]
    out.text(str(len(elements)))
    for number, (word, physical, entity, row) in enumerate(elements, 1):
        nodes = [tags[i] for i in row]
        if binary:
            out.numbers("i", TYPES[word][0], 1, 2, number, physical, entity, *nodes)
        else:
            out.numbers("i", number, TYPES[word][0], 2, physical, entity, *nodes)
            out.end()
    if binary:
        out.end()
    out.text("$EndElements")
    path.write_bytes(out.data)


def write_gmsh41(path, points, tags, blocks, names, binary):
    """As `write_gmsh22`; groups belong to the entities."""
    out = _Out(binary)
    _head(out, "4.1", names)
    entities = [[b for b in blocks if TYPES[b[0]][1] == dimension] for dimension in range(4)]
    out.text("$Entities")
    out.numbers("Q", *[len(group) for group in entities])
    if not binary:
        out.end()
    for dimension, group in enumerate(entities):
        for _, entity, physicals, _ in group:
            out.numbers("i", entity)
            out.numbers("d", *[0.0] * (3 if dimension == 0 else 6))
            out.numbers("Q", len(physicals))
            out.numbers("i", *physicals)
            if dimension:
                out.numbers("Q", 0)
            if not binary:
                out.end()
    out.end()
    out.text("$EndEntities")
    out.text("$Nodes")
    out.numbers("Q", 1, len(points), min(tags), max(tags))
    out.numbers("i", 3, 1, 0)
    out.numbers("Q", len(points))
    out.numbers("Q", *tags)
    out.numbers("d", *np.asarray(points).ravel())
    out.end()
    out.text("$EndNodes")
    out.text("$Elements")
    count = sum(len(rows) for *_, rows in blocks)
    out.numbers("Q", len(blocks), count, 1, count)
    number = 0
    for word, entity, _, rows in blocks:
        out.numbers("i", TYPES[word][1], entity, TYPES[word][0])
        out.numbers("Q", len(rows))
        for row in rows:
            number += 1
            out.numbers("Q", number, *[tags[i] for i in row])
    out.end()
    out.text("$EndElements")
    path.write_bytes(out.data)


WRITERS = {"2.2": write_gmsh22, "4.1": write_gmsh41}
