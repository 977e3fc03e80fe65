"""Small meshes of several kinds of cells, cut out of boxes of hexahedra, and bodies of several materials on them."""

import numpy as np

import tcontact as tc
from tcontact.mesh.elements import ELEMENTS
from tcontact.mesh.geometry import jacobians

SIZE = np.array([0.06, 0.04, 0.06])
STEEL = tc.NeoHookean(2.3e7, 0.27, 1350.0)
OTHERS = {
    "stiff": tc.NeoHookean(6e7, 0.2, 3000.0),
    "rubber": tc.MooneyRivlin.of(1.2e7, 0.35, 1100.0),
    "linear": tc.LinearElastic(3e7, 0.3, 2000.0),
}


def cut(box, choose):
    """Cut the cells of a box of hexahedra; choose(centre) -> kind, or None to leave the cell out."""
    wanted = [choose(centre) for centre in box.cell_centres()]
    cells = {}
    for kind, element in ELEMENTS.items():
        mine = box.cells[[one == kind for one in wanted]]
        if len(mine):
            cells[kind] = mine[:, np.array(element.in_box)].reshape(-1, element.corners)
    used = np.unique(np.concatenate([part.reshape(-1) for part in cells.values()]))
    number = np.full(box.node_count, -1)
    number[used] = np.arange(len(used))
    nodes = box.nodes[used]
    sets = {"zmin": np.flatnonzero(nodes[:, 2] == nodes[:, 2].min()), "all": np.arange(len(nodes))}
    sets["zmax"] = np.flatnonzero(nodes[:, 2] == nodes[:, 2].max())
    return tc.Mesh(nodes, {kind: number[part] for kind, part in cells.items()}, node_sets=sets)


def beside(counts=(4, 2, 3), size=SIZE):
    """Hexahedra at x < 1/2, prisms beside them: contact cells at z = 0 of both kinds."""
    box = tc.box_mesh(size, counts)
    return cut(box, lambda centre: "hex8" if centre[0] < size[0] / 2 else "wedge6")


def corner(counts=(4, 2, 4), size=SIZE):
    """An L of all kinds: hexahedra at x < 1/2, prisms beside them, tetrahedra on the prisms."""
    box = tc.box_mesh(size, counts)

    def choose(centre):
        low = centre[2] < size[2] / 2
        return ("hex8" if low else None) if centre[0] < size[0] / 2 else ("wedge6" if low else "tet4")

    return cut(box, choose)


def shaken(mesh, amount=0.15, seed=3):
    """Move the inner nodes by up to this share of the shortest edge of the box."""
    inner = np.setdiff1d(np.arange(mesh.node_count), np.unique(mesh.boundary_faces()))
    nodes = np.array(mesh.nodes)
    move = np.random.default_rng(seed).uniform(-1.0, 1.0, (len(inner), 3))
    nodes[inner] += amount * mesh.shortest_edge * move
    return tc.Mesh(nodes, dict(mesh.blocks), mesh.kind, mesh.node_sets, mesh.face_sets, mesh.cell_sets)


def halves(mesh, axis=1, at=None):
    """Add the cell sets "low" and "high" by the centres of the cells along an axis."""
    along = mesh.cell_centres()[:, axis]
    middle = np.mean(mesh.bounds, axis=0)[axis] if at is None else at
    return mesh.with_sets(cell_sets={"low": np.flatnonzero(along < middle), "high": np.flatnonzero(along >= middle)})


def volume_by_points(mesh):
    """Volume [m^3] of a mesh from the Jacobians at the integration points."""
    total = 0.0
    for kind, cells in mesh.blocks:
        _values, gradients, weights = ELEMENTS[kind].rule
        total += sum((weights[:, None] * det).sum() for _, det, _ in jacobians(mesh.nodes, cells, gradients))
    return total
