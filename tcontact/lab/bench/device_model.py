"""What a step should take on a GPU by its bytes and operations: a model, beside which measured times stand.

    time = sum over the launches of max(bytes / bandwidth, operations / rate) + launches * LAUNCH

Bytes are those of planning/device_traffic.py. Operations of a cell are those that its machine code executes, counted
by fake_cuda.sh (tests/test_cuda_counts.py); a fused multiply-add is one operation.

With contact one block of threads more takes few boundary nodes, and the passes of the static solve: what it loads and
stores, counted there too, passes through one of the processors alone; the places of joint arrays (device/joint.py),
which all threads read alike, are left out. Many nodes are taken by several blocks in more launches
(planning/device_blocks.py), what they load and store counted as if no cache held it; between them launches of one block
combine sums. These times are the least: all that threads wait for within a launch comes on top, and the host, which
takes 4 to 6 us for every array that a launch names, as measured on an H100 when these were 13 to 58.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from ...mesh.elements import ELEMENTS, Element
from ...planning import device_blocks
from ...planning.cell_shapes import STORED
from ...planning.device_memory import Cells
from ...planning.device_traffic import Traffic, traffic
from .columns import columns

BANDWIDTH, RATE = 3.3e12, 1.4e13  # of an H100 [B/s], [f64 operations/s]
PROCESSORS, ONE_BANDWIDTH = 132, 1.1e11  # of an H100; of one of them: 64 B in a clock of 1.755 GHz [B/s]
LAUNCH = 3e-6  # between the starts of two short launches, about [s]
SIZES = (32, 128, 256)
VARIANTS = {  # kind of the benchmark -> element in the kernels
    "hex8": "hex8-box",
    "hex8-turned": "hex8-affine",
    "hex8-skew": "hex8-affine",
    "hex8-distorted": "hex8",
    "hex8-reduced": "hex8-reduced-affine",
    "hex8-mean-dilatation": "hex8-mean-dilatation-box",
    "tet4": "tet4-stored",
    "wedge6": "wedge6",
}
LAWS = ("linear", "neo-hookean", "mooney-rivlin", "st-venant-kirchhoff", "ogden")
# additions, products and fused ones of a cell, and its divisions and roots, by the laws above; None: not there
COUNTS: Mapping[str, tuple[tuple[int, int] | None, ...]] = {
    "hex8-box": ((1123, 1), (1587, 9), (2347, 9), (1667, 1), (7838, 265)),
    "hex8-affine": ((1553, 2), (2017, 10), (2777, 10), (2097, 2), (8268, 266)),
    "hex8": ((2023, 8), (2487, 16), (3239, 16), (2567, 8), (8730, 272)),
    "hex8-reduced-affine": ((297, 0), (356, 1), (450, 1), (365, 0), (1138, 33)),
    "hex8-mean-dilatation-box": ((1372, 2), (2022, 10), (2782, 10), None, (8265, 266)),
    "tet4-stored": ((128, 0), (186, 1), (280, 1), (196, 0), (968, 33)),
    "wedge6": ((1009, 6), (1357, 12), (1921, 12), (1417, 6), (6067, 204)),
}
DIVISION = 10  # operations of a division or a root, about
NODE_OPERATIONS, CORNER_OPERATIONS = 60, 3  # of a node, and for each of its corners


class Counted(NamedTuple):
    """Operations and bytes loaded and stored by one block of threads: of every contact node, and once."""

    operations: float
    moved: float
    operations_once: float
    moved_once: float

    def seconds(self, nodes: int) -> float:
        """Return the least time [s] for so many contact nodes."""
        operations = self.operations * nodes + self.operations_once
        return max((self.moved * nodes + self.moved_once) / ONE_BANDWIDTH, operations / (RATE / PROCESSORS))


class Spread(NamedTuple):
    """Launches of several blocks of threads, and of one block between them.

    operations, moved: of every contact node; by_block: bytes of every block; once: bytes of the launches of one block;
    launches: of all of them.
    """

    operations: float
    moved: float
    by_block: float
    once: float
    launches: int

    def seconds(self, nodes: int, blocks: int) -> float:
        """Return the least time [s] for so many contact nodes and blocks, without that between launches."""
        moved = self.moved * nodes + self.by_block * blocks
        speed = min(BANDWIDTH, min(blocks, PROCESSORS) * ONE_BANDWIDTH)
        return max(moved / speed, self.operations * nodes / RATE) + self.once / ONE_BANDWIDTH


class SpreadContact(NamedTuple):
    """What contact adds to a step where several blocks of threads take it: a solving pass and one that only judges.

    boundary: the boundary nodes; pass_: a pass without its solve; solve: by one block; sweep, end: of sweeps that are
    launched one by one, so many in a solving pass.
    """

    boundary: Spread
    pass_: Spread
    solve: Counted
    sweep: Spread
    end: Spread
    sweeps: int

    def seconds(self, nodes: int, blocks: int, swept: bool) -> tuple[float, float]:
        """Return the least time [s] of a step, and that between its launches; swept: sweeps are launched one by one."""
        parts = [self.boundary, self.pass_, self.pass_]
        work, more = 0.0, 2
        if swept:
            parts += [self.sweep] * self.sweeps + [self.end] * 2
            more = 0
        else:
            work = self.solve.seconds(nodes)
        work += sum(part.seconds(nodes, blocks) for part in parts)
        return work, (sum(part.launches for part in parts) + more) * LAUNCH


class Contact(NamedTuple):
    """What contact adds to a step: its boundary nodes, a pass that solves, one that finds no more to do; launches."""

    boundary: Counted
    solving: Counted
    judging: Counted
    launches: int


# of a cube of hexahedra on a plane that faces one side of it, by normal removal; a step has one pass of each sort
CONTACT: Mapping[str, Contact] = {
    "frictionless": Contact(
        Counted(325, 2991, 55770, 732726), Counted(724, 4662, 33130, 1077834), Counted(137, 756, 0, 64866), 5
    ),
    "friction, viscous cells": Contact(
        Counted(587, 4466, 73042, 1061785), Counted(736, 4799, 33221, 1077401), Counted(156, 903, 0, 64051), 6
    ),
}


# of the same where several blocks of threads take the nodes: hexahedra, four colours, ten sweeps in a solving pass
SOLVE, SWEEP, END = (
    Counted(578, 3528, 35430, 1066490),
    Spread(56, 351, 58097, 223496, 5),
    Spread(29, 420, 23030, 229584, 5),
)
SPREAD: Mapping[str, SpreadContact] = {
    "frictionless": SpreadContact(
        Spread(311, 2947, 81480, 92000, 3), Spread(1453, 1421, 37094, 39296, 5), SOLVE, SWEEP, END, sweeps=10
    ),
    "friction, viscous cells": SpreadContact(
        Spread(2533, 6007, 61353, 139000, 4), Spread(3481, 2748, 29201, 39320, 5), SOLVE, SWEEP, END, sweeps=10
    ),
}


def model(kind: str, law: str, size: int) -> dict[str, Any]:
    """Return bytes and operations per cell of a cube of size^3 hexes, and the time of a step [s] by both limits."""
    count, nodes, moved = size**3 * len(_element(kind).in_box), (size + 1) ** 3, moved_bytes(kind, size)
    operations = operations_of(kind, law)
    found = {"kind": kind, "law": law, "size": size, "cells": count}
    found |= {"read_per_cell": moved.read / count, "written_per_cell": moved.written / count}
    return found | {
        "operations_per_cell": operations,
        **_seconds(moved, operations, count, nodes, _element(kind).corners),
    }


def contact_seconds(size: int, contact: str) -> tuple[float, float]:
    """Return what contact adds to a step of a cube [s]: the least time of its work, and that between its launches."""
    own, nodes = CONTACT[contact], (size + 1) ** 2
    blocks = device_blocks.blocks_of(nodes)
    if blocks > 1:
        return SPREAD[contact].seconds(nodes, blocks, nodes >= device_blocks.MANY_SWEPT)
    block = sum(part.seconds(nodes) for part in (own.boundary, own.solving, own.judging))
    return block, own.launches * LAUNCH


def operations_of(kind: str, law: str) -> int | None:
    """Return the operations of a cell; None where they were not counted."""
    counts = COUNTS[VARIANTS[kind]][LAWS.index(law)] if law in LAWS else None
    return None if counts is None else counts[0] + DIVISION * counts[1]


def moved_bytes(kind: str, size: int) -> Traffic:
    """Return the bytes of a step of a cube of size^3 hexes."""
    element = _element(kind)
    cells = Cells(size**3 * len(element.in_box), element.corners, STORED.get(VARIANTS[kind], 0), 0)
    return traffic([cells], (size + 1) ** 3)


def _element(kind: str) -> Element:
    return ELEMENTS[kind.partition("-")[0]]


def _seconds(moved: Traffic, operations: int | None, cells: int, nodes: int, corners: int) -> dict[str, Any]:
    by_bytes = (moved.cells_read + moved.cells_written) / BANDWIDTH
    by_operations = 0.0 if operations is None else operations * cells / RATE
    node_operations = NODE_OPERATIONS * nodes + CORNER_OPERATIONS * corners * cells
    of_nodes = max((moved.nodes_read + moved.nodes_written) / BANDWIDTH, node_operations / RATE)
    step = max(by_bytes, by_operations) + of_nodes + moved.kept / BANDWIDTH + 2 * LAUNCH
    return {"step_s": step, "limit": "operations" if by_operations > by_bytes else "bytes"}


def rows(kinds: Iterable[str], laws: Sequence[str]) -> list[dict[str, Any]]:
    """Return the model of every kind of cells and law at SIZES; kinds without a kernel of their own are left out."""
    return [model(kind, law, size) for kind in kinds if kind in VARIANTS for law in laws for size in SIZES]


def lines(found: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the model as a table."""
    if not found:
        return []
    table = []
    for first in found[:: len(SIZES)]:
        own = [row for row in found if (row["kind"], row["law"]) == (first["kind"], first["law"])]
        largest = own[-1]
        count = largest["operations_per_cell"]
        cells = {"kind": first["kind"], "law": first["law"], "read B/cell": f"{largest['read_per_cell']:.0f}"}
        cells["written B/cell"] = f"{largest['written_per_cell']:.0f}"
        cells["f64 op/cell"] = "-" if count is None else f"{count}"
        cells |= {f"{row['size']}^3 ms": f"{1e3 * row['step_s']:.3g}" for row in own}
        table.append(cells | {"limit of the cells": largest["limit"]})
    return [
        "",
        f"MODEL, nothing measured: a step without contact on an H100 ({BANDWIDTH / 1e12:g} TB/s, {RATE:.2g} f64 op/s,"
        f" {1e6 * LAUNCH:g} us a launch); arrays read and written once a launch, operations where they were counted",
        *columns(table),
        *_with_contact(found),
    ]


def _with_contact(found: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the steps of hexahedra with contact as a table; nothing without hexahedra."""
    own = [row for row in found if row["kind"] == "hex8"][: len(SIZES)]
    if not own:
        return []
    table = []
    for contact in CONTACT:
        added = [contact_seconds(row["size"], contact) for row in own]
        cells = {"contact": contact, "law": own[0]["law"]}
        cells |= {
            f"{row['size']}^3 ms": f"{1e3 * (row['step_s'] + sum(more)):.3g}"
            for row, more in zip(own, added, strict=True)
        }
        table.append(cells | {"of it contact ms": f"{1e3 * sum(added[-1]):.3g}"})
    return ["", "the same with a contact face: at least", *columns(table)]
