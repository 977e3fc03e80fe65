"""Pictures of a result: surface frames coloured by a field, an animation, the contact face at the largest force.

Needs no display: triangles go through `kernels/raster.py`, text through pillow.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import runtime
from .errors import InputError
from .vtkhdf import Frame, ResultData

if TYPE_CHECKING:
    from PIL import Image, ImageFont

FIELDS = {  # file name of a field: what the picture calls it, its unit, its colours
    "contact_pressure": ("Contact pressure", "Pa", "pressure"),
    "contact_force": ("Nodal contact force", "N", "pressure"),
    "von_mises": ("Von Mises stress", "Pa", "viridis"),
    "velocity": ("Speed", "m/s", "viridis"),
    "displacement": ("Displacement", "m", "viridis"),
    "body": ("Body", "", "viridis"),
}
FACES = {  # corners of the faces of a cell in VTK order, seen from outside counter-clockwise
    "tet4": ((0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 2, 1)),
    "hex8": ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)),
}
BACKGROUND = (250, 251, 253)
TEXT, FAINT_TEXT = (34, 40, 49), (108, 117, 129)
PLANE_TONES = ((219, 225, 233), (207, 214, 224))
INK = (72, 82, 96)
AXIS_COLOURS = ((196, 60, 52), (54, 138, 66), (48, 98, 186))
# colour tables in the order the raster sees them; those from `_SHADOWED` on take the body's shadow
_FIELD, _INK, _AXES, _OTHER_PLANES, _SHADOWED = 0, 1, 2, 5, 7
_FACTOR = 2  # samples per pixel along one axis


@dataclass(frozen=True)
class Camera:
    """Where to look from: `direction` points from the body to the eye, `up` is upward on the picture (any length).

    The distance follows from what must be visible.
    """

    direction: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Surface:
    """The boundary of a mesh as triangles: faces that belong to one cell only.

    A quadrilateral is cut into four triangles around its centre, so that its picture does not depend on a diagonal.
    nodes [s] mesh nodes on the boundary; quads [q,4], triangles [t,3] faces in local numbers (0..s-1); owner [q+t] cell
    of a face; corners [T,3] drawn triangles in local numbers, s+i = centre of quad i; face [T] their face; edges [T]
    bits of their real edges.
    """

    nodes: np.ndarray
    quads: np.ndarray
    triangles: np.ndarray
    owner: np.ndarray
    corners: np.ndarray
    face: np.ndarray
    edges: np.ndarray

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Nodal values [s] or [s,k] with the quad centres appended."""
        return np.concatenate([values, values[self.quads].mean(axis=1)])


def boundary_surface(blocks: Sequence[tuple[str, np.ndarray]]) -> Surface:
    """Surface of the mesh given as (kind, connectivity [m,k]) blocks."""
    found: dict[int, list[np.ndarray]] = {3: [], 4: []}
    owners: dict[int, list[np.ndarray]] = {3: [], 4: []}
    first = 0
    for kind, cells in blocks:
        local = np.array(FACES[kind])
        found[local.shape[1]].append(cells[:, local].reshape(-1, local.shape[1]))
        owners[local.shape[1]].append(np.repeat(np.arange(first, first + len(cells)), len(local)))
        first += len(cells)
    faces = {}
    for corners in (3, 4):
        if found[corners]:
            every, owner = np.concatenate(found[corners]), np.concatenate(owners[corners])
            once = _used_once(every)
            faces[corners] = every[once], owner[once]
        else:
            faces[corners] = np.empty((0, corners), dtype=np.int64), np.empty(0, dtype=np.int64)
    (triangles, triangle_owner), (quads, quad_owner) = faces[3], faces[4]
    nodes = np.unique(np.concatenate([triangles.ravel(), quads.ravel()]))
    triangles, quads = np.searchsorted(nodes, triangles), np.searchsorted(nodes, quads)
    centre = len(nodes) + np.arange(len(quads))
    fan = [np.stack([quads[:, k], quads[:, (k + 1) % 4], centre], axis=1) for k in range(4)]
    number = np.arange(len(quads) + len(triangles))
    return Surface(
        nodes,
        quads,
        triangles,
        np.concatenate([quad_owner, triangle_owner]),
        np.concatenate([*fan, triangles]),
        np.concatenate([np.tile(number[: len(quads)], 4), number[len(quads) :]]),
        np.repeat(np.array([4, 7], dtype=np.int32), [4 * len(quads), len(triangles)]),
    )


