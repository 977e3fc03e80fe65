"""Rasterisation of triangles with a z-buffer, for surface pictures.

Edge functions E_k(p) = (b - a) x (p - a) of the edge a -> b opposite corner k; a pixel centre p is inside when all E_k
have the sign of the area, and E_k / area are its barycentric coordinates (Pineda, SIGGRAPH 1988). The inverse depth w
is linear on the screen, so the largest w wins and an attribute q is sum(b_k w_k q_k) / w. Corners lie on a grid of
1/256 pixel and within 2e5 pixels: every E_k is exact in float64, and with the top-left rule a pixel on a shared edge
belongs to exactly one of its triangles. One thread owns a band of rows and takes the triangles in order: on equal depth
the first one stays, whatever the number of threads.
"""

from functools import cache

from ..engine import ti
from ..lanes import GRAIN
from ..language.arguments import ARRAY, INDEX

BAND = 32  # pixel rows per thread
TABLE = 256  # colours in one colour table

Single = ti.types.ndarray(dtype=ti.f32, ndim=1)
Byte = ti.types.ndarray(dtype=ti.u8, ndim=1)


@ti.func
def span(first, last, dy, root):
    """Return columns [first, last) cut to where r - dy px may be positive (root = r/dy), plus one against rounding."""
    low, high = first, last
    if dy > 0.0:
        high = ti.min(last, ti.floor(root) + 2.0)
    if dy < 0.0:
        low = ti.max(first, ti.floor(root) - 1.0)
    return low, high


@ti.func
def inner(first, last, dy, r, slope):
    """Return columns [first, last) cut to where r - dy px is surely not negative, two less against rounding."""
    root = ti.floor(r * slope)
    high = ti.select(dy > 0.0, ti.min(last, root - 2.0), last)
    high = ti.select(dy == 0.0 and r < 1e-6, first, high)
    low = ti.select(dy < 0.0, ti.max(first, root + 3.0), first)
    return low, high


@ti.func
def least(dx, dy):
    """Return the smallest E of a pixel inside: 0 on the edges that own their pixels, else above 0.

    On the grid of the corners every E is a multiple of 2^-17.
    """
    return ti.select(dy < 0.0 or (dy == 0.0 and dx > 0.0), 0.0, 2.0**-20)


@ti.func
def coloured(q, s, table, colours: ti.template()):
    """Return the pixel of a value q (0..1) in a light s: (1 + table) << 24 | red, green, blue."""
    step = ti.cast(ti.min(1.0, ti.max(0.0, q)) * (TABLE - 1) + 0.5, ti.i32)
    entry = 3 * (table * TABLE + step)
    red = ti.cast(ti.min(255.0, colours[entry] * s + 0.5), ti.i32)
    green = ti.cast(ti.min(255.0, colours[entry + 1] * s + 0.5), ti.i32)
    blue = ti.cast(ti.min(255.0, colours[entry + 2] * s + 0.5), ti.i32)
    return ((1 + table) << 24) | (red << 16) | (green << 8) | blue


