"""Make structured meshes of rings, cylinders and balls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base.errors import InputError
from ..base.validate import choice, number, vector, whole
from .box import NODE_LIMIT, box_mesh
from .elements import ELEMENTS
from .geometry import FloatArray
from .mapped import between, join, merged, prisms, tetrahedra
from .mesh import Mesh

LOW = np.cos(np.radians(40.0))  # of the angle from the z axis to which the sets low and high of a ball reach
THIN = 1e-6  # smallest cell over the size of the mesh


def ring_mesh(
    inner: float,
    outer: float,
    length: float,
    cells: int,
    kind: str = "hex8",
    axis: str = "z",
    center: Sequence[float] = (0.0, 0.0, 0.0),
    across: int | None = None,
    layers: int | None = None,
    start: float = 0.0,
) -> Mesh:
    """Make a ring or tube of structured cells.

    inner, outer: radii [m]; length [m] along the axis "x", "y" or "z"; center: the middle of the axis [m]; cells: cells
    around, 3 at least; across, layers: cells between the radii and along the axis, None for as many as keep them about
    as long as wide (across: 3 at least); start: angle of the first corner [rad], right-handed about the axis from x on
    for "z", y for "x", z for "y"; kind: see `Mesh`.
    Its corners lie on both circles and its faces are flat. Face sets inner, outer, and its ends as in zmin, zmax.

    Raises `InputError` for radii and lengths that are not positive, an outer radius that is not above the inner one,
    counts that are no whole numbers, rings too thin for double precision, more nodes than a mesh can have.
    """
    inside, outside = _length("inner", inner), _length("outer", outer)
    height, kind, number_of_axis = _length("length", length), choice("kind", kind, ELEMENTS), _axis(axis)
    turns, first = whole("cells", cells, 3), number("start", start)
    if outside <= inside:
        raise InputError("outer", outer, "give a radius greater than `inner`")
    width = np.pi * (outside + inside) / turns
    rows = max(3, _even(outside - inside, width)) if across is None else whole("across", across, 1)
    stories = _even(height, width) if layers is None else whole("layers", layers, 1)
    _check_size((outside - inside) / rows, height / stories, outside, turns * (rows + 1) * (stories + 1))
    box = box_mesh((1.0, 1.0, 1.0), (turns, rows, stories), kind, (0.0, 0.0, -0.5))
    angle, radius = first - 2.0 * np.pi * box.nodes[:, 0], inside + (outside - inside) * box.nodes[:, 1]
    flat = np.stack([radius * np.cos(angle), radius * np.sin(angle), height * box.nodes[:, 2]], axis=1)
    turned = [(place + 2 - number_of_axis) % 3 for place in range(3)]  # keeps the cells right-handed
    size = np.array([outside, outside, height])
    nodes, numbers = merged(flat[:, turned], size[turned])
    sides = {"inner": "ymin", "outer": "ymax", f"{axis}min": "zmin", f"{axis}max": "zmax"}
    sets = {name: numbers[box.face_sets[side]] for name, side in sides.items()}
    return _placed(Mesh(nodes, numbers[box.cells], kind, face_sets=sets), center, np.zeros(3))


def cylinder_mesh(
    radius: float,
    length: float,
    cells: int,
    kind: str = "hex8",
    axis: str = "z",
    center: Sequence[float] = (0.0, 0.0, 0.0),
    layers: int | None = None,
) -> Mesh:
    """Make a solid cylinder: a square core, rounded a little, and a shell from its sides to the rim.

    radius, length [m]; axis: "x", "y" or "z"; center: the middle of the axis [m]; cells: cells along a quarter of the
    rim, as many as along a side of the core; half as many, 2 at least, from the core to the rim; layers: cells along
    the axis, None for as many as keep them about as long as wide at the rim; kind: see `Mesh`, wedge6 in two prisms a
    hexahedron with triangles at the ends, tet4 in twelve tetrahedra.
    Face sets rim, and its ends as in zmin, zmax; cell sets core and shell.

    Raises `InputError` for sizes that are not positive, counts that are no whole numbers, layers too thin for double
    precision, more nodes than a mesh can have.
    """
    radius, height = _length("radius", radius), _length("length", length)
    kind, along = choice("kind", kind, ELEMENTS), _axis(axis)
    quarter = whole("cells", cells, 1)
    stories = _even(height, np.pi / 2 * radius / quarter) if layers is None else whole("layers", layers, 1)
    steps = max(2, quarter // 2)
    _check_size(height / stories, height / stories, radius, ((quarter + 1) ** 2 + 4 * quarter * steps) * (stories + 1))
    core, middle = 0.5 * radius, 0.5 * height
    others = [place for place in range(3) if place != along]
    line = np.linspace(-1.0, 1.0, quarter + 1)
    layer = np.linspace(0.0, height, stories + 1)

    def thick(flat: FloatArray) -> FloatArray:  # [a, b, 2] to [a, b, layers + 1, 3]
        points = np.empty((*flat.shape[:2], len(layer), 3))
        points[..., others] = flat[:, :, None]
        points[..., along] = layer
        return points

    bulge = 1.0 + 0.15 * (1.0 - line**2)  # the core is rounded a little: better corners
    x, y = np.meshgrid(line, line, indexing="ij")
    blocks = [thick(core * np.stack([x * (1.0 + 0.15 * (1.0 - y**2)), y * (1.0 + 0.15 * (1.0 - x**2))], axis=-1))]
    shares = np.linspace(0.0, 1.0, steps + 1)
    angle = np.pi / 4 * line
    inner = core * np.stack([bulge, line], axis=1)
    outer = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for cosine, sine in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        spin = np.array([[cosine, sine], [-sine, cosine]])
        blocks.append(thick((inner[:, None] + shares[:, None] * (outer - inner)[:, None]) @ spin))
    low, high = 1e-6 * height, (1 - 1e-6) * height
    skin = {
        "rim": lambda c: (c[:, along] > low) & (c[:, along] < high),
        f"{axis}min": lambda c: c[:, along] <= low,
        f"{axis}max": lambda c: c[:, along] >= high,
    }
    mesh = join(blocks, skin, np.insert([radius, radius], along, height))
    mesh = {"hex8": lambda same: same, "tet4": tetrahedra, "wedge6": prisms}[kind](mesh)
    return _placed(mesh, center, np.insert([0.0, 0.0], along, -middle))


def ball_mesh(radius: float, cells: int, kind: str = "hex8", center: Sequence[float] = (0.0, 0.0, 0.0)) -> Mesh:
    """Make a solid ball: a rounded cube and six blocks from its sides to the skin.

    radius, center [m]; cells: cells along a quarter of a great circle, as many as along an edge of the cube; half as
    many, 1 at least, from the cube to the skin; kind: "hex8", or "tet4" for twelve tetrahedra a hexahedron.
    Face sets surface, and of it low and high, the faces within 40 degrees of the z axis on both sides; cell sets core
    and shell.

    Raises `InputError` for a radius that is not positive, a count that is no whole number, other kinds of cells, more
    nodes than a mesh can have.
    """
    radius, kind, quarter = _length("radius", radius), choice("kind", kind, ("hex8", "tet4")), whole("cells", cells, 1)
    steps = max(1, quarter // 2)
    _check_size(radius, radius, radius, (quarter + 1) ** 3 + 6 * quarter**2 * steps)
    line = np.linspace(-1.0, 1.0, quarter + 1)
    shares = np.linspace(0.0, 1.0, steps + 1)

    def rounded(cube: FloatArray) -> FloatArray:
        """Return the core's points for those of a cube from -1 to 1: half way between the cube and a ball."""
        length = np.linalg.norm(cube, axis=-1, keepdims=True)
        largest = np.abs(cube).max(axis=-1, keepdims=True)
        return np.asarray(0.5 * radius * cube * (0.5 + 0.6 * largest / np.where(length > 0.0, length, 1.0)))

    blocks = [rounded(np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1))]
    along, across = np.meshgrid(line, line, indexing="ij")
    for axis in range(3):
        for side in (-1.0, 1.0):
            flat = np.roll(np.stack([np.full_like(along, side), along, across], axis=-1), axis, axis=-1)
            even = np.tan(np.pi / 4 * flat)  # equal angles
            skin = radius * even / np.linalg.norm(even, axis=-1, keepdims=True)
            blocks.append(between(rounded(flat), skin, shares))
    sets = {
        "low": lambda c: c[:, 2] < -LOW * np.linalg.norm(c, axis=1),
        "high": lambda c: c[:, 2] > LOW * np.linalg.norm(c, axis=1),
        "surface": lambda c: np.ones(len(c), dtype=bool),
    }
    mesh = join(blocks, sets, radius)
    return _placed(mesh if kind == "hex8" else tetrahedra(mesh), center, np.zeros(3))