def render_frames(
    data: ResultData | Path | str,
    out: Path | str,
    field: str = "contact_pressure",
    size: tuple[int, int] = (960, 720),
    camera: Camera | None = None,
    deformation_scale: float = 1.0,
    obstacles: Sequence[Mapping[str, Any]] | None = None,
    fps: float | None = None,
    range: tuple[float, float] | None = None,
    view: str = "above",
    animation: bool = True,
) -> list[Path]:
    """Draw every frame of a result; returns the files written.

    `out`/frames/frame-0000.png ..., `out`/animation.gif, and, where bodies touched an obstacle, `out`/contact-face.png:
    the contact pressure seen from below at the instant of the largest contact force.

    field: any field of the file, vectors by their length, cell values one colour a face; size: picture [pixel]; camera:
    None = a three-quarter view of body and contact plane; deformation_scale: factor on displacements about each body's
    mean motion; obstacles: {"kind": "plane", "point": [3], "normal": [3]} each, None = those in the file's attributes;
    fps: frames per second of the animation, None = about six seconds in all; range: values at the two ends of the
    colours, None = those of the series, without the highest 0.2 %; view: "above" or "below" the first plane, which is
    then drawn as an outline. The attribute "title" of the file becomes the second line.
    Raises `InputError` for an unknown field (with those known), a file without frames and values out of place, before
    it writes.
    """
    data = data if isinstance(data, ResultData) else ResultData.open(data)
    if len(data) == 0:
        raise InputError("data", str(data.path), "the file holds no frames; run again with frames > 0")
    if not (len(size) == 2 and all(isinstance(n, (int, np.integer)) and 160 <= n <= 8192 for n in size)):
        raise InputError("size", size, "give width and height as whole numbers of pixels, 160 to 8192")
    if fps is not None and not (math.isfinite(fps) and fps > 0):
        raise InputError("fps", fps, "give a positive number of frames per second")
    if range is not None and not (len(range) == 2 and all(map(math.isfinite, range)) and range[0] < range[1]):
        raise InputError("range", range, "give two finite values, the lower one first")
    known = (*data.point_fields, *data.cell_fields)
    if field not in known:
        raise InputError("field", field, f"the file holds {', '.join(known)}")
    studio = _Studio(data, size, deformation_scale, obstacles)
    limits = range or studio.limits(field)
    eye = studio.camera(view, camera)
    out = Path(out)
    folder = out / "frames"
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for index, _ in enumerate(data.times):
        path = folder / f"frame-{index:04d}.png"
        studio.picture(data.frame(index), field, limits, eye).save(path, compress_level=3)
        written.append(path)
    for stale in set(folder.glob("frame-[0-9]*.png")) - set(written):
        stale.unlink()  # of an earlier, longer series
    if animation:
        written.append(animate(written, out / "animation.gif", fps or min(25.0, max(4.0, len(data) / 6)), field))
    return written + studio.contact_face(out / "contact-face.png", limits if field == "contact_pressure" else None)


def animate(pictures: Sequence[Path], path: Path, fps: float, field: str = "") -> Path:
    """Join pictures to a looping GIF with one palette for all, in which the colours of `field` get a fair part."""
    from PIL import Image

    chosen = sorted({round(k) for k in np.linspace(0, len(pictures) - 1, 8)})
    palette = _common_palette([np.asarray(Image.open(pictures[k]).convert("RGB")) for k in chosen], field)
    frames = [Image.open(p).convert("RGB").quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]
    duration = max(20, round(100 / fps) * 10)  # GIF counts hundredths of a second
    shared = bytes(palette.getpalette() or [])  # named here, it is written once and not with every frame
    frames[0].save(
        path, save_all=True, append_images=frames[1:], duration=duration, loop=0, optimize=False, palette=shared
    )
    return path


