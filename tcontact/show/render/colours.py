"""Colours of fields, planes and lines, and the tables in which the raster looks them up."""

from __future__ import annotations

from functools import cache

import numpy as np

from ...base.errors import InputError
from ...base.window_backend import import_matplotlib

FIELDS = {  # file name of a field: what the picture calls it, its unit, its colours
    "contact_pressure": ("Contact pressure", "Pa", "pressure"),
    "contact_force": ("Nodal contact force", "N", "pressure"),
    "von_mises": ("Von Mises stress", "Pa", "viridis"),
    "velocity": ("Speed", "m/s", "viridis"),
    "displacement": ("Displacement", "m", "viridis"),
    "layer_temperature": ("Temperature of the friction layer", "K", "pressure"),
    "layer_shear": ("Shear stress of the friction layer", "Pa", "pressure"),
    "pressure": ("Pressure", "Pa", "viridis"),
    "slip_distance": ("Slip distance", "m", "pressure"),
    "friction_work": ("Friction work", "J/m^2", "pressure"),
    "plastic_strain": ("Plastic strain", "", "viridis"),
    "temperature": ("Temperature", "K", "pressure"),
    "body": ("Bodies", "", "bodies"),
}
AWAY_FROM_ZERO = ("layer_temperature", "temperature")  # fields whose colours start at their smallest value, not at zero
BACKGROUND = (250, 251, 253)
TEXT, FAINT_TEXT = (34, 40, 49), (108, 117, 129)
PLANE_TONES = ((219, 225, 233), (207, 214, 224))
_HUES = ((92, 141, 200), (240, 160, 75), (98, 178, 120), (214, 100, 95), (155, 125, 195), (165, 130, 105),
         (225, 145, 190), (190, 185, 80), (90, 185, 200))  # fmt: skip
BODY_COLOURS = np.array([[tone * part for part in hue] for tone in (1.0, 0.62, 0.8) for hue in _HUES])
INK = (72, 82, 96)
OBSTACLE_COLOUR = (190, 199, 212)
NOTHING_COLOUR = (214, 212, 208)  # of cells without a value
AXIS_COLOURS = ((196, 60, 52), (54, 138, 66), (48, 98, 186))
# colour tables in the order the raster sees them; those from `SHADOWED` on take the body's shadow
FIELD, INK_TABLE, AXES, OBSTACLE, NOTHING, OTHER_PLANES, SHADOWED = 0, 1, 2, 5, 6, 7, 9


@cache
def colour_table(name: str) -> np.ndarray:
    """Return 256 colours [256,3] (0..255) of a map of matplotlib.

    "pressure" is its YlOrRd with grey for nothing; "bodies" has a band of one colour for each of some bodies.
    """
    import_matplotlib()
    import matplotlib

    if name == "bodies":
        return np.round(BODY_COLOURS[np.arange(256) * len(BODY_COLOURS) // 256])

    if name == "pressure":
        t = np.linspace(0, 1, 256)
        grey = np.clip(1 - t / 0.12, 0, 1)[:, None]
        return np.round(grey * (232, 235, 239) + (1 - grey) * colour_table("YlOrRd"))
    start = 16 if name == "viridis" else 0  # its darkest colours would hide the cell edges
    return np.round(matplotlib.colormaps[name](np.linspace(start, 255, 256).astype(int))[:, :3] * 255)


@cache
def tables(name: str) -> np.ndarray:
    def fade(colour: tuple[int, int, int]) -> np.ndarray:
        t = np.linspace(0, 1, 256)[:, None]
        return np.array(colour) * (1 - t * t * (3 - 2 * t)) + np.array(BACKGROUND) * t * t * (3 - 2 * t)

    plain = INK, *AXIS_COLOURS, OBSTACLE_COLOUR, NOTHING_COLOUR
    solid = [np.tile(np.array(colour, float), (256, 1)) for colour in plain]
    tones = [fade(tone) for tone in PLANE_TONES]
    return np.concatenate([colour_table(name), *solid, *tones, *tones]).astype(np.float32).ravel()


def colour_map(field: str, wish: str | None = None) -> str:
    """Return the colours of a field, or those that were asked for. Raises `InputError` for an unknown map."""
    if wish is not None:
        import_matplotlib()
        import matplotlib

        if not isinstance(wish, str) or (wish != "pressure" and wish not in matplotlib.colormaps):
            raise InputError("colours", wish, "use the name of a colour map of matplotlib, such as viridis or coolwarm")
        return wish
    return FIELDS[field][2] if field in FIELDS else "viridis"
