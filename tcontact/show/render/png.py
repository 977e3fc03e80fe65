"""Write pictures whole or not at all; as PNG quickly: no filter and the fastest compression.

Pictures with faces of one colour and writing become smaller so than with differences between pixels, in three quarters
of the time. Format: https://www.w3.org/TR/png-3/
"""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...device.atomic_file import replaced

if TYPE_CHECKING:
    from PIL import Image

NO_FILTER = 0


def write_png(path: Path, image: np.ndarray) -> None:
    """Write a picture [height, width, 3] (red, green, blue in 0..255) in place of an older one. Raises `OSError`."""
    height, width, _ = image.shape
    rows = np.empty((height, 1 + 3 * width), np.uint8)
    rows[:, 0] = NO_FILTER
    rows[:, 1:] = image.reshape(height, 3 * width)
    parts = {
        b"IHDR": struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0),  # 8 bits, red green blue
        b"IDAT": zlib.compress(rows.data, 1),
        b"IEND": b"",
    }
    with replaced(path, synced=False) as part, part.open("wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for name, data in parts.items():
            file.write(struct.pack(">I", len(data)) + name)
            file.write(data)
            file.write(struct.pack(">I", zlib.crc32(data, zlib.crc32(name))))


def save_picture(picture: Image.Image, path: Path) -> None:
    """Write a picture of Pillow in place of an older one, in the format of the file's name. Raises `OSError`."""
    from PIL import Image

    data = io.BytesIO()  # of a JPEG on a full disk Pillow would write a part and say nothing
    picture.save(data, format=Image.registered_extensions()[path.suffix.lower()])
    with replaced(path, synced=False) as part:
        part.write_bytes(data.getbuffer())