def _common_palette(images: Sequence[np.ndarray], field: str) -> Image.Image:
    """256 colours for all images [h,w,3]: frequent ones and the scenery exactly, the rest by shades, not by area."""
    from PIL import Image

    colours = np.concatenate([image[::2, ::2].reshape(-1, 3) for image in images]).astype(np.int64)
    code, count = np.unique(colours @ (65536, 256, 1), return_counts=True)
    frequent = code[np.argsort(-count, kind="stable")[:16]]
    tables = _tables(_colour_map(field)).reshape(-1, 256, 3).astype(np.int64)
    lit = [np.minimum(255, tables[_FIELD, ::8] * percent // 100) for percent in (82, 92, 102)]
    fixed = np.concatenate([*lit, tables[_FIELD, -1:], tables[_INK:_OTHER_PLANES, 0], *tables[_SHADOWED:, ::20]])
    exact = np.unique(np.concatenate([frequent, fixed @ (65536, 256, 1)]))
    coarse, count = np.unique(code & 0xFCFCFC, return_counts=True)
    weighed = np.repeat(coarse, np.minimum(8, count)) | 0x020202
    sample = np.stack([weighed >> 16, weighed >> 8 & 255, weighed & 255], axis=1).astype(np.uint8)
    mixed = Image.fromarray(sample[None]).quantize(colors=256 - len(exact), method=Image.Quantize.MEDIANCUT)
    table = [channel for c in exact for channel in (int(c) >> 16, int(c) >> 8 & 255, int(c) & 255)] + (
        mixed.getpalette() or []
    )
    palette = Image.new("P", (1, 1))
    palette.putpalette((table + [0] * 768)[:768])
    return palette


@dataclass(frozen=True)
class _Eye:
    """A placed camera: position [m], `axes` right, up, back, focal length and centre [pixel]; `fixed`: the scenery."""

    position: np.ndarray
    axes: np.ndarray
    focal: float
    centre: tuple[float, float]
    fixed: _Triangles
    shadow: tuple[np.ndarray, np.ndarray] | None  # point and normal of the plane that catches the shadow

    def project(self, points: np.ndarray) -> np.ndarray:
        """Points [n,3] to columns x, y [pixel], inverse depth [1/m]; NaN behind the eye."""
        right, up, back = ((points - self.position) @ self.axes.T).T
        inverse = 1.0 / np.where(back < 0, -back, np.nan)
        return np.stack(
            [self.centre[0] + self.focal * right * inverse, self.centre[1] - self.focal * up * inverse, inverse], 1
        )


@dataclass(frozen=True)
class _Triangles:
    """Input of the raster: screen [n,3,3] x, y, w of the corners; value, light [n,3]; table, edges, ink [n]."""

    screen: np.ndarray
    value: np.ndarray
    light: np.ndarray
    table: np.ndarray
    edges: np.ndarray
    ink: np.ndarray

    @staticmethod
    def plain(screen: np.ndarray, table: int | np.ndarray, value: np.ndarray | float = 0.0) -> _Triangles:
        n = len(screen)
        zero = np.zeros(n, dtype=np.int32)
        value = np.broadcast_to(value, (n, 3))
        return _Triangles(screen, value, np.ones((n, 3)), zero + np.int32(table), zero, np.zeros(n))

    @staticmethod
    def joined(parts: Sequence[_Triangles]) -> _Triangles:
        names = ("screen", "value", "light", "table", "edges", "ink")
        return _Triangles(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


class _Studio:
    """All that stays the same over a series: surface, planes, extent of the motion, buffers."""

    def __init__(
        self,
        data: ResultData,
        size: tuple[int, int],
        deformation_scale: float,
        obstacles: Sequence[Mapping[str, Any]] | None,
    ) -> None:
        if not math.isfinite(deformation_scale):
            raise InputError("deformation_scale", deformation_scale, "give a finite number")
        self.data, self.size, self.scale = data, (int(size[0]), int(size[1])), deformation_scale
        self.planes = _planes(data.attributes.get("obstacles", ()) if obstacles is None else obstacles)
        self.surface = boundary_surface(data.blocks)
        self.unit = self.size[1] / 720  # lengths of the layout are meant for 720 rows
        width, height = self.size
        samples = width * height * _FACTOR**2
        self.depth, self.pixel = np.zeros(samples, np.float32), np.zeros(samples, np.int32)
        self.mask_depth, self.mask = np.zeros(width * height, np.float32), np.zeros(width * height, np.int32)
        self.background = np.tile(np.array(BACKGROUND, dtype=np.float32), height)

    def values(self, frame: Frame, field: str) -> tuple[np.ndarray, bool]:
        """Scalars on the surface: (nodes [s], True) or (faces [q+t], False)."""
        nodal = field in frame.point_data
        array = frame.point_data[field][self.surface.nodes] if nodal else frame.cell_data[field][self.surface.owner]
        return np.linalg.norm(array, axis=1) if array.ndim == 2 else array.astype(np.float64), nodal

    def limits(self, field: str) -> tuple[float, float]:
        """Ends of the colours over the series: round numbers around what is there, without rare peaks."""
        low, high = 0.0, 0.0
        for index in range(len(self.data)):
            values, _ = self.values(self.data.frame(index), field)
            values = values[np.isfinite(values) & (values != 0)]
            if len(values):
                low, high = min(low, *np.quantile(values, [0.002])), max(high, *np.quantile(values, [0.998]))
        top = _round_up(max(high, -low))
        return (-top if low < 0 else 0.0), top

    def positions(self, frame: Frame) -> np.ndarray:
        """Deformed surface nodes [s,3]."""
        start = self.data.points[self.surface.nodes]
        moved = frame.point_data.get("displacement")
        if moved is None:
            return start
        moved = moved[self.surface.nodes]
        if self.scale != 1.0:
            for nodes in self.bodies:
                mean = moved[nodes].mean(axis=0)
                moved[nodes] = mean + self.scale * (moved[nodes] - mean)
        return start + moved

    @cached_property
    def bodies(self) -> list[np.ndarray]:
        """Surface nodes of each body (local numbers); one list when the file names no bodies."""
        surface = self.surface
        if "body" not in self.data.cell_fields:
            return [np.arange(len(surface.nodes))]
        body = self.data.frame(0).cell_data["body"][surface.owner]
        of_node = np.zeros(len(surface.nodes), dtype=np.int64)
        for faces, first in ((surface.quads, 0), (surface.triangles, len(surface.quads))):
            of_node[faces] = body[first : first + len(faces), None]
        return [np.flatnonzero(of_node == number) for number in np.unique(of_node)]

    def extent(self, frames: Iterable[Frame]) -> np.ndarray:
        """Points [k,3] whose hull holds the body in these frames; frames of a body blown up are left out."""
        rng = np.random.default_rng(0)
        ways = np.concatenate([np.eye(3), rng.normal(size=(29, 3))])
        start = self.data.points[self.surface.nodes]
        sound = 3 * np.linalg.norm(np.ptp(start, axis=0)) * max(1.0, abs(self.scale))
        points = []
        for frame in frames:
            x = self.positions(frame)
            if np.isfinite(x).all() and np.linalg.norm(np.ptp(x, axis=0)) <= sound:
                along = x @ ways.T
                points.append(x[np.concatenate([along.argmin(axis=0), along.argmax(axis=0)])])
        return np.concatenate(points) if points else start

    def camera(self, view: str, camera: Camera | None = None, frames: Iterable[Frame] | None = None) -> _Eye:
        """Place the eye so that body, in these frames or over the whole run, and contact plane fill the picture."""
        if view not in ("above", "below"):
            raise InputError("view", view, "use 'above' or 'below'")
        up = self.planes[0][1] if self.planes else np.array([0.0, 0.0, 1.0])
        if camera is None:
            first = np.eye(3)[np.argmin(np.abs(up))]
            first = first - up * (first @ up)
            first /= np.linalg.norm(first)
            second = np.cross(up, first)
            rise = math.radians(20 if view == "above" else -58)
            turns = np.radians((-60 if view == "above" else -76) + 30 * np.arange(12))
            ways = [math.cos(rise) * (math.cos(a) * first + math.sin(a) * second) + math.sin(rise) * up for a in turns]
            direction = max(ways, key=lambda way: sum(normal @ way > 0.05 for _, normal in self.planes[1:]))
        else:
            direction, up = np.array(camera.direction, float), np.array(camera.up, float)
            if not np.linalg.norm(np.cross(direction, up)) > 0:
                raise InputError("camera", camera, "direction and up must be finite, not zero and not parallel")
        back = direction / np.linalg.norm(direction)
        right = np.cross(up, back)
        right /= np.linalg.norm(right)
        axes = np.array([right, np.cross(back, right), back])

        body = self.extent(self.data.frame(i) for i in range(len(self.data))) if frames is None else self.extent(frames)
        seen, patches = [body], []
        for number, (point, normal) in enumerate(self.planes):
            patch = _Patch.under(body, point, normal, shadowed=number == 0)
            in_front = normal @ back > 0
            patches.append((patch, in_front))
            seen.append(patch.rim(0.72 if in_front else 0.8))
        u = self.unit
        left, top, width, height = 24 * u, 74 * u, self.size[0] - 146 * u, self.size[1] - 104 * u
        slope = 0.2  # tangent of half the opening angle: mild perspective
        focal = height / 2 / slope
        position = _fitted(np.concatenate(seen) @ axes.T, width / 2 / focal, slope) @ axes
        empty = _Triangles.plain(np.empty((0, 3, 3)), 0)
        eye = _Eye(position, axes, focal, (left + width / 2, top + height / 2), empty, None)
        parts = [patch.tiles(eye) if in_front else patch.outline(eye, u) for patch, in_front in patches]
        parts.append(_triad(axes, 52 * u, self.size[1] - 52 * u, u))
        shadow = self.planes[0] if patches and patches[0][1] else None
        return _Eye(eye.position, axes, focal, eye.centre, _Triangles.joined(parts), shadow)

    def picture(self, frame: Frame, field: str, limits: tuple[float, float], eye: _Eye, note: str = "") -> Image.Image:
        """Draw one frame [height, width, RGB]."""
        from PIL import Image

        if not runtime.threads():
            runtime.start()
        from .kernels import raster

        values, nodal = self.values(frame, field)
        x = self.surface.spread(self.positions(frame))
        body = self._body(x, values, nodal, limits, eye)
        width, height = self.size
        shade = self._shadow(x, eye)
        colours = _tables(_colour_map(field))
        raster.clear(len(self.pixel), self.depth, self.pixel)
        scene = _Triangles.joined([body, eye.fixed])  # near things first: less to draw twice
        _draw(scene, width * _FACTOR, height * _FACTOR, _FACTOR, 0.6 * self.unit, colours, self.depth, self.pixel)
        image = np.zeros(width * height * 3, np.uint8)
        raster.resolve(width, height, _FACTOR, _SHADOWED, self.pixel, self.background, shade, image)
        picture = Image.fromarray(image.reshape(height, width, 3))
        peak = float(np.max(values, initial=-np.inf, where=np.isfinite(values)))
        _decorate(picture, self, eye, field, limits, frame.time, peak, note)
        return picture

    def contact_face(self, path: Path, limits: tuple[float, float] | None = None) -> list[Path]:
        """The key picture of a run that touched something; [] where there is nothing to show."""
        if "contact_pressure" not in self.data.point_fields or not self.planes:
            return []
        forces = []
        for index in range(len(self.data)):
            nodal = self.data.frame(index).point_data
            total = nodal["contact_force"].sum(axis=0) if "contact_force" in nodal else nodal["contact_pressure"].sum()
            forces.append(float(np.nan_to_num(np.linalg.norm(total), posinf=0.0)))
        if max(forces) == 0.0:
            return []
        frame = self.data.frame(int(np.argmax(forces)))
        force = ""
        if "contact_force" in frame.point_data:
            factor, prefix = _prefix(max(forces))
            force = f": {max(forces) / factor:.3g} {prefix}N"
        limits = limits or self.limits("contact_pressure")
        eye = self.camera("below", frames=[frame])
        self.picture(frame, "contact_pressure", limits, eye, f"largest contact force{force}").save(path)
        return [path]

    def _body(
        self, x: np.ndarray, values: np.ndarray, nodal: bool, limits: tuple[float, float], eye: _Eye
    ) -> _Triangles:
        surface = self.surface
        level = (values - limits[0]) / (limits[1] - limits[0])
        level = np.nan_to_num(level, nan=0.0, posinf=1.0, neginf=0.0)
        value = surface.spread(level)[surface.corners] if nodal else np.repeat(level[surface.face][:, None], 3, axis=1)
        quads, triangles = x[surface.quads], x[surface.triangles]
        with np.errstate(all="ignore"):
            normal = np.concatenate(
                [
                    np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]),
                    np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]),
                ]
            )
            normal = normal / np.linalg.norm(normal, axis=1)[:, None] @ eye.axes.T
        key = np.array([-0.42, 0.72, 0.55])
        light = 0.74 + 0.18 * np.maximum(0.0, normal @ (key / np.linalg.norm(key))) + 0.2 * np.abs(normal[:, 2])
        light = np.nan_to_num(light, nan=0.7)[surface.face]
        screen = eye.project(x)[surface.corners]
        edge = np.linalg.norm(screen[:, 0, :2] - screen[:, 1, :2], axis=1)
        length = float(np.nanmedian(edge)) / self.unit if np.isfinite(edge).any() else 0.0
        ink = np.full(len(screen), 0.38 * min(1.0, max(0.0, (length - 2.5) / 9)))
        table = np.full(len(screen), _FIELD, dtype=np.int32)
        return _Triangles(screen, value, np.repeat(light[:, None], 3, axis=1), table, surface.edges, ink)

    def _shadow(self, x: np.ndarray, eye: _Eye) -> np.ndarray:
        from PIL import Image, ImageFilter

        from .kernels import raster

        width, height = self.size
        if eye.shadow is None:
            return np.ones(width * height, np.float32)
        point, normal = eye.shadow
        ray = -normal + 0.3 * eye.axes[0] - 0.1 * np.cross(eye.axes[0], normal)
        gap = np.maximum(0.0, (x - point) @ normal)
        fallen = x - normal * ((x - point) @ normal)[:, None] + (ray + normal) * gap[:, None]
        flat = _Triangles.plain(eye.project(fallen)[self.surface.corners], 0)
        raster.clear(len(self.mask), self.mask_depth, self.mask)
        _draw(flat, width, height, 1, 0.0, np.zeros(768, np.float32), self.mask_depth, self.mask)
        mask = Image.fromarray((self.mask != 0).reshape(height, width).astype(np.uint8) * 255)
        soft = np.asarray(mask.filter(ImageFilter.BoxBlur(4 * self.unit)).filter(ImageFilter.BoxBlur(3 * self.unit)))
        return (1.0 - np.float32(0.26 / 255) * soft.astype(np.float32)).ravel()


