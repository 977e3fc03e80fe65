"""Kernel that takes many steps of many friction layers in one launch (METHOD 5); `layer1d_step` is a step of a layer.

The state arrays are flat: rise [pack, node, lane] = T - base, growth = beta ep, hardening = (1 + beta ep)^n, carried
[J/m^3] = plastic heat not yet released; cells [pack, `cell_numbers`, lane]. A pack has `stride` lanes in memory, of
which a thread takes `width`: 8 and 8 as SIMD vectors on a CPU, 32 and 1 on a GPU.
"""

import functools

from ..engine import ti
from ..language.arguments import ARRAY
from ..language.compile_options import KEEP_VECTORS, compiled_with
from ..language.vectors import load, store
from .layer1d_residual import MATERIAL, SCRATCH, SQRT3, magnitude
from .layer1d_step import SETTINGS, cell_numbers, make_layer_step


@functools.cache
def make_layer(width: int, stride: int, sides: int, heating: bool, method: int, ends: bool = False):
    """Return the kernel of the layer, memoised; heating: plastic work heats; method: of `layer1d_solve`.

    ends: heat flows through the far ends, at conductances [W/(m^2 K)] that are the last numbers of the materials.

    units: groups of `width` cells, taken in `chunks`, one per `grain` iterations; side_nodes, all_nodes: nodes of the
    first side, of all; steps from first_step on; velocity [m/s] and pressure [Pa] are tables [row, cell], row = step *
    velocity_row / cells; every `every` steps a row of surface_out (T - base) and stress_out (tau [Pa]), [row, cell].
    """
    layer_step = make_layer_step(width, stride, sides, heating, method, ends)
    per_pack = stride // width
    numbers = cell_numbers(sides, ends)

    @ti.kernel
    def layer(
        units: ti.i32,
        chunks: ti.i32,
        grain: ti.i32,
        side_nodes: ti.i32,
        all_nodes: ti.i32,
        first_step: ti.i32,
        steps: ti.i32,
        every: ti.i32,
        velocity_row: ti.i32,
        pressure_row: ti.i32,
        nodes: ARRAY,
        params: ARRAY,
        velocity: ARRAY,
        pressure: ARRAY,
        rise: ARRAY,
        growth: ARRAY,
        hardening: ARRAY,
        carried: ARRAY,
        cells: ARRAY,
        scratch: ARRAY,
        surface_out: ARRAY,
        stress_out: ARRAY,
    ):
        for iteration in range(chunks * grain):
            if iteration % grain == 0:
                chunk = iteration // grain
                at = sides * MATERIAL
                settings = [params[at + i] for i in range(SETTINGS)]
                for unit in range(chunk * units // chunks, (chunk + 1) * units // chunks):
                    pack, lane = unit // per_pack, (unit % per_pack) * width
                    base = pack * all_nodes * stride + lane
                    spare = chunk * width // stride * (all_nodes * SCRATCH * stride) + chunk * width % stride
                    cell = pack * numbers * stride + lane
                    here = unit * width
                    for step in range(first_step, first_step + steps):
                        speed = magnitude(load(velocity, step * velocity_row + here, width))
                        pressing = load(pressure, step * pressure_row + here, width)
                        sig = layer_step(
                            nodes, params, settings, rise, growth, hardening, carried, cells, scratch, side_nodes,
                            all_nodes, base, spare, cell, speed, pressing,
                        )  # fmt: skip
                        if (step + 1) % every == 0:
                            row = (step + 1) // every * (units * width) + here
                            store(surface_out, row, load(rise, base, width), width)
                            store(stress_out, row, sig / SQRT3, width)

    return compiled_with(layer, **KEEP_VECTORS) if width > 1 else layer
