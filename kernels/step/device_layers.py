"""The friction layers of a step on a GPU: a thread per layer, and the boundary nodes before them.

    load       contact load and what friction did in the step that ends; what the layers do (layer/device_layers.py)
    layers     the layer steps of one batch of layers of the same metals, all of a mechanical step in one launch
    motion     their error; friction, kick, drift, static solve: device_contact.py

Within a layer step that is solved together with the kick, the kick is cut into as many parts as the step has: the slip
speed v falls by the traction of each part, and the next one sticks where v vanishes (METHOD 5).
"""

import functools
from typing import Any, NamedTuple

from ..contact.friction import MEAN_SPEED, MOBILITY, SPEED, node_place
from ..engine import ti
from ..lanes import DEVICE_BLOCK
from ..language.bundles import ContactOptions
from ..language.compile_options import LEAVE_TO_LLVM, compiled_with
from ..language.joint_lists import number_of_list
from ..language.signatures import Signature, kernel_of
from ..language.threads import turns_of
from ..layer.device_numbers import at_entry, of_node, set_node
from ..layer.layer1d_phases import make_phases
from ..layer.layer1d_residual import MATERIAL, NODE, SCRATCH, SQRT3, material
from ..layer.layer1d_step import BEFORE as CELL_BEFORE
from ..layer.layer1d_step import CAP, DRAG, OTHER, SETTINGS, cell_numbers, make_layer_step
from ..layer.layer1d_step import CHANGE as CELL_CHANGE
from ..layer.layer1d_step import CLOSE as CELL_CLOSE
from ..layer.layer1d_step import PLASTIC_WORK as CELL_PLASTIC
from ..layer.layer1d_step import STRESS as CELL_STRESS
from ..layer.layer1d_step import WORK as CELL_WORK
from ..layer_places import (
    AREA,
    BEFORE,
    CHANGE,
    CLOSE,
    COEFFICIENT,
    ELAPSED,
    FRICTION_IMPULSE,
    GIVEN,
    HEAT_SHARE,
    KICK_WORK,
    MEAN_SHEAR,
    NODE_OF,
    PHASE,
    PLASTIC,
    POINTS,
    POWER,
    PRESSURE,
    PRESSURE_IMPULSE,
    REST,
    RISE,
    SIZES,
    SLIDES,
    SOLVE,
    SPEND,
    START_SHEAR,
    STRESS,
    SUBSTEPS,
    TABLES,
    TO_NONE,
    TO_OBSTACLE,
    USED,
    WAITING,
    WARMING,
    WORK,
)
from .device_control import A_LAYER, WANTS


class ArrayTail:
    """The tail of an array inside a kernel, from the place `first` on; it is indexed like an array of its own."""

    def __init__(self, array, first) -> None:
        self.array, self.first = array, first

    def __getitem__(self, i):
        return number_of_tail(self.array, self.first, i)


class Tables(NamedTuple):
    """The columns and the parameters of a batch of layers in `layer_tables`, and where they begin there."""

    array: Any
    first_column: Any
    first_parameter: Any

    @property
    def columns(self) -> ArrayTail:
        """Return the columns."""
        return ArrayTail(self.array, self.first_column)

    @property
    def parameters(self) -> ArrayTail:
        """Return the parameters."""
        return ArrayTail(self.array, self.first_parameter)


@ti.func
def number_of_tail(array: ti.template(), first, i):
    """Return number i of the tail of an array that begins at place `first`."""
    return array[first + i]


