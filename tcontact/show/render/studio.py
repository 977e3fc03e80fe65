"""The studio, which draws one series of pictures."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.errors import InputError
from ...device import runtime
from ...results.files.vtkhdf import Frame, ResultData
from ...scene.obstacles.base import direction as unit_of
from .bodies import colour_number, names_of, own_limits, write_names
from .camera import Camera, Eye, fitted, thin_normals, usual_direction
from .colours import AWAY_FROM_ZERO, BACKGROUND, FIELD, NOTHING, SHADOWED, colour_map, tables
from .extent import extent, most_sizes
from .key_frame import key_frame
from .labels import decorate, font, round_down, round_up, write_figures
from .png import save_picture
from .raster import Raster
from .scenery import Scenery, Signs
from .signs import Sign, placed_signs, write_signs
from .surface import Clip, clipped_surface
from .triangles import Place, Triangles, drawable, fronts, triad, union, window

if TYPE_CHECKING:
    from PIL import Image


SAMPLES = 2  # samples per pixel along one axis
TOUCHING = 0.5  # cosine between the outward normal of a face and the force against it, from which on they touch
DARK = 0.26  # share of the light that a shadow takes
KEPT = 2**28  # bytes of frames that are kept in memory, so that a series is read from its file once


class Studio:
    """The studio of a series: surface, planes, extent of the motion, buffers, which all its pictures share."""

    def __init__(
        self,
        data: ResultData,
        size: tuple[int, int],
        deformation_scale: float,
        obstacles: Sequence[Mapping[str, Any]] | None,
        title: str | None = None,
        clip: Sequence[Clip] = (),
        colours: str | None = None,
        read: Callable[[int], Frame] | None = None,
    ) -> None:
        """Make the studio of a series; read: reads a frame by its number, None = `data.frame`."""
        if not math.isfinite(deformation_scale):
            raise InputError("deformation_scale", deformation_scale, "give a finite number")
        self.data, self.size, self.scale = data, (int(size[0]), int(size[1])), deformation_scale
        self._read = data.frame if read is None else read
        described = data.attributes.get("obstacles", ()) if obstacles is None else obstacles
        self.scenery = Scenery(described)
        self._finished = data.attributes.get("reason", "finished") == "finished"
        self.title = str(data.attributes.get("title", "")) if title is None else title
        self.clip, self.wish = tuple(clip), colours
        self.names = names_of(data)
        self.surface = clipped_surface(data.points, data.blocks, self.clip)
        self.unit = self.size[1] / 720  # lengths of the layout are meant for 720 rows
        width, height = self.size
        samples = width * height * SAMPLES**2
        self.raster = Raster()
        self.depth, self.pixel = np.zeros(samples, np.float32), np.zeros(samples, np.int32)
        self.mask_depth, self.mask = np.zeros(width * height, np.float32), np.zeros(width * height, np.int32)
        self.background = np.tile(np.array(BACKGROUND, dtype=np.float32), height)
        self.shadow = np.zeros(width * height, np.uint8)
        self.image = np.zeros(3 * width * height, np.uint8)
        self.nothing = np.zeros(samples, np.float32)  # depth of what hides nothing
        self.floor, self.pixel_behind = np.zeros(samples, np.float32), np.zeros(samples, np.int32)  # of the scenery
        self._behind: tuple[Triangles, np.ndarray, list[Sign]] | None = None
        self._signed: tuple[np.ndarray, tuple[Any, ...], np.ndarray, np.ndarray] | None = None
        self._frames: dict[int, Frame] = {}
        self._room = KEPT

    def frame(self, index: int) -> Frame:
        """Return frame `index`; as many as `KEPT` allows stay in memory."""
        frame = self._frames.get(index)
        if frame is None:
            frame = self._read(index)
            size = sum(array.nbytes for part in (frame.point_data, frame.cell_data) for array in part.values())
            if size <= self._room:
                self._frames[index] = frame
                self._room -= size
        return frame

    def values(self, frame: Frame, field: str) -> tuple[np.ndarray, bool]:
        """Return scalars on the surface: (nodes [s], True) or (faces [q+t], False)."""
        if field == "body":
            return colour_number(self.body_of_face, self.limits(field)), False
        nodal = field in frame.point_data
        array = frame.point_data[field][self.surface.nodes] if nodal else frame.cell_data[field][self.surface.owner]
        return np.linalg.norm(array, axis=1) if array.ndim == 2 else array.astype(np.float64), nodal

    def limits(self, field: str) -> tuple[float, float]:
        """Return the ends of the colours over the series: round numbers around what is there, without rare peaks."""
        if field == "body":
            return own_limits() if self.wish is None else (0.0, max(1.0, len(self.names) - 1.0))
        low, high, least = 0.0, 0.0, math.inf
        for index in range(len(self.data)):
            values, _ = self.values(self.frame(index), field)
            values = values[np.isfinite(values) & (values != 0)]
            if len(values):
                least = min(least, float(values.min()))
                low, high = min(low, *np.quantile(values, [0.015])), max(high, *np.quantile(values, [0.985]))
        top = round_up(max(high, -low))
        if field in AWAY_FROM_ZERO and 0.0 < least < high:
            low = round_down(least)
            return low, low + round_up(high - low)
        return (-top if low < 0 else 0.0), top

    def positions(self, frame: Frame) -> np.ndarray:
        """Return deformed surface nodes [s,3]."""
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
    def body_of_face(self) -> np.ndarray:
        """Number [q+t] of the body that a face of the surface belongs to, 0 when the file names no bodies."""
        if "body" not in self.data.cell_fields:
            return np.zeros(len(self.surface.owner), dtype=np.int64)
        return np.asarray(self.frame(0).cell_data["body"][self.surface.owner])

    @cached_property
    def bodies(self) -> list[np.ndarray]:
        """Surface nodes of each body (local numbers)."""
        surface, body = self.surface, self.body_of_face
        of_node = np.zeros(len(surface.nodes), dtype=np.int64)
        for faces, first in ((surface.quads, 0), (surface.triangles, len(surface.quads))):
            of_node[faces] = body[first : first + len(faces), None]
        return [np.flatnonzero(of_node == number) for number in np.unique(of_node)]

    def extent(self, frames: Iterable[Frame]) -> np.ndarray:
        """Return points [k,3] whose hull holds the body in these frames, but for frames of a body blown up."""
        found = extent((self.positions(frame) for frame in frames), self.bodies, self._most)
        return found if len(found) else self.data.points[self.surface.nodes]

    @cached_property
    def _most(self) -> list[float]:
        """The size [m] of each body above which it has blown up; a frame that is alone has no start but the mesh."""
        start = self.data.points[self.surface.nodes]
        if len(self.data) > 1 and "displacement" in self.data.point_fields:
            moved = start + self.frame(0).point_data["displacement"][self.surface.nodes]
            start = moved if np.isfinite(moved).all() else start
        return most_sizes(start, self.bodies, self.data.attributes.get("reason"), self.scale)

    def camera(
        self,
        view: str,
        camera: Camera | None = None,
        frames: Iterable[Frame] | None = None,
        pushed: np.ndarray | None = None,
    ) -> Eye:
        """Place the eye so that body, in these frames or over the whole run, and contact plane fill the picture.

        pushed: where there is no plane, the direction [3] in which the obstacles push, as the normal of a plane does.
        """
        if view not in ("above", "below"):
            raise InputError("view", view, "use 'above' or 'below'")
        up = self.scenery.planes[0][1] if self.scenery.planes else np.array([0.0, 0.0, 1.0])
        if camera is None:
            start = self.positions(self.frame(0)) if len(self.data) else self.data.points[self.surface.nodes]
            plates = thin_normals([start[nodes] for nodes in self.bodies])
            sides = [np.array(clip.normal) / np.linalg.norm(clip.normal) for clip in self.clip]
            normal = up if self.scenery.planes or pushed is None else pushed
            direction = usual_direction(view, normal, [wall for _, wall in self.scenery.planes[1:]], sides, plates)
        else:
            remedy = "give a tcontact.render.Camera"
            direction, up = unit_of("camera", camera.direction, remedy), unit_of("camera", camera.up, remedy)
        back = direction / np.linalg.norm(direction)
        right = np.cross(up, back)
        right /= np.linalg.norm(right)
        axes = np.array([right, np.cross(back, right), back])

        body = self.extent(self.frame(i) for i in range(len(self.data))) if frames is None else self.extent(frames)
        placed = self.scenery.around(body, back, self.data.times)
        u = self.unit
        left, top, width, height = 24 * u, 74 * u, self.size[0] - 146 * u, self.size[1] - 104 * u
        slope = 0.2  # tangent of half the opening angle: mild perspective
        focal = height / 2 / slope
        position = fitted(placed.shown() @ axes.T, width / 2 / focal, slope) @ axes
        fixed = triad(axes, 52 * u, self.size[1] - 52 * u, u)
        distance = float((position - placed.centre) @ back)
        eye = Eye(position, axes, focal, (left + width / 2, top + height / 2), fixed, None, distance=distance)
        return placed.before(eye, u)

    def picture(self, frame: Frame, field: str, limits: tuple[float, float], eye: Eye, note: str = "") -> Image.Image:
        """Draw one frame."""
        from PIL import Image

        return Image.fromarray(self.pixels(frame, field, limits, eye, note))

    def pixels(self, frame: Frame, field: str, limits: tuple[float, float], eye: Eye, note: str = "") -> np.ndarray:
        """Draw one frame [height, width, red green blue]."""
        with runtime.turn:
            return self._pixels(frame, field, limits, eye, note)

    def _pixels(self, frame: Frame, field: str, limits: tuple[float, float], eye: Eye, note: str) -> np.ndarray:
        from PIL import Image, ImageDraw

        runtime.start(runtime.arch())
        still = eye.moving is None
        eye = eye.at(frame.time)
        values, nodal = self.values(frame, field)
        x = self.surface.spread(self.positions(frame))
        screen = eye.project(x)
        force = frame.point_data.get("contact_force") if field == "contact_pressure" else None
        # cells that inverted have faces that look inward
        whole = self.scale == 1.0 and self._finished and isinstance(drawable(screen[:, None]), slice)
        body, face = self._body(x, screen, values, nodal, limits, eye, force, whole)
        width, height = self.size
        chosen = colour_map(field, self.wish)
        colours = tables(chosen)
        scenery, names = self._scenery(eye, colours)
        darker = self._cast_shadow(self._fallen(x, eye))
        place = window([screen], [0], width, height)
        rows, columns = (slice(SAMPLES * part.start, SAMPLES * part.stop) for part in place)
        self._draw(body, (rows, columns), colours, self.floor, self.depth, self.pixel)
        place = union(place, darker)
        signs = field, limits, note, chosen
        labelled = self._labelled(scenery, eye, signs, place) if still else None
        self.image[:] = scenery if labelled is None else labelled
        self._resolve(place, self.pixel)
        front = self.pixel.reshape(SAMPLES * height, SAMPLES * width)
        names = [sign for sign in names if not sign.hidden(front, SAMPLES)]
        front[rows, columns] = 0  # for the next picture
        pixels = self.image.reshape(height, width, 3).copy()
        named = bool(self.names) and field != "body"
        if labelled is None or named or names:
            picture = Image.fromarray(pixels)
            if labelled is None:
                decorate(picture, self, eye, *signs)
            pen, letters = ImageDraw.Draw(picture), font(round(14 * self.unit))
            write_signs(pen, names, self.unit, letters)
            if named:
                write_names(pen, self.names, self._seen(body, face, eye), self.unit, letters)
            pixels = np.array(picture)
        peak = float(np.max(values, initial=-np.inf, where=np.isfinite(values)))
        write_figures(pixels, self, field, limits, frame.time, peak)
        return pixels

    def _labelled(
        self, scenery: np.ndarray, eye: Eye, signs: tuple[str, tuple[float, float], str, str], place: Place
    ) -> np.ndarray | None:
        """Return the picture of the scenery with its labels; None where they reach into the place of the bodies.

        signs: field, limits, note and colours of `decorate`.
        """
        from PIL import Image

        width, height = self.size
        if self._signed is None or self._signed[0] is not scenery or self._signed[1] != signs:
            bare = scenery.reshape(height, width, 3)
            picture = Image.fromarray(bare)
            decorate(picture, self, eye, *signs)
            image = np.array(picture)
            self._signed = scenery, signs, image.reshape(-1), (image != bare).any(axis=2)
        return None if self._signed[3][place].any() else self._signed[2]

    def _scenery(self, eye: Eye, colours: np.ndarray) -> tuple[np.ndarray, list[Sign]]:
        """Return the picture of the scenery and the names to write on it; it is drawn again only where it has moved.

        `floor` and `pixel_behind` have its depth and its samples. Its depth is rounded down, so that a body at the same
        depth is seen. Its colours are those of all fields, as only bodies have the colours of the field.
        """
        fixed = eye.fixed
        if self._behind is None or self._behind[0] is not fixed:
            width, height = self.size
            fine = slice(0, SAMPLES * height), slice(0, SAMPLES * width)
            self._draw(fixed, fine, colours, self.nothing, self.floor, self.pixel_behind)
            np.nextafter(self.floor, np.float32(0.0), out=self.floor)
            self.image[:] = np.tile(np.array(BACKGROUND, np.uint8), width * height)
            self.shadow[:] = 0
            self._resolve((slice(0, height), slice(0, width)), self.pixel_behind)
            self._behind = fixed, self.image.copy(), [] if eye.signs is None else self._names_of(eye.signs)
        return self._behind[1:]

    def _draw(
        self,
        scene: Triangles,
        place: Place,
        colours: np.ndarray,
        behind: np.ndarray,
        depth: np.ndarray,
        pixel: np.ndarray,
    ) -> None:
        """Draw triangles with their lines into a place [sample] of the buffers."""
        self.raster.draw(scene, self.size[0] * SAMPLES, place, SAMPLES, 0.6 * self.unit, colours, behind, depth, pixel)

    def _resolve(self, place: Place, front: np.ndarray) -> None:
        """Fill a place of the picture from samples and those of the scenery, with the shadow."""
        self.raster.resolve(
            self.size[0],
            SAMPLES,
            SHADOWED,
            place,
            front,
            self.pixel_behind,
            self.background,
            DARK,
            self.shadow,
            self.image,
        )

    def _seen(self, body: Triangles, face: np.ndarray, eye: Eye) -> np.ndarray:
        """Return the number of the body that is seen at a pixel + 1 [height, width], 0 where none is."""
        return self._numbered(body.screen, self.body_of_face[face], eye.fixed)

    def _names_of(self, signs: Signs) -> list[Sign]:
        """Return the names of the obstacles and where they are written."""
        number = np.repeat(np.arange(len(signs.places)), [len(place.screen) for place in signs.places])
        mask = self._numbered(np.concatenate([place.screen for place in signs.places]), number)
        return placed_signs(signs, mask, self.unit, font(round(14 * self.unit)))

    def _numbered(self, screen: np.ndarray, number: np.ndarray, others: Triangles | None = None) -> np.ndarray:
        """Return the number of what is seen at a pixel + 1 [height, width], 0 where others are or nothing is seen.

        screen [n,3,3]: triangles; number [n] of what each belongs to.
        """
        width, height = self.size
        plain = Triangles.plain(screen, FIELD, np.where(number < 255, (number + 1) / 255, 0.0)[:, None])
        scene = plain if others is None else Triangles.joined([plain, others])
        colours = np.zeros(3 * 256 * SHADOWED + 3 * 512, np.float32)
        colours[:768] = np.repeat(np.arange(256), 3)  # the other tables, those of the scenery, are black
        every = slice(0, height), slice(0, width)
        self.raster.draw(scene, width, every, 1, 0.0, colours, self.nothing, self.mask_depth, self.mask)
        return (self.mask & 255).reshape(height, width)

    def contact_face(self, path: Path, limits: tuple[float, float] | None = None) -> list[Path]:
        """Draw the frame with the largest contact force, where the run touched an obstacle; return [] elsewhere."""
        if "contact_pressure" not in self.data.point_fields or not (self.scenery.planes or self.scenery.solids):
            return []
        alone = len(self.scenery.planes) + len(self.scenery.solids) == 1 and len(self.names) < 2
        key = key_frame(self.data, self.frame, alone)
        if key is None:
            return []
        limits = limits or self.limits("contact_pressure")
        eye = self.camera("below", frames=[key.frame], pushed=key.push)
        save_picture(self.picture(key.frame, "contact_pressure", limits, eye, key.note), path)
        return [path]

    def _body(
        self,
        x: np.ndarray,
        places: np.ndarray,
        values: np.ndarray,
        nodal: bool,
        limits: tuple[float, float],
        eye: Eye,
        force: np.ndarray | None,
        cull: bool,
    ) -> tuple[Triangles, np.ndarray]:
        """Return the surface with its colours and its light, and the face [n] of each triangle.

        x [m], places [pixel]: points of the surface and the quad centres; force: contact force of all nodes [n, 3] [N],
        if the values are those of faces that it presses on, and 0 on others of the same nodes; cull: leave away faces
        that look away from the eye.
        """
        surface = self.surface
        drawn = (surface.corners, surface.face, surface.edges) if nodal or not cull else surface.halved
        chosen = fronts(places, drawn[0], cull)
        corners, face, edges = (part[chosen] for part in drawn)
        level = (values - limits[0]) / (limits[1] - limits[0])
        level = np.nan_to_num(level, nan=np.nan, posinf=1.0, neginf=0.0)
        value = surface.spread(level)[corners] if nodal else np.repeat(level[face][:, None], 3, axis=1)
        table = np.where(np.isnan(value).any(axis=1), NOTHING, FIELD).astype(np.int32)
        value = np.nan_to_num(value, nan=0.0)
        quads, triangles = x[surface.quads], x[surface.triangles]
        with np.errstate(all="ignore"):
            normal = np.concatenate(
                [
                    np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]),
                    np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]),
                ]
            )
            normal = normal / np.linalg.norm(normal, axis=1)[:, None]
            if force is not None:
                value[~self._pressed(normal, force)[face]] = np.clip(limits[0] / (limits[0] - limits[1]), 0, 1)
            normal = normal @ eye.axes.T
        key = np.array([-0.42, 0.72, 0.55])
        light = 0.74 + 0.18 * np.maximum(0.0, normal @ (key / np.linalg.norm(key))) + 0.2 * np.abs(normal[:, 2])
        light = np.nan_to_num(light, nan=0.7)[face]
        edge = np.linalg.norm(places[surface.corners[:, 0], :2] - places[surface.corners[:, 1], :2], axis=1)
        length = float(np.nanmedian(edge)) / self.unit if np.isfinite(edge).any() else 0.0
        ink = np.full(len(face), 0.38 * min(1.0, max(0.0, (length - 2.5) / 9)))
        return Triangles(places[corners], value, light, table, edges, ink), face

    def _pressed(self, normal: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Tell of faces with outward normals [q+t, 3] whether the contact force of their nodes presses on them."""
        surface = self.surface
        of_node = force[surface.nodes]
        total = np.concatenate([of_node[surface.quads].sum(axis=1), of_node[surface.triangles].sum(axis=1)])
        against = -np.einsum("fi,fi->f", normal, total)
        return np.asarray(against > TOUCHING * np.linalg.norm(total, axis=1))

    def _fallen(self, x: np.ndarray, eye: Eye) -> np.ndarray:
        """Return where on the screen [k,3] the points fall on the plane that catches the shadow; none without one."""
        if eye.shadow is None:
            return np.empty((0, 3))
        point, normal = eye.shadow
        ray = -normal + 0.3 * eye.axes[0] - 0.1 * np.cross(eye.axes[0], normal)
        gap = np.maximum(0.0, (x - point) @ normal)
        fallen = x - normal * ((x - point) @ normal)[:, None] + (ray + normal) * gap[:, None]
        return eye.project(fallen)

    def _cast_shadow(self, fallen: np.ndarray) -> Place:
        """Draw the soft shadow into `shadow` (0..255); return its place in the picture [rows, columns]."""
        from PIL import Image, ImageFilter

        width, height = self.size
        soft = math.ceil(4 * self.unit) + math.ceil(3 * self.unit) + 2  # reach of the blur
        place = window([fallen], [soft], width, height)
        there = self.mask.reshape(height, width)[place]
        self.shadow[:] = 0
        if len(fallen) == 0 or there.size == 0:
            return slice(0, 0), slice(0, 0)
        corners = self.surface.halved[0]
        chosen = fronts(fallen, corners, cull=isinstance(drawable(fallen[:, None]), slice))
        shadow = Triangles.plain(fallen[corners[chosen]], 0)
        black = np.zeros(768, np.float32)
        self.raster.draw(shadow, width, place, 1, 0.0, black, self.nothing, self.mask_depth, self.mask)
        mask = Image.fromarray((there != 0).astype(np.uint8) * 255)
        blurred = mask.filter(ImageFilter.BoxBlur(4 * self.unit)).filter(ImageFilter.BoxBlur(3 * self.unit))
        self.shadow.reshape(height, width)[place] = np.asarray(blurred)
        return place
