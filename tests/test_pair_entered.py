"""Bodies of a pair that meet with faces that are not in their contact sets are told of before they go wrong."""

import warnings

import numpy as np
import pytest
from conftest import THREADS

import tcontact as tc
from tcontact.run.end_checks import energy_warning
from tcontact.run.guards import Stop, explained

RUBBER = tc.NeoHookean(young=1e6, poisson=0.3, density=1000.0)
HEAVY = tc.NeoHookean(young=1e7, poisson=0.3, density=2e4)
EDGE, SPEED, SPIN = 0.1, 1.0, 60.0


def landed(contact, turn=60.0, below="auto", duration=None, spin=SPIN):
    """Let a cube that spins fall on a plate, on which it arrives turned by so many degrees; return the result."""
    centre, half = np.array((0.013, 0.008, 0.0)), 0.5 * EDGE
    gap = np.radians(turn) / SPIN * SPEED
    corner = half * (np.cos(np.radians(turn)) + np.sin(np.radians(turn)))
    centre[2] = corner + gap
    mesh = tc.box_mesh((EDGE,) * 3, (3, 3, 3), origin=tuple(centre - half))
    plate = tc.box_mesh((0.4, 0.4, 0.1), (4, 4, 2), origin=(-0.2, -0.2, -0.1))
    velocity = np.cross((0.0, spin, 0.0), mesh.nodes - centre) - np.array((0.0, 0.0, SPEED))
    cube = tc.Body(mesh, RUBBER, velocity, contact=contact, name="cube")
    bodies = [cube, tc.Body(plate, HEAVY, contact=below, name="plate")]
    duration = gap / SPEED + 0.02 if duration is None else duration
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return tc.simulate(tc.Scene(bodies, duration=duration, contact=tc.MasslessContact("full")), threads=THREADS)


def told(result):
    """Return the warnings of faces that met outside of contact sets."""
    return [text for text in result.warnings if "contact='all'" in text and not text.startswith("the energy error")]


def test_faces_that_auto_left_out_are_told_of_where_they_land_and_all_holds_them():
    """After a quarter of a turn the edge beside the side lands: a third of the energy is lost, .01 with all faces."""
    result = landed("auto", 90.0)
    (text,) = told(result)
    assert "a face of body cube that contact='auto' did not choose at the start meets body plate" in text
    at = float(text.split("at t = ")[1].split(" s")[0])
    error = np.abs(result.history["energy_error"])
    assert error[result.history["time"] < at].max() < 0.01
    assert error.max() > 0.2
    (energy,) = [text for text in result.warnings if text.startswith("the energy error")]
    assert "cube met plate with faces that are not in their contact sets" in energy
    assert "smaller cfl" not in energy
    held = landed("all", 90.0, below="zmax")
    assert not held.warnings
    assert np.abs(held.history["energy_error"]).max() < 0.02


def test_a_node_that_no_contact_holds_is_told_of_inside_the_other_body():
    """The side of a cube, of which the lower face alone is named, goes into the plate with its inner nodes."""
    (text,) = told(landed("zmin", below="zmax"))
    assert "of body cube at (" in text
    assert "inside body plate at t = " in text
    assert "'zmin' of cube and 'zmax' of plate" in text


def test_bodies_that_do_not_turn_are_told_of_nothing():
    """The cube falls on its lower face and bounces."""
    assert not landed("auto", 0.0, duration=0.04, spin=0.0).warnings


def test_what_came_before_a_stop_is_in_its_message():
    """Stops that are no failure of the motion, and stops without bodies that met so, stay as they are."""
    stop = Stop("diverged", "the energy grew")
    assert explained(stop, "a met b").message == "the energy grew; before that a met b"
    assert explained(stop, "") is stop
    cut = Stop("interrupted", "stopped")
    assert explained(cut, "a met b") is cut
    assert explained(None, "a met b") is None


@pytest.mark.parametrize(("contact", "wanted"), [("zmin", True), ("all", False)])
def test_an_energy_error_between_bodies_names_the_faces_that_are_left_out(contact, wanted):
    """Also where none of them was seen to meet anything."""
    mesh = tc.box_mesh((1.0,) * 3, (3, 3, 3))
    bodies = [tc.Body(mesh.translated((0, 0, z)), RUBBER, contact=contact) for z in (0.0, 1.01)]
    bodies[1] = tc.Body(bodies[0].mesh.translated((0, 0, -1.01)), RUBBER, contact="zmax" if wanted else contact)
    scene = tc.Scene(bodies, duration=1.0, contact=tc.MasslessContact("full"))
    text = energy_warning(scene, tc.CentralDifference(), 1e-3, 0.0, (0.1, 0.5))
    assert ("contact='all'" in text) == wanted


def test_all_is_the_whole_surface_unless_a_set_has_that_name():
    """A periodic body leaves out the sides that repeat."""
    mesh = tc.box_mesh((1.0,) * 3, (3, 3, 3))
    every = tuple(mesh.face_sets)
    assert np.array_equal(tc.Body(mesh, RUBBER, contact="all").contact_faces, mesh.boundary_faces())
    assert len(tc.Body(mesh, RUBBER, contact=every).contact_faces) == len(mesh.boundary_faces())
    own = mesh.with_sets(face_sets={"all": mesh.face_sets["zmin"]})
    assert len(tc.Body(own, RUBBER, contact="all").contact_faces) == 9
    assert len(tc.Body(mesh, RUBBER, contact="all", periodic="xy").contact_faces) == 18
    with pytest.raises(tc.InputError):
        tc.Body(mesh, RUBBER, contact=["all", "zmin"])
