"""Scenes of every physics for the tests of resume and of faults, and runs that leave copies of themselves."""

import os
import shutil
import warnings

import numpy as np

import tcontact as tc
from tcontact.results.files.vtkhdf import ResultData, ResultFile
from tcontact.run.checkpoint.keeper import Keeper

ROUND = {"young": 2e7, "poisson": 0.3, "density": 1200.0}


def scene(
    law=tc.NeoHookean, kind="hex8", wall=None, bodies=1, velocity=(1.0, 0.5, -4.0), periodic=None, formulation="full",
    supports=(), duration=1.2e-3, **options,
):  # fmt: skip
    """One or two blocks of 3 x 3 x 2 cells that hit a wall while they slide."""
    found = []
    for number in range(bodies):
        mesh = tc.box_mesh((0.06, 0.06, 0.04), (3, 3, 2), kind=kind, origin=(0.1 * number, 0.0, 2e-4 * (1 + number)))
        found.append(
            tc.Body(
                mesh,
                law(**ROUND),
                velocity,
                contact="zmin",
                periodic=periodic,
                formulation=formulation,
                supports=supports,
            )
        )
    options = {"contact": tc.MasslessContact(removal="full")} | options
    return tc.Scene(found, tc.Plane() if wall is None else wall, duration=duration, gravity=(0, 0, -9.81), **options)


def lifted(time):
    """Velocity of a wall that shakes [m/s]."""
    return np.array([0.3 * np.sin(9e3 * time), 0.0, 0.4 * np.cos(7e3 * time)])


def shaken(time):
    """Displacement of a support that shakes [m]."""
    return 1e-4 * np.sin(3e3 * time)


def engineering():
    """Two blocks and a free ball: loads, springs, masses, a rigid part, driven supports, own friction, sensors."""
    rubber = tc.NeoHookean(**ROUND)
    upper = tc.box_mesh((0.02, 0.02, 0.012), (3, 3, 3), origin=(0.0, 0.0, 0.0101))
    upper = upper.with_sets(node_sets={"top": np.flatnonzero(upper.nodes[:, 2] > 0.022)})
    lower = tc.box_mesh((0.03, 0.03, 0.01), (3, 3, 3), origin=(-0.005, -0.005, 0.0))
    lower = lower.with_sets(node_sets={"middle": np.flatnonzero(np.abs(lower.nodes[:, 2] - 0.005) < 2e-3)})
    bodies = [
        tc.Body(
            upper,
            rubber,
            (1.0, 0.0, -3.0),
            contact="zmin",
            name="upper",
            loads=[
                tc.Load("zmax", pressure=lambda t: 1e4 * np.sin(1e4 * t)),
                tc.Load("xmax", traction=(0.0, 1e4, 0.0)),
                tc.Load("xmin", force=lambda positions, velocities, time: -0.05 * velocities),
            ],
            point_masses=[tc.PointMass("zmax", 1e-3)],
            springs=[tc.Spring("top", 1e4, 1.0, to=(0.01, 0.01, 0.1)), tc.Spring("top", 1e3, to=("lower", "middle"))],
            rigid_parts=[tc.RigidPart("zmax", mass=1e-3)],
            probes=[tc.Probe("xmax", "acceleration"), tc.Probe("zmin", "von_mises")],
        ),
        tc.Body(
            lower,
            rubber,
            contact=["zmax", "zmin"],
            name="lower",
            supports=[tc.Support("xmin", "x", displacement=shaken)],
        ),
    ]
    floor = tc.Plane(point=(0, 0, -1e-4), name="floor", friction=tc.Coulomb(static=0.4, kinetic=0.2, decay=1.0))
    ball = tc.Sphere((0.005, 0.005, -0.0115), 0.011, mass=0.01, velocity=(0.0, 0.0, 2.0), name="ball")
    return tc.Scene(
        bodies,
        [floor, ball],
        duration=1.2e-3,
        gravity=lambda t: (0.0, 0.0, -9.81 * (1.0 + t)),
        contact=tc.MasslessContact(removal="full"),
        friction=COULOMB,
        maxima="von_mises",
    )


