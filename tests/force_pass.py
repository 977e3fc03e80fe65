"""The force pass driven by itself, and the same force by NumPy, straight from the definitions."""

from itertools import product

import numpy as np
from oracle.meshes import HEX_TO_TETS

from tcontact.kernels import lanes
from tcontact.kernels.columns import CELL_SUMS, CELLS, NODE_SUMS
from tcontact.planning.packing import WIDTH, Block, pack_blocks

KINDS = ("hex8", "tet4", "wedge6")
LAWS = ("linear_elastic", "st_venant_kirchhoff", "neo_hookean", "mooney_rivlin")
LAM, MU = 0.7, 0.4
C1, C2, BULK = 0.15, 0.05, 0.5  # LAM and MU at small strains
MODULI = {"mooney_rivlin": (BULK, 2 * (C1 + 2 * C2), 4 * C2)}
HEX = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
WEDGES = np.array([[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]])


def block(kind, counts=(3, 2, 3), distortion=0.15, seed=0):
    """Distorted block of cells: nodes [n, 3], cells [m, corners], is_inner [n]."""
    shape = np.array(counts) + 1
    index = np.stack(np.meshgrid(*[np.arange(s) for s in shape], indexing="ij"), -1).reshape(-1, 3)
    base = index[np.all(index < counts, axis=1)]
    cells = np.ravel_multi_index((base[:, None] + HEX).reshape(-1, 3).T, shape).reshape(-1, 8)
    if kind != "hex8":
        parts = {"tet4": HEX_TO_TETS, "wedge6": WEDGES}[kind]
        cells = cells[:, parts].reshape(-1, parts.shape[1])
    nodes = index + distortion * np.random.default_rng(seed).uniform(-1, 1, index.shape)
    return nodes, cells, np.all((index > 0) & (index < counts), axis=1)


def gradients(kind):
    """dN/dr [points, corners, 3] and weights [points] in unit coordinates."""
    if kind == "tet4":
        return np.array([[(-1, -1, -1), (1, 0, 0), (0, 1, 0), (0, 0, 1)]], float), np.array([1 / 6])
    if kind == "wedge6":
        triangle = np.array([(-1, -1), (1, 0), (0, 1)])
        found = []
        for r, s, t in product((1 / 6, 2 / 3), (1 / 6, 2 / 3), 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)):
            if r + s < 1:
                area = np.array([1 - r - s, r, s])
                found.append(np.r_[np.c_[(1 - t) * triangle, -area], np.c_[t * triangle, area]])
        return np.array(found), np.full(6, 1 / 12)
    points = 0.5 + (HEX - 0.5) / np.sqrt(3)
    value = np.where(HEX[None] == 1, points[:, None], 1 - points[:, None])
    slope = np.broadcast_to(2.0 * HEX - 1, value.shape)
    parts = [np.prod(np.where(np.arange(3) == j, slope, value), axis=2) for j in range(3)]
    return np.stack(parts, axis=2), np.full(8, 1 / 8)


def law_energy_stress(law, h):
    """W and P = dW/dF, straight from the definitions [..., 3, 3]."""
    eye = np.eye(3)
    transposed = np.swapaxes(h, -1, -2)
    f = eye + h
    if law == "neo_hookean":
        j = np.linalg.det(f)[..., None, None]
        inverse = np.swapaxes(np.linalg.inv(f), -1, -2)
        w = MU / 2 * (np.sum(f * f, axis=(-1, -2)) - 3) - MU * np.log(j[..., 0, 0]) + LAM / 2 * (j[..., 0, 0] - 1) ** 2
        return w, MU * (f - inverse) + LAM * (j - 1) * j * inverse
    if law == "mooney_rivlin":
        c, j = np.swapaxes(f, -1, -2) @ f, np.linalg.det(f)
        first = np.trace(c, axis1=-2, axis2=-1)
        second = (first**2 - np.trace(c @ c, axis1=-2, axis2=-1)) / 2
        w = C1 * (first - 3) + C2 * (second - 3) - 2 * (C1 + 2 * C2) * np.log(j) + BULK / 2 * (j - 1) ** 2
        pull = (BULK * (j - 1) * j - 2 * (C1 + 2 * C2))[..., None, None] * np.swapaxes(np.linalg.inv(f), -1, -2)
        return w, 2 * C1 * f + 2 * C2 * (first[..., None, None] * f - f @ c) + pull
    strain = 0.5 * (h + transposed) if law == "linear_elastic" else 0.5 * (h + transposed + transposed @ h)
    trace = np.trace(strain, axis1=-2, axis2=-1)
    stress = LAM * trace[..., None, None] * eye + 2 * MU * strain
    w = LAM / 2 * trace**2 + MU * np.sum(strain**2, axis=(-1, -2))
    return w, stress if law == "linear_elastic" else f @ stress


