"""The contact cells of a step on a GPU, a thread per cell: their elastic force in a pass, their viscous force.

A loop over the contact cells of a kind has a fixed number of threads, of which each takes cells at the distance of this
number (device_step.py). Forces of the step that ends at a row have a launch of their own before the boundary nodes are
moved; in a pass of the static solve a thread takes the viscous force of a cell after the elastic one.
"""

import functools

from ..cells.device_cells import make_device_cell
from ..contact.cell_viscosity import RATE
from ..contact.device_viscosity import make_device_viscosity
from ..engine import ti
from ..lanes import DEVICE_BLOCK, END_LANE, FIRST_LANE, PART, PART_CELLS, STEP
from ..language.compile_options import LEAVE_TO_LLVM, compiled_with
from ..language.signatures import Signature, kernel_of
from ..language.threads import turns_of
from ..materials import LAWS


def make_surface_cells(
    kinds: tuple[tuple[str, str], ...], measured: tuple[int, ...], threads: int, elastic: bool, viscous: bool
):  # fmt: skip
    """Return surface_cells(n, t, rate, body, lists, viscous_cells): thread t of `threads` takes its contact cells.

    n: number of their kind among those `measured` that have contact cells; rate [1/s]: as in device_viscosity.py;
    elastic: their force goes to `corner_forces`; viscous: their viscous force to `viscous_cells`.
    """
    forces = [make_device_cell(*kinds[i]) for i in measured] if elastic else []
    viscosities = [make_device_viscosity(*kinds[i], i, len(kinds)) for i in measured] if viscous else []
    rates = [LAWS[kinds[i][1]].rates for i in measured]
    head = len(kinds) + 1

    @ti.func
    def surface_cells(
        n: ti.template(), t, rate, body: ti.template(), lists: ti.template(), viscous_cells: ti.template()
    ):
        surface = ti.static(lists._replace(parts=lists.contact_parts))
        i = ti.static(measured[n])
        at = head + PART * surface.parts[i]
        end = surface.parts[head + PART * (surface.parts[i + 1] - 1) + END_LANE]
        for turn in range(turns_of(t, threads, end)):
            lane = t + turn * threads
            while lane >= surface.parts[at + END_LANE]:
                at += PART
            cell = lane - surface.parts[at + FIRST_LANE]
            if cell < surface.parts[at + PART_CELLS]:
                if ti.static(elastic):
                    step = 0.0
                    if ti.static(rates[n]):
                        step = body.params[STEP]
                    forces[n](body, surface, at, cell, step, 0)
                if ti.static(viscous):
                    viscosities[n](body, lists, viscous_cells, rate, at, lane, cell)

    return surface_cells


@functools.cache
def make_device_viscous_pass(
    kinds: tuple[tuple[str, str], ...], measured: tuple[int, ...], signature: Signature, threads: int
):  # fmt: skip
    """Return the kernel of the viscous forces of the contact cells alone, memoised, as `make_viscous_pass`.

    signature: of a Body, DeviceLists with contact_parts and a Launch with viscous_cells.
    """
    surface_cells = make_surface_cells(kinds, measured, threads, False, True)

    @ti.func
    def viscous_loop(n: ti.template(), body: ti.template(), lists: ti.template(), launch: ti.template()):
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            surface_cells(n, t, launch.viscous_cells[RATE], body, lists, launch.viscous_cells)

    @ti.func
    def device_viscous_pass(body: ti.template(), lists: ti.template(), launch: ti.template()):
        for n in ti.static(range(len(measured))):
            viscous_loop(n, body, lists, launch)

    return compiled_with(kernel_of(device_viscous_pass, signature), **LEAVE_TO_LLVM)