COULOMB = tc.Coulomb(0.3)
NORMAL, FULL = tc.MasslessContact(removal="normal"), tc.MasslessContact(removal="full")
SCENES = {
    "full removal": lambda: scene(),
    "normal removal, linear": lambda: scene(tc.LinearElastic, contact=NORMAL),
    "friction in massless components": lambda: scene(friction=COULOMB),
    "friction layers on masses": lambda: scene(contact=NORMAL, friction=tc.FrictionLayer()),
    "loads, springs, rigid bodies, sensors": engineering,
    "moving wall, damping, viscosity, two bodies": lambda: scene(
        wall=tc.Plane(velocity=lifted),
        bodies=2,
        contact=tc.PenaltyContact(3e10),
        damping=tc.MassDamping(40.0),
        viscosity=tc.BulkViscosity(0.06, 1.2),
    ),
}
MORE_SCENES = {
    "no contact": lambda: scene(wall=(), contact=None),
    "full removal, linear, tets": lambda: scene(tc.LinearElastic, "tet4"),
    "normal removal": lambda: scene(contact=NORMAL),
    "friction on masses": lambda: scene(contact=NORMAL, friction=COULOMB),
    "friction of a penalty": lambda: scene(contact=tc.PenaltyContact(3e10), friction=tc.RegularizedCoulomb(0.3, 0.1)),
    "impulse": lambda: scene(contact=tc.ImpulseContact()),
    "friction layers in massless components": lambda: scene(friction=tc.FrictionLayer(plastic_heat=0.3)),
    "periodic body": lambda: scene(periodic="xy", velocity=(0.0, 0.0, -4.0)),
    "moving wall": lambda: scene(wall=tc.Plane(velocity=lifted)),
    "two walls, one turns": lambda: scene(
        wall=[tc.Plane(), tc.Sphere((0.1, 0.03, 0.02), 0.035, angular_velocity=(0, 9.0, 1.0))], friction=COULOMB
    ),
    "reduced hexes, viscosity": lambda: scene(formulation="reduced", viscosity=tc.BulkViscosity(0.06, 1.2)),
    "node-averaged tets, friction": lambda: scene(kind="tet4", formulation="node-averaged", friction=COULOMB),
    "mean dilatation, driven support": lambda: scene(
        formulation="mean-dilatation", supports=[tc.Support("zmax", "z", -3.0)], velocity=(0.0, 0.0, -3.0)
    ),
}


def quietly(call, *arguments, **options):
    """Call without warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return call(*arguments, **options)


def copied(monkeypatch, folder, physics, scheme, every, **options):
    """Run into folder/whole, and leave a copy of the folder at every checkpoint: the result and the copies by row."""
    copies = {}
    save = Keeper.save

    def save_and_copy(self, run, row):
        save(self, run, row)
        copies[row] = folder / f"stopped-{row}"
        shutil.copytree(self.folder, copies[row])

    with monkeypatch.context() as patch:
        patch.setattr(Keeper, "save", save_and_copy)
        checkpoint = {"every_steps": every}
        whole = quietly(tc.simulate, physics, scheme, out=folder / "whole", checkpoint=checkpoint, **options)
    return whole, copies


def same(one, other):
    """Assert that two results have the same bits."""
    assert (one.reason, one.steps, one.time, one.dt) == (other.reason, other.steps, other.time, other.dt)
    for name in ("position", "velocity", "contact_node_force"):
        assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True), name
    assert (one.maxima, one.peaks) == (other.maxima, other.peaks)
    assert one.history.keys() == other.history.keys()
    for name, column in one.history.items():
        assert np.array_equal(column, other.history[name], equal_nan=True), name
    for mine, theirs in zip(one.contact_pressures, other.contact_pressures, strict=True):
        assert np.array_equal(mine.pressure, theirs.pressure)
    for mine, theirs in zip(one.layers, other.layers, strict=True):
        assert (mine is None) == (theirs is None)
        for name in ("temperature", "plastic_strain", "shear_stress") if mine is not None else ():
            assert np.array_equal(getattr(mine, name), getattr(theirs, name)), name


def same_files(one, other):
    """Assert that two folders hold the same frames and the same history."""
    mine, theirs = (ResultData.open(folder / "result.vtkhdf") for folder in (one, other))
    assert np.array_equal(mine.times, theirs.times)
    for index in range(len(mine)):
        for part in ("point_data", "cell_data"):
            here, there = getattr(mine.frame(index), part), getattr(theirs.frame(index), part)
            assert here.keys() == there.keys()
            assert all(np.array_equal(here[name], there[name], equal_nan=True) for name in here)
    assert mine.history.keys() == theirs.history.keys()
    for name, column in mine.history.items():
        assert np.array_equal(column, theirs.history[name], equal_nan=True), name
    assert mine.attributes["obstacles"] == theirs.attributes["obstacles"]
    assert (one / "history.csv").read_bytes() == (other / "history.csv").read_bytes()
    assert sorted(path.name for path in one.iterdir()) == sorted(path.name for path in other.iterdir())


def signalled(monkeypatch, number, when=5):
    """Send a signal to this process at a frame."""
    append = ResultFile.append

    def sent(self, moment, *fields):
        if len(self) == when:
            os.kill(os.getpid(), number)
        append(self, moment, *fields)

    monkeypatch.setattr(ResultFile, "append", sent)
