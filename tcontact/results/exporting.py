"""Export of a stored run to formats that other programs read: a series of .vtu files, or .xdmf with .h5."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from ..base import validate
from ..base.errors import InputError
from ..device.atomic_file import refuse_lost_link, refuse_special
from .files.vtkhdf import Frame, ResultData
from .files.vtu_file import VtuWriter, write_collection
from .files.xdmf_file import write_series

FORMATS = ("vtu", "xdmf")


def export(
    data: ResultData | Path | str,
    out: Path | str,
    format: str = "vtu",
    fields: Sequence[str] | None = None,
    every: int = 1,
) -> list[Path]:
    """Write the frames of a result into a folder; return the files written, the one to open last.

    data: a result, or its file; format: "vtu" (frame-0000.vtu ... and series.pvd with their times) or "xdmf" (series.h5
    and series.xdmf); fields: names of those to write, None = all; every: take every so many frames. Numbers are those
    of the file, bit for bit.
    Raises `InputError` for an unknown format or field, a file without frames and a folder that cannot be written.
    """
    validate.choice("format", format, FORMATS)
    data = data if isinstance(data, ResultData) else ResultData.open(data)
    if fields is not None:
        fields = validate.words("fields", fields, (*data.point_fields, *data.cell_fields))
    every = validate.whole("every", every, 1)
    if len(data) == 0:
        raise InputError("data", str(data.path), "the file holds no frames; run again with frames > 0")
    out = validate.path("out", out, "give the name of a folder")
    refuse_lost_link(out)
    for name in ("series.xdmf", "series.h5") if format == "xdmf" else ("series.pvd",):
        refuse_special(out / name)
    try:
        out.mkdir(parents=True, exist_ok=True)
        frames = _frames(data, fields, every)
        if format == "xdmf":
            return write_series(out / "series.xdmf", data.points, data.blocks, frames)[::-1]
        writer, written = VtuWriter(data.points, data.blocks), []
        for index, frame in enumerate(frames):
            written.append(out / f"frame-{index:04d}.vtu")
            writer.write(written[-1], frame.point_data, frame.cell_data)
        write_collection(out / "series.pvd", data.times[::every].tolist(), written)
        for stale in set(out.glob("frame-[0-9]*.vtu")) - set(written):
            stale.unlink()  # it belongs to an earlier, longer series
    except OSError as error:
        reason = error.strerror or error
        raise InputError("out", str(out), f"cannot be written ({reason}); make room or name another folder") from error
    return [*written, out / "series.pvd"]


def _frames(data: ResultData, fields: Sequence[str] | None, every: int) -> Iterator[Frame]:
    for index in range(0, len(data), every):
        frame = data.frame(index)
        if fields is not None:
            parts = [
                {name: part[name] for name in part if name in fields} for part in (frame.point_data, frame.cell_data)
            ]
            frame = Frame(frame.time, *parts)
        yield frame
