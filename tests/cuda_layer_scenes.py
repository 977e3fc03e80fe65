"""Scenes with friction layers that threads of a CUDA device step: the squeezed steel block of the case hot-slide."""

from __future__ import annotations

import dataclasses

import tcontact as tc
from tcontact.cases import hot_slide
from tcontact.friction_layer.metals import COPPER

STEP = 8e-9  # [s], of all of them


def sliding(removal, speed, rows, contact=None, **layer):
    """The block at a speed [m/s] on a floor, for a number of rows, and its scheme."""
    scene = hot_slide.scene(cells=2, speed=speed, pressure=1e9, removal=removal, duration=1e-7)
    friction, contact = tc.FrictionLayer(points=8, **layer), contact or scene.contact
    made = tc.Scene(scene.bodies, scene.obstacles, rows * STEP, contact=contact, friction=friction)
    return made, tc.CentralDifference(dt=STEP)


def baked():
    """Layers that are solved together with the kick, then take one step for several mechanical ones, and flow.

    The floor is a metal, so that its layers have two sides; a plane without one, of another coefficient, rises through
    it and takes over: for a while both press every node.
    """
    scene, scheme = sliding("normal", 34.0, 40, plastic_heat=0.3, tolerance=0.03)
    (floor,) = scene.obstacles
    own = dataclasses.replace(scene.friction, coefficient=2.0 * scene.friction.coefficient)
    rising = tc.Plane((0.0, 0.0, -4e-8), (0.0, 0.0, 1.0), velocity=(0.0, 0.0, 0.18), friction=own)
    return dataclasses.replace(scene, obstacles=[dataclasses.replace(floor, metal=COPPER), rising]), scheme


def fused():
    """Layers that limit the friction of the static solve, which slides from the first step on; the floor names them."""
    scene, scheme = sliding("full", 400.0, 40)
    (floor,) = scene.obstacles
    own = dataclasses.replace(scene.friction, coefficient=0.5 * scene.friction.coefficient)
    return dataclasses.replace(scene, obstacles=[dataclasses.replace(floor, friction=own)]), scheme


def branded():
    """Layers that limit the friction of contact by penalty, on a floor of metal."""
    scene, scheme = sliding("full", 34.0, 40, tc.PenaltyContact(1e16))
    (floor,) = scene.obstacles
    return dataclasses.replace(scene, obstacles=[dataclasses.replace(floor, metal=COPPER)]), scheme


def grooved():
    """Layers of a cube that strikes a moving floor and a wall: friction in the static solve and in the kick."""
    size, mesh = 1e-4, tc.box_mesh((1e-4,) * 3, (2, 2, 2))
    law = tc.NeoHookean(200e9, 0.3, 7900.0)
    cube = tc.Body(mesh, law, (-200.0, 0.0, -200.0), contact=["zmin", "xmin"])
    floor = tc.Plane((0.0, 0.0, -1e-5 * size), velocity=(50.0, 50.0, 0.0), metal=COPPER)
    wall = tc.Plane((-1e-5 * size, 0.0, 0.0), (1.0, 0.0, 0.0), velocity=(0.0, 30.0, 10.0))
    step, friction = 3e-10, tc.FrictionLayer(points=8, thickness=1e-6)
    contact = tc.MasslessContact(removal="normal", tolerance=1e-13)
    return tc.Scene([cube], [floor, wall], 40 * step, contact=contact, friction=friction), tc.CentralDifference(dt=step)