@dataclass(frozen=True)
class _Patch:
    """The part of a plane that is drawn: a disc of chequered tiles that fades into the background."""

    centre: np.ndarray
    first: np.ndarray
    second: np.ndarray
    radius: float
    shadowed: bool

    @staticmethod
    def under(points: np.ndarray, point: np.ndarray, normal: np.ndarray, shadowed: bool) -> _Patch:
        first = np.eye(3)[np.argmin(np.abs(normal))]
        first = first - normal * (first @ normal)
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        a, b = (points - point) @ first, (points - point) @ second
        centre = point + first * (a.min() + a.max()) / 2 + second * (b.min() + b.max()) / 2
        radius = max(0.95 * math.hypot(np.ptp(a), np.ptp(b)), 0.35 * np.ptp((points - point) @ normal))
        return _Patch(centre, first, second, radius, shadowed)

    def rim(self, part: float) -> np.ndarray:
        turn = np.radians(np.arange(0, 360, 15))
        return self.at(part * self.radius * np.cos(turn), part * self.radius * np.sin(turn))

    def at(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return self.centre + np.multiply.outer(a, self.first) + np.multiply.outer(b, self.second)

    def tiles(self, eye: _Eye) -> _Triangles:
        count, parts = 14, 3  # tiles along a diameter; pieces of a tile, for a smooth fade
        line = np.linspace(-self.radius, self.radius, count * parts + 1)
        a, b = np.meshgrid(line, line, indexing="ij")
        screen = eye.project(self.at(a, b).reshape(-1, 3))
        fade = np.clip((np.hypot(a, b).ravel() / self.radius - 0.45) / 0.55, 0.0, 1.0)
        ids = np.arange(a.size).reshape(a.shape)
        quads = np.stack([ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]], axis=-1)
        tile = np.arange(count * parts) // parts
        tone = ((tile[:, None] + tile[None, :]) % 2).ravel()
        quads = quads.reshape(-1, 4)
        inside = fade[quads].min(axis=1) < 1.0
        quads, tone = quads[inside], tone[inside]
        corners = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        table = np.tile(tone, 2) + (_SHADOWED if self.shadowed else _OTHER_PLANES)
        return _Triangles.plain(screen[corners], table, fade[corners])

    def outline(self, eye: _Eye, unit: float) -> _Triangles:
        side = 0.58 * self.radius
        square = self.at(np.array([-side, side, side, -side]), np.array([-side, -side, side, side]))
        line = eye.project(square)
        return _ribbons(line, np.roll(line, -1, axis=0), 0.9 * unit, _INK)


