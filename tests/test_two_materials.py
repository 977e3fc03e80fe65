"""Two materials in a body: waves where they meet, the pressure of a contact face that holds both."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import tcontact as tc
from tcontact.cases import two_materials
from tcontact.results import checks as ck

STIFF, SOFT = tc.LinearElastic(4e7, 0.0, 1500.0), tc.LinearElastic(1e7, 0.0, 1000.0)


@pytest.mark.parametrize("second", [(4e7, 1500.0), (1e6, 300.0)])
def test_waves_are_reflected_and_transmitted_by_the_ratio_of_impedances(second):
    """1 % at 100 cells; into a softer part the bar leaves the hammer. One material alone does not pass for two."""
    scene = two_materials.scene(second_young=second[0], second_density=second[1])
    result = tc.simulate(scene)
    found = {check.name: check for check in two_materials.checks(result)}
    assert not [check for check in found.values() if not check.passed]
    assert len(found) == 8
    bar = scene.bodies[0]
    one = dataclasses.replace(bar, material=dict.fromkeys(bar.material, bar.material["first"]))
    wrong = tc.simulate(dataclasses.replace(scene, bodies=[one]))
    failed = [c.name for c in two_materials.checks(dataclasses.replace(wrong, scene=scene)) if not c.passed]
    assert failed == ["reflected wave / incident wave, error", "transmitted wave / incident wave, error"]


def pressed(removal, axis, shift):
    """A block of two materials side by side, squeezed onto a plane by a strain: rest is its exact equilibrium."""
    size = np.roll([0.03, 0.02, 0.04], axis)
    counts = np.roll([4, 2, 3], axis)
    origin = np.asarray(shift, dtype=float)
    mesh = tc.box_mesh(size, counts, origin=origin)
    letter, across = "xyz"[(axis + 2) % 3], axis % 3
    low = mesh.cell_centres()[:, across] < origin[across] + 0.5 * size[across]
    mesh = mesh.with_sets(cell_sets={"stiff": np.flatnonzero(low), "soft": np.flatnonzero(~low)})
    up = np.eye(3)[(axis + 2) % 3]
    strain = 1e-2

    def squeezed(nodes):
        return -strain * ((nodes - origin) @ up)[:, None] * up

    body = tc.Body(mesh, {"stiff": STIFF, "soft": SOFT}, contact=f"{letter}min", displacement=squeezed,
                   supports=[tc.Support(f"{letter}max", letter)])  # fmt: skip
    plane = tc.Plane(point=origin, normal=up)
    return tc.Scene([body], [plane], duration=3e-3, contact=tc.MasslessContact(removal)), up, strain


@pytest.mark.parametrize("removal", ["normal", "full"])
@pytest.mark.parametrize(("axis", "shift"), [(0, (0.0, 0.0, 0.0)), (1, (0.5, -0.2, 1.0))])
def test_a_contact_face_of_two_materials_bears_the_exact_pressure_of_each(removal, axis, shift):
    """Pressed by a rigid displacement d, columns without Poisson's effect of height L press with E d/L each; a node
    bears the pressures of the faces at it, nothing else, also where the materials meet, and nothing moves."""
    scene, up, strain = pressed(removal, axis, shift)
    body = scene.bodies[0]
    mesh, faces = body.mesh, body.mesh.faces_of(body.contact)
    x = mesh.nodes[faces]
    area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 3] - x[:, 0]), axis=1)
    stiff = set(map(frozenset, mesh.cells[mesh.cell_sets["stiff"]].tolist()))
    young = [STIFF.young if any(set(face) <= cell for cell in stiff) else SOFT.young for face in faces.tolist()]
    assert sorted(set(young)) == [SOFT.young, STIFF.young]
    share = np.repeat(np.array(young) * strain * area / 4.0, 4)
    exact = np.bincount(faces.reshape(-1), share, mesh.node_count)
    result = tc.simulate(scene)
    assert result.ok
    assert result.steps > 20
    force = result.contact_node_force
    assert force @ up == pytest.approx(exact, abs=1e-10 * exact.max())
    assert np.abs(force - (force @ up)[:, None] * up).max() <= 1e-10 * exact.max()
    assert result.history["contact_force"] @ up == pytest.approx(exact.sum(), rel=1e-10)
    assert np.abs(result.history["energy_error"]).max() <= 1e-10
    assert ck.no_overlap(result).passed
