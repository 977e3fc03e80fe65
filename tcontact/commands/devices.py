"""What `tcontact doctor` says of CUDA: the device or why there is none, its memory, and the largest bodies that fit."""

from __future__ import annotations

from ..device import cuda
from ..mesh.elements import ELEMENTS
from ..planning.cell_shapes import STORED
from ..planning.device_memory import PLACES, Cells, DeviceSize, device_size
from ..run.device_room import RESERVE, readable

SHOWN = {"hex8": "hex8, any full integration", "tet4-stored": "tet4"}  # by the name of the element in the kernels


def cuda_lines() -> list[str]:
    """Describe the CUDA device as its driver reports it, and what fits into its memory."""
    try:
        device = cuda.find_device()
    except cuda.NoDevice as error:
        return [f"not usable: {error}; --arch cpu is left"]
    memory = f"{readable(device.total)}, {readable(device.free)} of it free"
    lines = [f"{device.count} device(s), first: {device.name}, {memory}; use --arch cuda"]
    return lines + [_fits(variant, device.free) for variant in SHOWN]


def _fits(variant: str, room: int) -> str:
    number = largest_box(variant, room)
    if number == 0:
        return f"too little free memory for a body of {SHOWN[variant]}: {readable(RESERVE)} go beside its arrays"
    size, cells = box_size(variant, number), cells_of_box(variant, number)
    limit = "by its memory" if box_size(variant, number + 1).places <= PLACES else "by 32 bit numbering"
    return (
        f"fits {number}^3 boxes, {cells} cells of {SHOWN[variant]}, elastic without contact:"
        f" {size.total / cells:.0f} bytes a cell ({limit})"
    )


def largest_box(variant: str, room: int) -> int:
    """Return the largest N for which a cube of N^3 boxes fits into `room` bytes of a device; 0 if none does."""
    low, high = 0, 1 << 11
    while high - low > 1:
        middle = (low + high) // 2
        size = box_size(variant, middle)
        low, high = (middle, high) if size.total + RESERVE <= room and size.places <= PLACES else (low, middle)
    return low


def box_size(variant: str, number: int) -> DeviceSize:
    """Return what a cube of number^3 boxes takes on a device, cut into the cells of an element."""
    corners = ELEMENTS[variant.partition("-")[0]].corners
    cells = Cells(cells_of_box(variant, number), corners, STORED.get(variant, 0), 0)
    return device_size([cells], (number + 1) ** 3)


def cells_of_box(variant: str, number: int) -> int:
    """Return the number of cells of a cube of number^3 boxes."""
    return number**3 * len(ELEMENTS[variant.partition("-")[0]].in_box)