def _planes(obstacles: Sequence[Mapping[str, Any]]) -> list[tuple[np.ndarray, np.ndarray]]:
    planes = []
    for index, obstacle in enumerate(obstacles):
        if obstacle.get("kind") != "plane":
            raise InputError(f"obstacles[{index}] kind", obstacle.get("kind"), "only 'plane' can be drawn")
        point, normal = (np.array(obstacle.get(key, ()), dtype=np.float64) for key in ("point", "normal"))
        if point.shape != (3,) or normal.shape != (3,) or not np.isfinite([point, normal]).all() or not normal.any():
            raise InputError(
                f"obstacles[{index}]", dict(obstacle), "give a finite point [3] and a normal [3] that is not zero"
            )
        planes.append((point, normal / np.linalg.norm(normal)))
    return planes


def _used_once(faces: np.ndarray) -> np.ndarray:
    """Indices of the faces [f,k] whose set of nodes occurs once, in their order."""
    key = np.sort(faces, axis=1)
    order = np.lexsort(key.T)
    new = np.concatenate([[True], (np.diff(key[order], axis=0) != 0).any(axis=1), [True]])
    return np.sort(order[new[:-1] & new[1:]])


def _fitted(points: np.ndarray, slope_x: float, slope_y: float) -> np.ndarray:
    """Eye in camera axes from which all points [n,3] (same axes) lie within the slopes, as close as possible."""
    x, y, z = points.T
    distances, centres = [], []
    for across, slope in ((x, slope_x), (y, slope_y)):
        one, other = (across + slope * z).max(), (-across + slope * z).max()
        distances.append((one + other) / (2 * slope))
        centres.append((one - other) / 2)
    return np.array([*centres, max(*distances, z.max() + 1e-9 + 1e-3 * np.ptp(points, axis=0).max())])