def _length(field: str, value: float) -> float:
    """Return a positive length [m] whose cube is a number too."""
    return number(field, value, low=1e-60, high=1e60)


def _axis(axis: str) -> int:
    """Return the number of an axis."""
    return "xyz".index(choice("axis", axis, ("x", "y", "z")))


def _even(length: float, width: float) -> int:
    """Return how many cells of a width make a length, 1 at least."""
    return max(1, round(min(length / width, float(NODE_LIMIT))))


def _check_size(thickness: float, layer: float, radius: float, nodes: int) -> None:
    """Refuse cells too thin for double precision and too many nodes."""
    if min(thickness, layer) < THIN * radius:
        remedy = f"the cells are thinner than {THIN:g} of the radius; use fewer cells, or other sizes"
        raise InputError("cells", f"of {min(thickness, layer):.3g} m", remedy)
    if nodes > NODE_LIMIT:
        raise InputError("cells", f"{nodes} nodes", f"more than {NODE_LIMIT} nodes; use fewer cells")


def _placed(mesh: Mesh, center: Sequence[float], start: FloatArray) -> Mesh:
    """Return a mesh moved by center + start [m]."""
    try:
        offset = vector("center", center) + start
        return mesh.translated(offset) if offset.any() else mesh
    except InputError as error:
        raise InputError("center", center, error.remedy) from error
