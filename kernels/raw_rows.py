"""Raw rows: what a step measures, side by side, before the host makes a row of the history of it.

node sums (10), cell sums (3), boundary sums (8), reactions (4) and contact sums (8); with viscosity also its power and
rate (that of the contact cells has no rate), with friction its work, and where they are asked for the loads of the
obstacles and their power.
"""

import taichi as ti

from .lanes import (
    CELL_SUMS,
    CHUNKS,
    FRICTION_AT,
    FRICTION_SUMS,
    LOADS_AT,
    NODE_SUMS,
    RAW,
    TRACKED,
    VISCOUS_START,
    VISCOUS_SUMS,
)


def loads_of(obstacles: int) -> int:
    """Numbers of the loads of tracked obstacles: force and moment of each, power of all."""
    return TRACKED * obstacles + 1


def row_places(viscous: bool, friction: bool, loads: int) -> tuple[int, int, int, int]:
    """Where the numbers that only some raw rows have begin: viscous, friction, loads of obstacles; and the end."""
    after_viscous = RAW + VISCOUS_SUMS * viscous
    after_friction = after_viscous + FRICTION_SUMS * friction
    return RAW, after_viscous, after_friction, after_friction + loads


@ti.func
def log_row(
    raw: ti.template(), number, body: ti.template(), touching: ti.template(), viscous: ti.template(), cell_power
):
    """All sums of a row, side by side; cell_power [W]: of the viscosity of the contact cells."""
    sums = ti.static(touching.sums)
    width = row_width(touching, viscous)
    place = number * width
    for j in ti.static(range(NODE_SUMS)):
        total = 0.0
        for part in range(CHUNKS):
            total += body.node_sums[part * NODE_SUMS + j]
        raw[place + j] = total
    place += NODE_SUMS
    elastic, least, hourglass = 0.0, 1e300, 0.0
    for chunk in range(CHUNKS):
        elastic += body.cell_sums[chunk * CELL_SUMS]
        least = ti.min(least, body.cell_sums[chunk * CELL_SUMS + 1])
        hourglass += body.cell_sums[chunk * CELL_SUMS + 2]
    raw[place], raw[place + 1], raw[place + 2] = elastic, least, hourglass
    place += CELL_SUMS
    for j in range(FRICTION_AT):
        raw[place + j] = sums[j]
    place += FRICTION_AT
    if ti.static(viscous or touching.options.viscous):
        power, fastest = cell_power, 0.0
        if ti.static(viscous):
            for chunk in range(CHUNKS):
                power += body.cell_sums[VISCOUS_START + chunk * VISCOUS_SUMS]
                fastest = ti.max(fastest, body.cell_sums[VISCOUS_START + chunk * VISCOUS_SUMS + 1])
        raw[place], raw[place + 1] = power, fastest
        place += VISCOUS_SUMS
    if ti.static(touching.options.friction != ""):
        for j in range(FRICTION_AT, LOADS_AT):
            raw[place + j - FRICTION_AT] = sums[j]
        place += FRICTION_SUMS
    if ti.static(touching.options.tracked):
        for j in range(LOADS_AT, sums.shape[0]):
            raw[place + j - LOADS_AT] = sums[j]


@ti.func
def row_width(touching: ti.template(), viscous: ti.template()):
    """Numbers of a raw row."""
    fixed = ti.static(row_places(viscous or touching.options.viscous, touching.options.friction != "", 0)[3])
    width = 0
    if ti.static(touching.options.tracked):
        width = touching.sums.shape[0] - LOADS_AT
    return fixed + width