def numpy_force(kind, law, nodes, cells, u):
    """(dW/du [n, 3], W, smallest det F) by einsum."""
    slope, weight = gradients(kind)
    a = np.einsum("ekc,pkj->epcj", nodes[cells], slope)
    dn = np.einsum("pkj,epjc->epkc", slope, np.linalg.inv(a))
    h = np.einsum("ekc,epkd->epcd", u[cells], dn)
    w, p = law_energy_stress(law, h)
    volume = weight * np.linalg.det(a)
    force = np.zeros_like(nodes)
    np.add.at(force, cells, np.einsum("ep,epcd,epkd->ekc", volume, p, dn))
    return force, np.sum(volume * w), np.linalg.det(np.eye(3) + h).min()


def contact_corners(blocks):
    """The nodes of the corners of all contact cells, block after block."""
    return np.concatenate([block.cells[len(block.cells) - block.contact :].ravel() for block in blocks])


class Step:
    """The kernel with its arrays for blocks of cells; the boundary nodes hand out their force."""

    def __init__(self, kind, law, nodes, cells, boundary=(), chunks=8, contact=0):
        self._prepare([(kind, law, cells, contact)], nodes, boundary, chunks)

    @classmethod
    def of_blocks(cls, blocks, nodes, boundary=(), chunks=8):
        """blocks: (kind, law, cells, contact cells at their end) of each."""
        step = cls.__new__(cls)
        step._prepare(blocks, nodes, boundary, chunks)
        return step

    def _prepare(self, blocks, nodes, boundary, chunks):
        self.kinds = tuple(dict.fromkeys((kind, law) for kind, law, _cells, _contact in blocks))
        self.materials, packed = [], []
        for kind, law, cells, contact in blocks:
            at = lanes.MATERIALS + len(self.materials)
            packed.append(Block(cells, WIDTH, self.kinds.index((kind, law)), at, contact))
            moduli = MODULI.get(law, (LAM, MU))
            self.materials += [*moduli]
        self.packs = packs = pack_blocks(packed, len(nodes), len(self.kinds), chunks)
        self.info = packs.with_boundary(np.array(boundary, dtype=int))
        self.corner_rows = None
        if len(packs.corners):
            place = np.argsort(boundary)[np.searchsorted(np.sort(boundary), contact_corners(packed))]
            order = np.argsort(place, kind="stable")
            starts = np.searchsorted(place[order], np.arange(len(boundary) + 1)) + len(boundary) + 1
            self.corner_rows = np.concatenate([starts, packs.corners[order]]).astype(np.int32)
        self.nodes = nodes.ravel().copy()
        self.mass = np.random.default_rng(2).uniform(0.5, 2.0, len(nodes))
        self.rows = np.zeros(3 * packs.row_count)
        self.special_force = np.zeros(max(1, 3 * len(boundary)))
        self.node_sums, self.cell_sums = np.zeros(NODE_SUMS * chunks), np.zeros(CELL_SUMS * packs.all_chunks)

    def __call__(self, u, v, kick_before=0.0, kick_after=1.0, drift=0.0, gravity=(0.0, 0.0, 0.0), free=0.0):
        packs = self.packs
        steps = [kick_before, kick_after, drift, *gravity]
        damping = [0.0] * (lanes.FREE - lanes.DAMPING)
        params = np.array([*steps, *damping, free, 0.0, packs.all_chunks, 0.0, *self.materials])
        from tcontact.kernels.language.bundles import Body
        from tcontact.kernels.language.signatures import arguments, signature_of
        from tcontact.kernels.step.internal_force import make_step

        body = {
            "body": Body(
                u=u, v=v, connectivity=packs.connectivity, chunk_table=packs.chunk_table, segments=packs.segments,
                corner_rows=self.corner_rows, node_info=self.info, position=self.nodes, mass=self.mass, params=params,
                rows=self.rows, special_force=self.special_force, node_sums=self.node_sums, cell_sums=self.cell_sums,
            )
        }  # fmt: skip
        step = make_step(self.kinds, signature_of(body), cornered=self.corner_rows is not None)
        step(0, packs.all_chunks, packs.chunks, *arguments(body))
        assert not self.rows[: 3 * packs.first_corner_row].any()

    @property
    def moduli(self):
        """Parameters of the law of the first block."""
        return self.materials[: len(MODULI.get(self.kinds[0][1], (LAM, MU)))]

    @moduli.setter
    def moduli(self, parameters):
        self.materials[: len(parameters)] = parameters

    def sums(self):
        """Elastic energy and the smallest det F of the last pass."""
        sums = self.cell_sums.reshape(-1, CELL_SUMS)
        return sums[:, CELLS.elastic].sum(), sums[:, CELLS.jacobian_min].min()

    def force(self, u):
        """(dW/du [n, 3], W, smallest det F); u stays as it is, bit for bit."""
        flat, v = np.ascontiguousarray(u).ravel().copy(), np.zeros(u.size)
        before = flat.tobytes()
        self(flat, v)
        assert flat.tobytes() == before
        return -v.reshape(-1, 3) * self.mass[:, None], *self.sums()
