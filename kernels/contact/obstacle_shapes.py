"""Gaps and unit normals of obstacles in their own axes: a block, and a distance sampled on a grid.

Block of half sizes h: q = |y| - h; outside |max(q, 0)|, inside the q of the face through which the node came, or max q.
Grid: D and grad D interpolated trilinearly between nodes; beyond the grid D(c) + grad D(c) . (y - c) from its nearest
point c; the normal is the unit vector along grad D. `Box.local` and `Sdf.local` compute this on the host.
"""

from ..engine import ti
from ..lanes import LEVEL

ALONG = 1.0 - 1e-9  # cosine from which two normals are one
EDGE = 8.0  # number of no face: a position begins on an edge or a corner


@ti.func
def box_gap_normal(y, half, entered):
    """Return the signed distance of y to the block, the normal out of it, and the number of the face that y is at.

    Faces have the numbers -3 .. 3 by axis and side. A position within the block belongs to the face `entered`, that of
    the last call, whichever is nearer: a node that lands beside an edge is held by the face on which it lands. 0: by
    the nearest one. What begins on an edge has the number EDGE and a bit for each axis of its faces, and then belongs
    to the one that it moves into.
    """
    outward = ti.Vector([0.0, 0.0, 0.0])
    deepest, depth, lowest = -1e300, -1e300, 1e300
    nearest, into, level, bits = 0.0, 0.0, 0, 0
    for i in ti.static(range(3)):
        side = 1.0
        if y[i] < 0.0:
            side = -1.0
        beyond = side * y[i] - half[i]
        outward[i] = side * ti.max(beyond, 0.0)
        if beyond > deepest:
            deepest, nearest = beyond, side * (i + 1.0)
        if entered == side * (i + 1.0):
            depth = beyond
        if entered >= EDGE and (int(entered - EDGE) >> i) & 1 == 1 and beyond < lowest:
            lowest, into = beyond, side * (i + 1.0)
        if ti.abs(beyond) <= LEVEL * half.max():
            level += 1
            bits += 2**i
    gap = outward.norm()
    at = nearest
    normal = outward / ti.max(gap, 1e-300)
    if gap <= LEVEL * half.max():
        if depth > -1e300:
            at, gap = entered, depth
        elif lowest < -LEVEL * half.max():
            at, gap = into, lowest
        else:
            gap = deepest
        normal = along_face(at)
        if depth == -1e300 and at == nearest and level > 1:
            at = EDGE + bits
    return gap, normal, at


@ti.func
def along_face(number):
    """Return the normal of the face of a block with this number."""
    return ti.Vector([ti.select(number == i + 1.0, 1.0, ti.select(number == -1.0 - i, -1.0, 0.0)) for i in range(3)])


@ti.func
def level_face(y, half, gap, normal):
    """Return the number of the face in one plane with another surface, to which y has this gap and normal; 0: none."""
    found = 0.0
    for i in ti.static(range(3)):
        side = 1.0
        if y[i] < 0.0:
            side = -1.0
        if ti.abs(side * y[i] - half[i] - gap) <= LEVEL * half.max() and side * normal[i] > ALONG:
            found = side * (i + 1.0)
    return found


@ti.func
def grid_gap_normal(grid: ti.template(), start, origin, spacing, nx, ny, nz, y):
    """Return signed distance and normal at y; grid: distance and gradient, four numbers a node, the first at `start`.

    origin: node 0 in the axes of y; spacing [m]; nx, ny, nz: nodes (whole numbers of any type), z running fastest.
    """
    count = ti.Vector([ti.cast(nx, ti.i32), ti.cast(ny, ti.i32), ti.cast(nz, ti.i32)])
    cell = ti.Vector([0, 0, 0])
    part = ti.Vector([0.0, 0.0, 0.0])
    beyond = ti.Vector([0.0, 0.0, 0.0])
    for i in ti.static(range(3)):
        scaled = (y[i] - origin[i]) / spacing
        within = ti.min(ti.max(scaled, 0.0), count[i] - 1.0)
        beyond[i] = (scaled - within) * spacing
        # clamped again as a whole number: a position that is no number must not lead out of the array
        cell[i] = ti.min(ti.max(ti.cast(within, ti.i32), 0), count[i] - 2)
        part[i] = within - cell[i]
    gap = 0.0
    gradient = ti.Vector([0.0, 0.0, 0.0])
    for a, b, c in ti.static(ti.ndrange(2, 2, 2)):
        node = start + 4 * (((cell[0] + a) * count[1] + cell[1] + b) * count[2] + cell[2] + c)
        # 1 - part or part
        weight = (1.0 - a + (2.0 * a - 1.0) * part[0]) * (1.0 - b + (2.0 * b - 1.0) * part[1])
        weight *= 1.0 - c + (2.0 * c - 1.0) * part[2]
        gap += weight * grid[node]
        for i in ti.static(range(3)):
            gradient[i] += weight * grid[node + 1 + i]
    gap += gradient.dot(beyond)
    normal = ti.Vector([0.0, 0.0, 1.0])
    length = gradient.norm()
    if length > 0.0:
        normal = gradient / length
    return gap, normal