def _ribbons(start: np.ndarray, end: np.ndarray, half: float, table: int | np.ndarray) -> _Triangles:
    """Lines [n,3] on the screen as two triangles each, `half` pixels to either side."""
    along = end[:, :2] - start[:, :2]
    aside = np.zeros_like(start)
    aside[:, :2] = (
        half * np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None].clip(1e-9)
    )
    screen = np.concatenate(
        [
            np.stack([start - aside, end - aside, end + aside], 1),
            np.stack([start - aside, end + aside, start + aside], 1),
        ]
    )
    return _Triangles.plain(screen, np.tile(np.broadcast_to(table, len(start)), 2))


def _triad(axes: np.ndarray, x: float, y: float, unit: float) -> _Triangles:
    """The coordinate directions in the lower left corner."""
    end = np.array([[x, y, 0.0]]) + 30 * unit * axes.T * np.array([1.0, -1.0, 0.0])
    depth = 1e6 + axes.T[:, 2]  # in front of everything, nearer axes first
    start, end = np.stack([np.full(3, x), np.full(3, y), depth], 1), np.stack([*end.T[:2], depth], 1)
    return _ribbons(start, end, 1.3 * unit, _AXES + np.arange(3))


def _draw(
    scene: _Triangles,
    width: int,
    height: int,
    factor: int,
    line: float,
    colours: np.ndarray,
    depth: np.ndarray,
    pixel: np.ndarray,
) -> None:
    from .kernels import raster

    screen = scene.screen * (factor, factor, 1.0)
    # far outside the picture the products of the raster would lose their exactness: leave such triangles out
    good = np.isfinite(screen).all(axis=(1, 2))
    good &= (np.abs(screen[..., :2]) < 2e5).all(axis=(1, 2))
    grid = np.round(screen[good, :, :2] * 256) / 256
    raster.draw_triangles(
        int(good.sum()),
        width,
        height,
        line * factor,
        np.ascontiguousarray(grid[..., 0]).ravel(),
        np.ascontiguousarray(grid[..., 1]).ravel(),
        np.ascontiguousarray(screen[good, :, 2]).ravel(),
        scene.value[good].ravel(),
        scene.light[good].ravel(),
        scene.table[good].astype(np.int32),
        scene.edges[good].astype(np.int32),
        scene.ink[good],
        colours,
        depth,
        pixel,
    )


