"""Scenes with pairs of bodies that threads of a CUDA device step: a block that lands on another one and slides."""

from __future__ import annotations

from scenes import block

import tcontact as tc

LAW = tc.NeoHookean(2.3e7, 0.3, 1350.0)
SPEED = 6.0


def landing(contact, friction=None, floor=False, duration=6e-3, slide=0.8):
    """A block that lands on a larger one 2 mm below it, which may stand on a floor 1 mm below; and its scheme."""
    low = tc.Body(block(cells=2, shake=0.1), LAW, name="low", contact=["zmin", "zmax"] if floor else "zmax")
    mesh = block(cells=2, size=(0.13, 0.12, 0.1), shift=(0.03, 0.04, 0.182), shake=0.1)
    up = tc.Body(mesh, LAW, (slide * SPEED, 0.0, -SPEED), name="up", contact="zmin")
    obstacles = [tc.Plane((0.0, 0.0, -0.001), (0.0, 0.0, 1.0))] if floor else []
    pairs = [tc.Pair("up", "low")]
    scene = tc.Scene([low, up], obstacles, duration, contact=contact, friction=friction, pairs=pairs)
    return scene, tc.CentralDifference(cfl=0.6)


def paired():
    """Normal removal on a floor, with friction of the kick: rows of obstacles beside those of pairs."""
    return landing(tc.MasslessContact(removal="normal", cell_viscosity=0.0, tolerance=1e-6), tc.Coulomb(0.2), True)


def stacked():
    """Full removal with friction in the static solve."""
    return landing(tc.MasslessContact(removal="full", tolerance=1e-10), tc.Coulomb(0.2))


def touched():
    """Full removal without friction: MPRGP."""
    return landing(tc.MasslessContact(removal="full", tolerance=1e-10))


def padded():
    """A penalty, with friction."""
    return landing(tc.PenaltyContact(1e10), tc.Coulomb(0.2))
