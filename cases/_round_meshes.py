"""Hex meshes of round bodies from mapped blocks: a core and a shell around it."""

from __future__ import annotations

import numpy as np

import tcontact as tc

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
SIDES = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (3, 0, 4, 7), (1, 2, 6, 5))


def graded(length: float, first: float, even: int, growth: float) -> np.ndarray:
    """Return points from 0 to length: `even` spacings of size `first`, then each `growth` times the one before."""
    sizes = [first] * even
    while sum(sizes) < length:
        sizes.append(sizes[-1] * growth)
    points = np.concatenate([[0.0], np.cumsum(sizes)])
    if even and len(sizes) > even:  # the graded part takes up what is left over, the even one stays
        rest = points[even + 1 :] - points[even]
        points[even + 1 :] = points[even] + rest * (length - points[even]) / rest[-1]
        return points
    return points * (length / points[-1])


def block(first: np.ndarray, last: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return points [a, b, k, 3] on the straight lines between two surfaces [a, b, 3], at the shares [k] of the way."""
    return first[:, :, None] + shares[:, None] * (last - first)[:, :, None]


def join(blocks: list[np.ndarray], skin, size: float) -> tc.Mesh:
    """Return one mesh of blocks of points [a, b, c, 3]; points closer than 1e-9 size become one node.

    skin: sets of outer faces by name, each a function of face centres [f, 3] that says which belong to it.
    """
    points, cells, start = [], [], 0
    for grid in blocks:
        count = np.array(grid.shape[:3])
        number = start + np.arange(count.prod()).reshape(count)
        corner = [number[tuple(slice(o, n - 1 + o) for o, n in zip(at, count, strict=True))].ravel() for at in CORNERS]
        cells.append(np.stack(corner, axis=1))
        points.append(grid.reshape(-1, 3))
        start += len(points[-1])
    nodes, connected = np.concatenate(points), np.concatenate(cells)
    _, kept, same = np.unique(np.rint(nodes / (1e-9 * size)), axis=0, return_index=True, return_inverse=True)
    nodes, connected = nodes[kept], same.ravel()[connected]
    x = nodes[connected]
    turned = np.einsum("ij,ij->i", np.cross(x[:, 1] - x[:, 0], x[:, 3] - x[:, 0]), x[:, 4] - x[:, 0]) < 0
    connected[turned] = connected[turned][:, [4, 5, 6, 7, 0, 1, 2, 3]]
    faces = connected[:, SIDES].reshape(-1, 4)
    _, where, many = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    outer = faces[where[many == 1]]
    centres = nodes[outer].mean(axis=1)
    return tc.Mesh(nodes, connected, "hex8", face_sets={name: outer[inside(centres)] for name, inside in skin.items()})


def disc(radius: float, cells: int, thickness: float, layers: int = 1) -> tc.Mesh:
    """Return a cylinder about the y axis from y = 0 to thickness with 4 times `cells` faces around its rim.

    A square core, rounded a little, and a shell from its sides to the rim. Face sets rim, ymin, ymax.
    """
    core = 0.5 * radius
    line = np.linspace(-1.0, 1.0, cells + 1)
    layer = np.linspace(0.0, thickness, layers + 1)

    def at(x, z):
        return np.stack([x, np.zeros_like(x), z], axis=-1)

    def thick(flat):  # [a, b, 3] to [a, b, layers + 1, 3]
        return flat[:, :, None] + layer[:, None] * np.array([0.0, 1.0, 0.0])

    bulge = 1.0 + 0.15 * (1.0 - line**2)  # the core is rounded a little: better corners
    x, z = np.meshgrid(line, line, indexing="ij")
    blocks = [thick(core * at(x * (1.0 + 0.15 * (1.0 - z**2)), z * (1.0 + 0.15 * (1.0 - x**2))))]
    shares = np.linspace(0.0, 1.0, max(2, cells // 2) + 1)
    angle = np.pi / 4 * line
    for turn in range(4):
        inner = core * np.stack([bulge, line], axis=1)
        outer = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[turn]
        spin = np.array([[c, s], [-s, c]])
        ring = (inner[:, None] + shares[:, None] * (outer - inner)[:, None]) @ spin
        blocks.append(thick(at(ring[..., 0], ring[..., 1])))
    low, high = 1e-6 * thickness, (1 - 1e-6) * thickness
    return join(
        blocks,
        {
            "rim": lambda c: (c[:, 1] > low) & (c[:, 1] < high),
            "ymin": lambda c: c[:, 1] <= low,
            "ymax": lambda c: c[:, 1] >= high,
        },
        radius,
    )


def quarter_bar(radius: float, length: float, cells: int) -> tc.Mesh:
    """Return the quarter x, y >= 0 of a cylinder about the z axis, from z = 0 on, with `cells` cells across its radius.

    A square core, rounded a little, and a shell of two blocks around it; the cells are about as long as wide. Face sets
    xmin, ymin (planes of symmetry), zmin, zmax and rim.
    """
    across = max(1, round(0.6 * cells))
    shares = np.linspace(0.0, 1.0, max(1, cells - across) + 1)
    height = np.linspace(0.0, length, max(1, round(length * cells / radius)) + 1)
    line = np.linspace(0.0, 1.0, across + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    core = 0.5 * radius * np.stack([x * (1.0 + 0.15 * (1.0 - y**2)), y * (1.0 + 0.15 * (1.0 - x**2))], axis=-1)
    angle = np.pi / 4 * line
    rim = radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)  # from the x axis to the diagonal
    grids = [core]
    for inner, outer in ((core[-1], rim), (core[:, -1], rim[:, ::-1])):
        grids.append(inner[:, None] + shares[:, None] * (outer - inner)[:, None])
    blocks = []
    for grid in grids:
        flat = np.concatenate([grid, np.zeros((*grid.shape[:2], 1))], axis=-1)
        blocks.append(flat[:, :, None] + height[:, None] * np.array([0.0, 0.0, 1.0]))
    tiny = 1e-6 * radius
    return join(
        blocks,
        {
            "xmin": lambda c: c[:, 0] < tiny,
            "ymin": lambda c: c[:, 1] < tiny,
            "zmin": lambda c: c[:, 2] < tiny,
            "zmax": lambda c: c[:, 2] > length - tiny,
            "rim": lambda c: (c[:, :2].min(axis=1) > tiny) & (c[:, 2] > tiny) & (c[:, 2] < length - tiny),
        },
        radius,
    )


def quarter_ball(radius: float, finest: float, even: int, growth: float = 1.3, cap: float = 0.4) -> tc.Mesh:
    """Return the quarter x, y >= 0 of a ball about 0, fine at its lowest point: `even` cells of size `finest` [m].

    Face sets xmin, ymin (planes of symmetry) and cap, the skin within `cap` radii of the axis at the bottom.
    """
    core = 0.5 * radius
    across = graded(core, finest * core / radius, even, growth)  # cells widen on the way out to the skin
    down = graded(1.0, finest / (radius - core), even, growth)  # shares of the way from the skin to the core
    up = graded(2.0 * core, (down[-1] - down[-2]) * (radius - core), 1, 1.1) - core
    shares = np.linspace(0.0, 1.0, 5)

    def sphere(inner):
        """Return where a point of the core's surface comes out: by equal angles, spread evenly near the axis."""
        return radius * inner / np.linalg.norm(inner, axis=-1, keepdims=True)

    def grid(*axes):
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    blocks = [grid(across, across, up)]
    bottom, top = (grid(across, across, np.array([z]))[:, :, 0] for z in (-core, core))
    blocks += [block(sphere(bottom), bottom, down), block(top, sphere(top), shares)]
    for axis in (0, 1):
        face = grid(*[np.array([core]) if j == axis else across for j in (0, 1)], up)
        face = face[0] if axis == 0 else face[:, 0]
        blocks.append(block(face, sphere(face), shares))
    tiny = 1e-6 * radius
    return join(
        blocks,
        {
            "xmin": lambda c: c[:, 0] < tiny,
            "ymin": lambda c: c[:, 1] < tiny,
            "cap": lambda c: (
                (np.linalg.norm(c, axis=1) > 0.98 * radius)
                & (c[:, :2].min(axis=1) > tiny)
                & (c[:, 2] < 0)
                & (np.hypot(c[:, 0], c[:, 1]) < cap * radius)
            ),
        },
        radius,
    )


def ball(radius: float, cells: int, kind: str = "hex8") -> tc.Mesh:
    """Return a ball about 0 with `cells` faces along a quarter of a great circle: a rounded cube in six shells.

    kind: hex8, or tet4 for the same hexahedra cut into tetrahedra. Face sets low and high, the skin within 40 degrees
    of the z axis on both sides.
    """
    line = np.linspace(-1.0, 1.0, cells + 1)
    shares = np.linspace(0.0, 1.0, max(1, cells // 2) + 1)

    def rounded(cube):
        """Return the core's points for those of a cube from -1 to 1: half way between the cube and a ball."""
        length = np.linalg.norm(cube, axis=-1, keepdims=True)
        largest = np.abs(cube).max(axis=-1, keepdims=True)
        return 0.5 * radius * cube * (0.5 + 0.6 * largest / np.where(length > 0.0, length, 1.0))

    blocks = [rounded(np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1))]
    along, across = np.meshgrid(line, line, indexing="ij")
    for axis in range(3):
        for side in (-1.0, 1.0):
            flat = np.roll(np.stack([np.full_like(along, side), along, across], axis=-1), axis, axis=-1)
            even = np.tan(np.pi / 4 * flat)  # equal angles
            skin = radius * even / np.linalg.norm(even, axis=-1, keepdims=True)
            blocks.append(block(rounded(flat), skin, shares))
    slope = np.cos(np.radians(40.0))
    mesh = join(
        blocks,
        {
            "low": lambda c: c[:, 2] < -slope * np.linalg.norm(c, axis=1),
            "high": lambda c: c[:, 2] > slope * np.linalg.norm(c, axis=1),
        },
        radius,
    )
    return mesh if kind == "hex8" else tetrahedra(mesh)


def tetrahedra(mesh: tc.Mesh) -> tc.Mesh:
    """Return a mesh of hexahedra cut into tetrahedra: two on each face, with a new node in the middle of the cell.

    The diagonal of a face starts at its corner of the lowest number, so that the cells on both sides agree. Face sets
    are those of the hexahedra.
    """
    count, cells = mesh.node_count, mesh.cells
    middles = count + np.arange(len(cells))

    def cut(faces):
        """Return the two triangles [2, f, 3] of faces [f, 4]."""
        first = faces.argmin(axis=1)[:, None]
        a, b, c, d = np.take_along_axis(faces, (first + np.arange(4)) % 4, axis=1).T
        return np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])

    tets = []
    for side in SIDES:
        for triangle in cut(cells[:, side]):
            tets.append(np.concatenate([triangle[:, ::-1], middles[:, None]], axis=1))
    nodes = np.concatenate([mesh.nodes, mesh.nodes[cells].mean(axis=1)])
    sets = {name: cut(faces).reshape(-1, 3) for name, faces in mesh.face_sets.items()}
    return tc.Mesh(nodes, np.concatenate(tets), "tet4", face_sets=sets)


def ring(
    inside: float, outside: float, thickness: float, cells: int, start: float = 0.0, kind: str = "hex8"
) -> tc.Mesh:
    """Return a ring about the z axis with `cells` cells around it, one along z, and a corner at the angle `start`.

    Across the ring there are as many cells as keep them about as long as wide, three at least. Face sets inner, outer.
    """
    across = max(3, round((outside - inside) * cells / (np.pi * (outside + inside))))
    box = tc.box_mesh((1.0, 1.0, thickness), (cells, across, 1), kind, (0.0, 0.0, -thickness / 2))
    angle, radius = start - 2.0 * np.pi * box.nodes[:, 0], inside + (outside - inside) * box.nodes[:, 1]
    nodes = np.stack([radius * np.cos(angle), radius * np.sin(angle), box.nodes[:, 2]], axis=1)
    _, first, number = np.unique(np.rint(nodes / (1e-9 * outside)), axis=0, return_index=True, return_inverse=True)
    sets = {name: number.ravel()[box.face_sets[side]] for name, side in (("inner", "ymin"), ("outer", "ymax"))}
    return tc.Mesh(nodes[first], number.ravel()[box.cells], kind, face_sets=sets)