def _colour_map(field: str) -> str:
    return FIELDS[field][2] if field in FIELDS else "viridis"


@cache
def colour_table(name: str) -> np.ndarray:
    """The 256 colours [256,3] (0..255) of a map of matplotlib; "pressure" is its YlOrRd with grey for nothing."""
    import matplotlib

    if name == "pressure":
        t = np.linspace(0, 1, 256)
        grey = np.clip(1 - t / 0.12, 0, 1)[:, None]
        return np.round(grey * (232, 235, 239) + (1 - grey) * colour_table("YlOrRd"))
    start = 16 if name == "viridis" else 0  # its darkest colours would hide the cell edges
    return np.round(matplotlib.colormaps[name](np.linspace(start, 255, 256).astype(int))[:, :3] * 255)


@cache
def _tables(name: str) -> np.ndarray:
    def fade(colour: tuple[int, int, int]) -> np.ndarray:
        t = np.linspace(0, 1, 256)[:, None]
        return np.array(colour) * (1 - t * t * (3 - 2 * t)) + np.array(BACKGROUND) * t * t * (3 - 2 * t)

    solid = [np.tile(np.array(colour, float), (256, 1)) for colour in (INK, *AXIS_COLOURS)]
    tones = [fade(tone) for tone in PLANE_TONES]
    return np.concatenate([colour_table(name), *solid, *tones, *tones]).astype(np.float32).ravel()


