"""What every rank of tests/test_ranks.py runs: `mpiexec -n P python rank_worker.py KIND`; the first one reports."""

import sys

import numpy as np

import tcontact as tc
from tcontact.device import ranks
from tcontact.device.exchange import Exchange
from tcontact.planning.partition.cut import cut_cells
from tcontact.planning.partition.parts import parts_of


def mesh_of(kind):
    """A small cube; all ranks make the same one."""
    return tc.box_mesh((1.0, 1.0, 1.0), (4, 4, 4), kind=kind)


def cell_force(mesh, cells, values):
    """Scatter a force of every cell to its corners [n, 3]: numbers of very different sizes."""
    force = np.zeros((mesh.node_count, 3))
    for cell in cells:
        force[mesh.cells[cell]] += values[cell]
    return force


def main(kind):
    """Add forces over the ranks; print the error, and what the acceptance table counts."""
    comm = ranks.communicator()
    size, rank = comm.Get_size(), comm.Get_rank()
    mesh = mesh_of(kind)
    parts = parts_of(mesh.blocks, mesh.node_count, cut_cells(mesh.blocks, mesh.node_count, size))
    own = parts[rank]
    random = np.random.default_rng(5)
    values = random.uniform(-1.0, 1.0, (mesh.cell_count, mesh.cells.shape[1], 3))
    values *= 10.0 ** random.integers(-6, 6, (mesh.cell_count, 1, 1))
    exchange = Exchange(comm, own.shared)
    force = cell_force(mesh, own.cells, values)[own.nodes]
    for _ in range(3):  # the requests are used again
        total = force.copy()
        exchange.add(total)
    whole = cell_force(mesh, np.arange(mesh.cell_count), values)[own.nodes]
    found = comm.gather((own.nodes, total, np.abs(total - whole).max() / np.abs(whole).max(), exchange.bytes_sent))
    exchange.free()
    if rank == 0:
        copies = {}
        for nodes, one, _, _ in found:
            for node, row in zip(nodes.tolist(), one, strict=True):
                copies.setdefault(node, set()).add(row.tobytes())
        expected = 3 * 24 * sum(len(places) for part in parts for _, places in part.shared)
        print("error", max(error for _, _, error, _ in found))
        print("copies", max(map(len, copies.values())))
        print("bytes", sum(sent for *_, sent in found) - expected)


if __name__ == "__main__":
    main(sys.argv[1])
