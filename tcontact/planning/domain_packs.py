"""Pack the cells of a domain, the constants of their materials and the corners of its contact cells."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..base.memory import aligned
from ..kernels import lanes
from .cell_shapes import NUMBERS, STORED, shapes
from .domain import CellBlock, Domain
from .lumped_mass import masses_in_parts
from .packing import CHUNKS, WIDTH, Block, CellPacks, pack_blocks

CHUNK = 1 << 11  # packs whose shapes are computed at once
SAMPLE = 1 << 14  # cells, about, of whose edges the median is taken


def pack_domain(domain: Domain, chunks: int = CHUNKS, kept: Mapping[tuple[str, str], int] | None = None) -> CellPacks:
    """Pack the cells of a domain.

    kept: numbers of state of the quadrature points of a cell, by element and law; None: no law has state.
    """
    kept = kept or {}
    blocks = [
        Block(
            block.cells,
            WIDTH,
            domain.kinds.index(block.kind),
            place,
            len(block.contact),
            kept.get(block.kind, 0),
            STORED.get(block.variant, 0),
        )
        for place, block in zip(material_places(domain), domain.blocks, strict=True)
    ]
    return pack_blocks(blocks, len(domain.reference), len(domain.kinds), chunks)


def material_places(domain: Domain) -> list[int]:
    """Return where the constants of every block begin in `params`."""
    viscous = _viscous_numbers(domain)
    more = viscous + (1 if domain.mixed else 0)
    sizes = [more + len(block.material.parameters) for block in domain.blocks]
    return [lanes.MATERIALS + viscous + sum(sizes[:number]) for number in range(len(sizes))]


def _viscous_numbers(domain: Domain) -> int:
    """Return how many constants of viscosity stand before the parameters of every law."""
    if domain.viscosity is not None:
        return -lanes.VISCOSITY
    return -lanes.LAME if domain.dissipates else 0


def material_numbers(domain: Domain, block: CellBlock) -> list[float]:
    """Return the constants of a block in `params`, in the order of kernels/lanes.py."""
    material, viscosity = block.material, domain.viscosity
    numbers: list[float] = []
    if viscosity is not None:
        own = block.own.own
        parts = masses_in_parts(own.kind, block.body.body.mesh.nodes, own.cells, material.density)
        uneven = max(float((masses.mean(axis=1) / masses.min(axis=1)).max()) for _, masses in parts)
        speed, square = viscosity.linear * material.wave_speed, viscosity.quadratic * viscosity.quadratic
        numbers += [speed, square, material.density, uneven]
    if domain.dissipates:
        numbers += [material.lame_lambda, material.lame_mu]
    unit = [length_unit(domain.reference, block.cells)] if domain.mixed else []
    return [*numbers, *material.parameters, *unit]


def length_unit(reference: np.ndarray, cells: np.ndarray) -> float:
    """Return the length unit [m] of cells in mixed precision: the power of two next to the median of their first edges.

    reference: positions [n, 3] [m] of the nodes; cells [m, corners].
    """
    some = cells[:: 1 + len(cells) // SAMPLE]
    edges = np.linalg.norm(reference[some[:, 1]] - reference[some[:, 0]], axis=1)
    return float(2.0 ** np.round(np.log2(np.median(edges))))


def massless_count(domain: Domain) -> int:
    """Count the boundary nodes with massless components, which come first: contact nodes and their images."""
    contact = domain.contact
    if contact is None or contact.basis is None:
        return 0
    followers = 0 if domain.images is None else len(domain.images.followers_of(contact.nodes))
    return len(contact.nodes) + followers


def corner_lists(domain: Domain, packs: CellPacks) -> np.ndarray:
    """List the force rows of the corners of contact cells by boundary node: start of each [s + 1], then the rows.

    Corners of images count at their masters.
    """
    place = np.full(len(domain.reference), -1)
    place[domain.boundary] = np.arange(len(domain.boundary))
    cells = [block.contact_cells.reshape(-1) for block in domain.blocks]
    nodes = np.concatenate(cells)
    owner = place[nodes if domain.images is None else domain.images.master[nodes]]
    assert (owner >= 0).all()
    order = np.argsort(owner, kind="stable")
    starts = np.searchsorted(owner[order], np.arange(len(domain.boundary) + 1))
    return np.concatenate([starts + len(starts), packs.corners[order]])


def positions_and_shapes(domain: Domain, packs: CellPacks) -> np.ndarray:
    """Return the positions of the nodes, and behind them the stored shapes [pack, number, lane] of the cells."""
    points = domain.reference
    if packs.shapes == 0:
        return points
    result = aligned(int(packs.shape_places[-1]))
    result[: points.size] = points.ravel()
    result[points.size :] = 0.0
    for number, block in enumerate(domain.blocks):
        ordinary = block.cells[: len(block.cells) - len(block.contact)]
        for cells, part in ((ordinary, number), (block.contact_cells, number + len(domain.blocks))):
            if block.variant in STORED and len(cells):
                _store_shapes(result[packs.shape_places[part] : packs.shape_places[part + 1]], points, cells)
    return result


def _store_shapes(target: np.ndarray, points: np.ndarray, cells: np.ndarray) -> None:
    """Store the shapes of the cells of a block, the last of which fills up the last pack."""
    packs = target.reshape(-1, NUMBERS, WIDTH)
    for first in range(0, len(packs), CHUNK):
        pack = packs[first : first + CHUNK]
        own = np.minimum(np.arange(first * WIDTH, (first + len(pack)) * WIDTH), len(cells) - 1)
        pack[:] = shapes(points[cells[own]]).reshape(-1, WIDTH, NUMBERS).swapaxes(1, 2)