@functools.cache
def make_device_layers(
    signature: Signature, options: ContactOptions, layout: tuple[int, int, bool, int, bool], gives: int, threads: int
):
    """Return the kernel of the layer steps of a batch, memoised.

    device_layers(batch, first, cells, kick, *arrays): number of the batch; its first entry, and count of its layers;
    kick [s]: of the mechanical step; signature: of DeviceLists with control, a Contact with friction and the layers,
    and the LayerCells of the batch; layout: lanes of a pack, sides, heating, method and ends, as of `make_layer`;
    gives: one of layer_places.TO_NONE ...; threads: of the loop.
    """
    stride, sides, heating, method, ends = layout
    layer_step = make_layer_step(1, stride, sides, heating, method, ends)
    yield_limit = make_phases(1, stride, heating)[0]
    numbers = cell_numbers(sides, ends)

    @ti.func
    def lowest_shear(params: ti.template(), own: ti.template(), points, base, pressure):
        """Return the shear stress [Pa] with which a layer starts whose contact closes now."""
        lowest = ti.Vector([1e300])
        for s in ti.static(range(sides)):
            mat = material(params, s, ti.Vector([pressure]))
            limit = yield_limit(own.rise, own.hardening, base, s * points, (s + 1) * points, mat)
            lowest = ti.min(lowest, limit)
        return lowest[0] / SQRT3

    @ti.func
    def shear_of_pressed(params: ti.template(), own: ti.template(), points, base, cell, pressure):
        """Return the shear stress [Pa] of a layer; its start value where a contact has just closed."""
        shear = own.cells[cell + CELL_STRESS * stride] / SQRT3
        if pressure > 0.0 and shear == 0.0:
            shear = lowest_shear(params, own, points, base, pressure)
        return shear

    @ti.func
    def step_layer(batch, c, e, kick, contact: ti.template(), own: ti.template()):
        """Take the step of layer c of the batch, which is entry e."""
        points = number_of_list(contact.layer_lists, SIZES, POINTS)
        table = number_of_list(contact.layer_lists, TABLES, batch)
        setting = table + (NODE * points + MATERIAL) * sides
        parameters = table + NODE * points * sides
        tables = ti.static(Tables(contact.layer_tables, table, parameters))
        settings = [contact.layer_tables[setting + i] for i in range(SETTINGS)]
        pack, lane = c // stride, c % stride
        base = pack * (points * sides) * stride + lane
        spare = SCRATCH * pack * (points * sides) * stride + lane
        cell = pack * numbers * stride + lane
        k = number_of_list(contact.layer_lists, NODE_OF, e)
        used = of_node(contact, USED, k) == ti.cast(batch, ti.f64)
        phase, area, pressure = contact.layers[PHASE], of_node(contact, AREA, k), of_node(contact, PRESSURE, k)
        before, cold = own.cells[cell + CELL_WORK * stride], own.rise[base]
        parts = 0
        # slip speed, mean speed of the kick, largest traction and pressure of the step; slip speed lost per traction
        speed, mean, dry, pressing, mobility = 0.0, 0.0, 0.0, 0.0, 0.0
        if phase != REST:
            parts = ti.cast(contact.layers[SUBSTEPS], ti.i32)
        if phase == SPEND:
            elapsed = contact.layers[ELAPSED]
            dry = of_node(contact, FRICTION_IMPULSE, k) / elapsed
            pressing = of_node(contact, PRESSURE_IMPULSE, k) / elapsed
            if dry > 0.0 and pressing > 0.0:
                speed = ti.max(of_node(contact, WAITING, k), 0.0) / (dry * elapsed)
            mean = speed
        if phase == SOLVE:
            if used:
                shear = shear_of_pressed(tables.parameters, own, points, base, cell, pressure)
                set_node(contact, START_SHEAR, k, shear)
            usual = own.cells[cell + CELL_STRESS * stride] / SQRT3 * kick
            speed = contact.friction[node_place(k, SPEED)]
            mean = contact.friction[node_place(k, MEAN_SPEED)]
            # the work of the kick is that of the mean of the speeds before and after it
            if usual > 0.0:
                mean += of_node(contact, WAITING, k) / usual
            mean = ti.max(mean, 0.0)
            mobility = contact.friction[node_place(k, MOBILITY)] * area / float(parts)
            dry = of_node(contact, COEFFICIENT, k) * ti.max(pressure, 0.0)
            pressing = pressure
        total, slips = 0.0, ti.select(used, 1.0, 0.0)
        for _ in range(parts):
            cap = dry
            if mobility > 0.0:
                cap = ti.min(dry, speed / mobility)
            own.cells[cell + CAP * stride] = ti.min(cap, 1e300)
            own.cells[cell + DRAG * stride] = 0.5 * mobility
            layer_step(
                tables.columns, tables.parameters, settings, own.rise, own.growth, own.hardening, own.carried,
                own.cells, own.scratch, points, points * sides, base, spare, cell, ti.Vector([slips * mean]),
                ti.Vector([slips * pressing]),
            )  # fmt: skip
            shear = ti.min(own.cells[cell + CELL_STRESS * stride] / SQRT3, cap)
            speed = ti.max(speed - mobility * shear, 0.0)
            mean = ti.max(mean - mobility * shear, 0.0)
            total += shear
        work = own.cells[cell + CELL_WORK * stride]
        if used:
            set_node(contact, SLIDES, k, ti.select(speed > 0.0, 1.0, 0.0))
            set_node(contact, WARMING, k, own.rise[base] - cold)
            if phase == SPEND:
                set_node(contact, POWER, k, (work - before) / contact.layers[ELAPSED])
                set_node(contact, WAITING, k, of_node(contact, WAITING, k) - (work - before))
            if phase == SOLVE:
                set_node(contact, KICK_WORK, k, work - before)
                set_node(contact, POWER, k, (work - before) / kick)
                set_node(contact, MEAN_SHEAR, k, total / float(parts))
            else:
                shear = shear_of_pressed(tables.parameters, own, points, base, cell, pressure)
                set_node(contact, START_SHEAR, k, shear)
        contact.layers[at_entry(contact, STRESS, e)] = own.cells[cell + CELL_STRESS * stride]
        contact.layers[at_entry(contact, CHANGE, e)] = own.cells[cell + CELL_CHANGE * stride]
        contact.layers[at_entry(contact, BEFORE, e)] = own.cells[cell + CELL_BEFORE * stride]
        contact.layers[at_entry(contact, CLOSE, e)] = own.cells[cell + CELL_CLOSE * stride]
        contact.layers[at_entry(contact, WORK, e)] = work
        contact.layers[at_entry(contact, PLASTIC, e)] = own.cells[cell + CELL_PLASTIC * stride]
        contact.layers[at_entry(contact, RISE, e)] = own.rise[base]
        if ti.static(gives == TO_NONE):
            contact.layers[at_entry(contact, GIVEN, e)] = (1.0 - contact.layers[HEAT_SHARE]) * work
        elif ti.static(gives == TO_OBSTACLE):
            contact.layers[at_entry(contact, GIVEN, e)] = own.cells[cell + OTHER * stride]

    @ti.func
    def device_layers(
        batch: ti.template(), first: ti.template(), count: ti.template(), kick: ti.template(), lists: ti.template(),
        contact: ti.template(), own: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            if lists.control[WANTS] == A_LAYER:
                for turn in range(turns_of(t, threads, count)):
                    c = t + turn * threads
                    step_layer(batch, c, first + c, kick, contact, own)

    made = kernel_of(device_layers, signature, ("batch", "first", "count"), ("kick",), options=options)
    return compiled_with(made, **LEAVE_TO_LLVM)