@ti.kernel
def draw_triangles(
    triangles: ti.i32,
    width: ti.i32,
    top: ti.i32,
    bottom: ti.i32,
    left: ti.i32,
    right: ti.i32,
    line: ti.f64,
    rows: INDEX,
    x: ARRAY,
    y: ARRAY,
    w: ARRAY,
    value: ARRAY,
    light: ARRAY,
    table: INDEX,
    edges: INDEX,
    ink: ARRAY,
    colours: Single,
    depth_behind: Single,
    depth_out: Single,
    pixel_out: INDEX,
):
    """Draw triangles into a window of a depth and a colour buffer; what stood there goes.

    in: number of triangles; width of the buffers, first and end row, first and end column of the window [pixel]; half
    width of a line [pixel]; first and end row of each triangle [2 triangles]; corners x, y [pixel, y down] and inverse
    depth w and value (0..1 along the colour table), all [3 triangles]; light (factor on the colour) and table (number
    of the colour table) [triangles]; edges [triangles] bit k set: the edge opposite corner k is a line; ink [triangles]
    darkness of lines 0..1; colours [tables * 256 * 3] in 0..255; depth_behind [height * width] inverse depth of what
    hides triangles, 0 = nothing.
    out: depth_out [height * width] inverse depth; pixel_out [height * width] (1 + table) << 24 | red, green, blue; 0
    where no triangle is seen.
    """
    for index in range(((bottom - top + BAND - 1) // BAND) * GRAIN):
        if index % GRAIN == 0:
            first_row = top + index // GRAIN * BAND
            end_row = ti.min(first_row + BAND, bottom)
            for row in range(first_row, end_row):  # brings the band into the cache
                for col in range(left, right):
                    depth_out[row * width + col] = depth_behind[row * width + col]
                    pixel_out[row * width + col] = 0
            for t in range(triangles):
                row0, row1 = ti.max(first_row, rows[2 * t]), ti.min(end_row, rows[2 * t + 1])
                if row0 >= row1:
                    continue
                x0, x1, x2 = x[3 * t], x[3 * t + 1], x[3 * t + 2]
                y0, y1, y2 = y[3 * t], y[3 * t + 1], y[3 * t + 2]
                area = (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)
                if area != 0.0:
                    col0 = ti.max(left, ti.cast(ti.ceil(ti.min(x0, x1, x2) - 0.5), ti.i32))
                    col1 = ti.min(right, ti.cast(ti.floor(ti.max(x0, x1, x2) - 0.5), ti.i32) + 1)
                    side = ti.select(area > 0.0, 1.0, -1.0)
                    # oriented edge directions: d0 = corner 1 -> 2, d1 = 2 -> 0, d2 = 0 -> 1
                    dx0, dy0 = side * (x2 - x1), side * (y2 - y1)
                    dx1, dy1 = side * (x0 - x2), side * (y0 - y2)
                    dx2, dy2 = side * (x1 - x0), side * (y1 - y0)
                    least0, least1, least2 = least(dx0, dy0), least(dx1, dy1), least(dx2, dy2)
                    per_area = side / area
                    w0, w1, w2 = w[3 * t], w[3 * t + 1], w[3 * t + 2]
                    q0, q1, q2 = value[3 * t], value[3 * t + 1], value[3 * t + 2]
                    even = q0 == q1 and q1 == q2  # one colour, but for the lines
                    plain = coloured(q0, light[t], table[t], colours)
                    far = 1e30  # distance of an edge that is not drawn as a line
                    reach = line + 0.5
                    length0 = ti.select((edges[t] & 1) != 0, 1.0 / ti.sqrt(dx0 * dx0 + dy0 * dy0), far)
                    length1 = ti.select((edges[t] & 2) != 0, 1.0 / ti.sqrt(dx1 * dx1 + dy1 * dy1), far)
                    length2 = ti.select((edges[t] & 4) != 0, 1.0 / ti.sqrt(dx2 * dx2 + dy2 * dy2), far)
                    slope0 = ti.select(dy0 != 0.0, 1.0 / dy0, 0.0)
                    slope1 = ti.select(dy1 != 0.0, 1.0 / dy1, 0.0)
                    slope2 = ti.select(dy2 != 0.0, 1.0 / dy2, 0.0)
                    # E beyond which a line does not reach; below all E where there is none
                    margin0 = ti.select((edges[t] & 1) != 0, reach / length0, -far)
                    margin1 = ti.select((edges[t] & 2) != 0, reach / length1, -far)
                    margin2 = ti.select((edges[t] & 4) != 0, reach / length2, -far)
                    fall = (dy0 * w0 + dy1 * w1 + dy2 * w2) * per_area  # of the inverse depth, from column to column
                    for row in range(row0, row1):
                        py = row + 0.5
                        # along a row E_k = r_k - dy_k px
                        r0 = dx0 * (py - y1) + dy0 * x1
                        r1 = dx1 * (py - y2) + dy1 * x2
                        r2 = dx2 * (py - y0) + dy2 * x0
                        first, last = span(col0 + 0.0, col1 + 0.0, dy0, r0 * slope0)
                        first, last = span(first, last, dy1, r1 * slope1)
                        first, last = span(first, last, dy2, r2 * slope2)
                        begin, end = ti.cast(first, ti.i32), ti.cast(last, ti.i32)
                        r0, r1, r2 = r0 - least0, r1 - least1, r2 - least2
                        p = begin + 0.5
                        while begin < end and ti.min(r0 - dy0 * p, r1 - dy1 * p, r2 - dy2 * p) < 0.0:
                            begin += 1
                            p = begin + 0.5
                        p = end - 0.5
                        while begin < end and ti.min(r0 - dy0 * p, r1 - dy1 * p, r2 - dy2 * p) < 0.0:
                            end -= 1
                            p = end - 0.5
                        r0, r1, r2 = r0 + least0, r1 + least1, r2 + least2
                        # columns without lines
                        first, last = inner(begin + 0.0, end + 0.0, dy0, r0 - margin0, slope0)
                        first, last = inner(first, last, dy1, r1 - margin1, slope1)
                        first, last = inner(first, last, dy2, r2 - margin2, slope2)
                        clear, clear_end = ti.cast(first, ti.i32), ti.cast(last, ti.i32)
                        if not even:
                            clear_end = clear
                        start = (r0 * w0 + r1 * w1 + r2 * w2) * per_area
                        for col in range(begin, end):
                            px = col + 0.5
                            inverse = start - fall * px
                            here = row * width + col
                            if ti.cast(inverse, ti.f32) > depth_out[here]:
                                depth_out[here] = ti.cast(inverse, ti.f32)
                                code = plain
                                if col < clear or col >= clear_end:
                                    e0, e1, e2 = r0 - dy0 * px, r1 - dy1 * px, r2 - dy2 * px
                                    away = ti.min(e0 * length0, e1 * length1, e2 * length2)  # from the nearest line
                                    if not even or away < reach:
                                        q = q0
                                        if not even:
                                            b0, b1, b2 = e0 * per_area * w0, e1 * per_area * w1, e2 * per_area * w2
                                            q = (b0 * q0 + b1 * q1 + b2 * q2) / inverse
                                        s = light[t] * (1.0 - ink[t] * ti.min(1.0, ti.max(0.0, reach - away)))
                                        code = coloured(q, s, table[t], colours)
                                pixel_out[here] = code


@cache
def make_resolve(factor: int):
    """Return the kernel that makes a picture of factor x factor samples a pixel."""

    @ti.kernel
    def resolve(
        width: ti.i32,
        ground: ti.i32,
        top: ti.i32,
        left: ti.i32,
        rows: ti.i32,
        columns: ti.i32,
        pixel: INDEX,
        pixel_behind: INDEX,
        background: Single,
        dark: ti.f64,
        shadow: Byte,
        image_out: Byte,
    ):
        """Average factor x factor samples to one pixel, in a window of the picture, where anything was drawn or falls.

        in: width of the picture [pixel]; number of the first colour table that takes shadows (all above do); first row
        and column, rows and columns of the window [pixel]; pixel [height factor * width factor] from `draw_triangles`,
        and pixel_behind, which is seen where pixel is 0; background [3 height], a colour for each row; dark: what a
        full shadow takes away from a colour (0..1); shadow [height * width] 0..255.
        out: image_out [height * width * 3] red, green, blue; pixels without samples and shadow stay.
        """
        for index in range(rows * GRAIN):  # a thread takes whole rows
            if index % GRAIN == 0:
                row = top + index // GRAIN
                for col in range(left, left + columns):
                    codes = ti.Vector.zero(ti.i32, factor * factor)
                    same, drawn = True, 0
                    for i, j in ti.static(ti.ndrange(factor, factor)):
                        codes[i * factor + j] = pixel[(row * factor + i) * width * factor + col * factor + j]
                        same = same and codes[i * factor + j] == codes[0]
                        drawn |= codes[i * factor + j]
                    out = 3 * (row * width + col)
                    if same and codes[0] != 0 and (codes[0] >> 24) <= ground:
                        image_out[out] = ti.cast((codes[0] >> 16) & 255, ti.u8)
                        image_out[out + 1] = ti.cast((codes[0] >> 8) & 255, ti.u8)
                        image_out[out + 2] = ti.cast(codes[0] & 255, ti.u8)
                    elif drawn != 0 or shadow[row * width + col] != 0:
                        shade = 1.0 - dark / 255.0 * shadow[row * width + col]
                        red, green, blue = 0.0, 0.0, 0.0
                        for i, j in ti.static(ti.ndrange(factor, factor)):
                            code = codes[i * factor + j]
                            if code == 0:
                                code = pixel_behind[(row * factor + i) * width * factor + col * factor + j]
                            if code == 0:
                                red += background[3 * row]
                                green += background[3 * row + 1]
                                blue += background[3 * row + 2]
                            else:
                                dim = ti.select((code >> 24) > ground, shade, 1.0)
                                red += dim * ((code >> 16) & 255)
                                green += dim * ((code >> 8) & 255)
                                blue += dim * (code & 255)
                        share = 1.0 / (factor * factor)
                        image_out[out] = ti.cast(red * share + 0.5, ti.u8)
                        image_out[out + 1] = ti.cast(green * share + 0.5, ti.u8)
                        image_out[out + 2] = ti.cast(blue * share + 0.5, ti.u8)

    return resolve
