"""Which body of a pair is the slave: a curved or sharp one before a flat and coarse one, else the softer one."""

import warnings

import numpy as np
import pytest
from pair_scenes import soft

import tcontact as tc

SIDES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")
HELD = [tc.Support("zmin", "xyz")]


def block(cells, young=1.0, faces="zmax", supports=HELD, name="block"):
    """Return a block of 4 by 2 by 2 whose top is at z = 0."""
    mesh = tc.box_mesh((4, 2, 2), cells, origin=(-2, -1, -2))
    return tc.Body(mesh, soft(young=young), contact=faces, supports=supports, name=name)


def above(mesh, young, gap=0.01, speed=0.01, contact="auto", name="body"):
    """Return a body that comes down on the block, its lowest node at that gap."""
    mesh = mesh.translated((0.0, 0.0, gap - mesh.nodes[:, 2].min()))
    return tc.Body(mesh, soft(young=young), (0, 0, -speed), contact=contact, name=name)


def cube(tilt=0.0):
    """Return a cube of 3 cells each way, turned about y by so many degrees."""
    return tc.box_mesh((1, 1, 1), (3, 3, 3), origin=(-0.5, -0.5, 0.0)).rotated(((0, 1, 0), np.radians(tilt)))


def impact(cells, ball, slave=None, **options):
    """Return a scene in which a ball 5 times stiffer falls on the block."""
    bodies = [block(cells), above(tc.ball_mesh(1.0, ball), 5.0, contact="low", **options)]
    pairs = "auto" if slave is None else [tc.Pair("block", "body", slave=slave)]
    return tc.Scene(bodies, duration=1e-9, contact=tc.MasslessContact("full"), pairs=pairs)


def chosen(*bodies, **options):
    """Return the names of the slaves of all pairs of a scene of bodies."""
    scene = tc.Scene(bodies, duration=400.0, contact=tc.MasslessContact("full"), **options)
    return {pair.name: scene.label(pair.slave) for pair in scene.body_pairs}


def said(scene):
    """Return the texts of the slave warnings of a run of a scene."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        tc.simulate(scene)
    return [str(one.message) for one in found if issubclass(one.category, tc.SlaveWarning)]


@pytest.mark.parametrize("faces", ["zmax", SIDES])
@pytest.mark.parametrize("young", [0.01, 1.0, 5.0, 100.0])
def test_a_curved_body_is_the_slave_of_a_flat_and_coarse_one_however_stiff(faces, young):
    """Balls, finer or coarser than the block, and wherever they come down."""
    for cells in (2, 3, 6):
        body = above(tc.ball_mesh(1.0, cells), young, contact="surface")
        assert chosen(block((4, 3, 3), faces=faces, supports=()), body) == {"block-body": "body"}


def test_stiffness_decides_on_a_fine_mesh_and_between_flat_faces():
    """Half a face of the finest block is a twentieth of the radius; an upright cube meets it with a flat face."""
    assert chosen(block((40, 20, 2)), above(tc.ball_mesh(1.0, 4), 5.0, contact="low")) == {"block-body": "block"}
    assert chosen(block((4, 3, 3)), above(cube(), 5.0, contact=SIDES)) == {"block-body": "block"}
    assert chosen(block((4, 3, 3)), above(cube(), 0.2, contact=SIDES)) == {"block-body": "body"}


@pytest.mark.parametrize("gap", [0.01, 3.0])
def test_a_sharp_body_is_the_slave_of_a_flat_one(gap):
    """A cube that comes edge first, from near or from far."""
    for tilt in (20.0, 45.0):
        assert chosen(block((12, 8, 3)), above(cube(tilt), 5.0, gap, contact=SIDES)) == {"block-body": "body"}


def test_a_round_body_in_a_hole_of_its_size_has_the_order_of_stiffness():
    """Rings that fit: their surfaces bend alike."""
    for young, slave in ((10.0, "outer"), (0.1, "inner")):
        bodies = [
            tc.Body(tc.ring_mesh(0.5, 1.0, 0.2, 24, layers=1), soft(young=young), contact="outer", name="inner"),
            tc.Body(tc.ring_mesh(1.0, 1.5, 0.2, 72, layers=1), soft(), contact="inner", name="outer"),
        ]
        assert chosen(*bodies, pairs=[tc.Pair("inner", "outer", initial_gap="closed")]) == {"inner-outer": slave}


def test_a_ball_leaves_the_order_of_other_bodies_as_it_is():
    """Three bodies: it goes before the soft block, which stays before the stiffer flat one."""
    lower = tc.Body(
        tc.box_mesh((4, 2, 1), (4, 3, 1), origin=(-2, -1, -3.0)), soft(young=3.0), contact="zmax", name="base"
    )
    faces = ("zmin", "zmax")
    bodies = [lower, block((4, 3, 3), faces=faces, supports=()), above(tc.ball_mesh(1.0, 3), 9.0, contact="surface")]
    assert chosen(*bodies)["block-body"] == "body"
    assert chosen(*bodies)["base-block"] == "block"


@pytest.mark.parametrize(("cells", "ball"), [((4, 3, 3), 3), ((8, 6, 4), 8)])
def test_a_stiff_ball_on_a_coarse_block_is_not_felt_before_it_touches_and_gains_nothing(cells, ball):
    """With the softer block as slave a force acted from the start on and threw the ball back with 2.1 to 2.4 m v."""
    scene = impact(cells, ball)
    scene = tc.Scene(scene.bodies, duration=22.0, contact=scene.contact)
    result = tc.simulate(scene, history_rows=10**6)
    force = result.pair_force["block-body"][:, 2] * -1.0
    time, momentum = result.history["time"], scene.bodies[1].mass * 0.01
    assert time[np.flatnonzero(force)[0]] >= 0.95
    assert 1.7 < np.trapezoid(force, time) / momentum < 2.001
    assert np.abs(result.history["energy_error"]).max() < 5e-3


def test_a_flat_slave_that_was_named_is_told_and_a_curved_one_is_not():
    """The advice leads to the right body, whichever is stiffer."""
    (text,) = [one for one in said(impact((4, 3, 3), 3, "block")) if "curved or sharp" in one]
    assert "make body the slave" in text
    assert said(impact((4, 3, 3), 3, "body")) == []
    assert said(impact((4, 3, 3), 3)) == []


@pytest.mark.parametrize(("speed", "count"), [(0.01, 1), (1.0, 0), (0.0, 0)])
def test_rows_that_press_in_energy_where_nothing_touches_are_told(speed, count):
    """They are .015 of a face deep, which a fast ball does not feel and a slow one does."""
    found = said(impact((8, 6, 4), 8, "block", speed=speed))
    assert len([one for one in found if "where nothing touches yet" in one]) == count