@cache
def _font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    import matplotlib
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)


def _round_up(value: float) -> float:
    """The next number with a simple first figure; 1 for nothing."""
    if not value > 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step for step in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10) if step * power >= value * (1 - 1e-9)) * power


def _prefix(value: float) -> tuple[float, str]:
    power = min(4, max(-3, math.floor(math.log10(abs(value)) / 3 + 1e-9))) if value else 0
    return 1000.0**power, {-3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M", 3: "G", 4: "T"}[power]


def _ticks(low: float, high: float) -> np.ndarray:
    """Round numbers in [low, high], four to seven of them."""
    rough = (high - low) / 5
    power = 10.0 ** math.floor(math.log10(rough))
    step = min((s * power for s in (1, 2, 2.5, 5, 10)), key=lambda s: abs(s - rough))
    return np.arange(math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6) + 1) * step


def _decorate(
    picture: Image.Image,
    studio: _Studio,
    eye: _Eye,
    field: str,
    limits: tuple[float, float],
    time: float,
    peak: float,
    note: str,
) -> None:
    """Write title, time, colour bar and axis names into the picture."""
    from PIL import Image, ImageDraw

    draw, u, (width, height) = ImageDraw.Draw(picture), studio.unit, studio.size
    name, unit, colours = FIELDS.get(field, (field.replace("_", " ").capitalize(), "", "viridis"))
    title, small, text = _font(round(21 * u), bold=True), _font(round(13 * u)), _font(round(15 * u))
    draw.text((26 * u, 20 * u), name, TEXT, title)
    below = ", ".join(part for part in (str(studio.data.attributes.get("title", "")), note) if part)
    draw.text((26 * u, 48 * u), below, FAINT_TEXT, small)
    last = float(np.abs(studio.data.times).max()) or 1.0
    step = float(np.median(np.diff(studio.data.times))) if len(studio.data) > 1 else last
    factor, prefix = _prefix(last)
    digits = min(6, max(0, math.ceil(-math.log10(max(step, 1e-6 * last) / factor) + 0.3)))
    draw.text(
        (width - 26 * u, 21 * u), f"t = {time / factor:.{digits}f} {prefix}s", TEXT, _font(round(17 * u)), anchor="ra"
    )

    low, high = limits
    factor, prefix = _prefix(max(abs(low), abs(high))) if unit else (1.0, "")
    x, y, w, h = (round(v * u) for v in (width / u - 104, 120, 18, height / u - 220))
    strip = colour_table(colours)[::-1].astype(np.uint8)[np.arange(h) * 256 // h]
    picture.paste(Image.fromarray(np.repeat(strip[:, None], w, axis=1)), (x, y))
    draw.rectangle((x - 1, y - 1, x + w, y + h), outline=FAINT_TEXT)
    draw.text((x, y - 12 * u), f"{prefix}{unit}", TEXT, text, anchor="ls")
    ticks = _ticks(low / factor, high / factor)
    places = max(0, *(len(f"{tick:.6g}".partition(".")[2]) for tick in ticks))
    for tick in ticks:
        row = y + (h - 1) * (1 - (tick * factor - low) / (high - low))
        draw.line((x + w, row, x + w + 4 * u, row), FAINT_TEXT, max(1, round(u)))
        draw.text((x + w + 9 * u, row), f"{tick:.{places}f}".replace("-", "\N{MINUS SIGN}"), TEXT, text, anchor="lm")
    if math.isfinite(peak):
        draw.text((x, y + h + 12 * u), f"max {peak / factor:.3g}", FAINT_TEXT, small, anchor="la")
    for axis, letter in enumerate("xyz"):
        right, upward = eye.axes[:2, axis]
        length = math.hypot(right, upward)
        if length > 0.15:
            reach = u * (30 + 12 / length)
            draw.text(
                (52 * u + reach * right, height - 52 * u - reach * upward),
                letter,
                AXIS_COLOURS[axis],
                small,
                anchor="mm",
            )
