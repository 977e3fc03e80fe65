"""Cases of metals that slide on each other: their checks hold at small size, and fail where the physics does."""

from dataclasses import replace

import numpy as np
import pytest

import tcontact as tc
from tcontact.cases import metal_slide, oblique_plate_impact
from tcontact.results.files.vtkhdf import ResultData

EXPLICIT = tc.CentralDifference(cfl=0.5)


def failed(case, result):
    """The checks that fail."""
    return {check.name for check in case.checks(result) if not check.passed}


def spoilt(result, **columns):
    """A result with other columns: functions of what is there."""
    return replace(
        result, history=result.history | {name: made(result.history[name].copy()) for name, made in columns.items()}
    )


def wider(column):
    """A column that grows 1e-3 more than it did."""
    return (1.0 + 1e-3) * column


@pytest.fixture(scope="module")
def slide(tmp_path_factory):
    folder = tmp_path_factory.mktemp("slide")
    scene = metal_slide.scene(cells=3, speed=340.0, thickness=1e-6, heat_share=0.8)
    return folder, tc.simulate(scene, EXPLICIT, out=folder, frames=2)


def test_every_joule_stands_in_layers_blocks_and_cold_work(slide):
    """The cells of both blocks are as warm as the ledger says, and both are warmer where they slide."""
    folder, result = slide
    assert not failed(metal_slide, result)
    history, bodies = result.history, result.scene.bodies
    data = ResultData.open(folder / "result.vtkhdf")
    warm = np.split(data.frame(len(data) - 1).cell_data["temperature"] - 300.0, [bodies[0].mesh.cell_count])
    capacity = bodies[0].material.density * bodies[0].material.specific_heat
    held = [capacity * float(body.mesh.cell_volumes() @ rise) for body, rise in zip(bodies, warm, strict=True)]
    cold = 0.2 * history["plastic_work"][-1]
    work = history["friction_work"][-1] + history["plastic_work"][-1]
    assert abs(sum(held) + history["layer_heat"][-1] + cold - work) < 1e-6 * history["friction_work"][-1]
    assert min(held) > 0.2 * history["body_heat"][-1] > 1e-3 * work
    metal_slide.draw(replace(result), folder, "slide")
    assert (folder / "sliding.png").exists()
    assert (folder / "temperature" / "frames").is_dir()


@pytest.mark.parametrize("name", ["layer_heat", "body_heat", "plastic_heat", "friction_work"])
def test_a_lost_joule_fails_the_slide(slide, name):
    assert "joules missing, of the friction work" in failed(metal_slide, spoilt(slide[1], **{name: wider}))


def test_blocks_start_under_the_pressure_given_and_below_yield(slide):
    result = slide[1]
    pressure, _ = metal_slide.tractions(result)
    assert pressure[0] == pytest.approx(1.3e9, rel=2e-3)
    assert result.history["plastic_work"][0] == 0.0
    assert result.history["plastic_work"][-1] > 0.0


@pytest.mark.parametrize("coefficient", [0.1, 1.0])
def test_elastic_plates_slide_and_stick_as_plane_waves_do(coefficient, tmp_path):
    scene = oblique_plate_impact.scene(cells=20, law="elastic", friction="coulomb", coefficient=coefficient)
    result = tc.simulate(scene)
    assert not failed(oblique_plate_impact, result)
    waves, (pressure, shear) = oblique_plate_impact.exact(scene), oblique_plate_impact.tractions(result)
    middle = slice(len(pressure) // 4, -1)
    metal = scene.bodies[0].material
    assert waves.pressure == pytest.approx(0.5 * metal.density * metal.wave_speed * 100.0 * np.cos(np.pi / 6.0))
    assert pressure[middle].mean() == pytest.approx(waves.pressure, rel=3e-3)
    wanted = min(coefficient * waves.pressure, waves.sticking)
    assert shear[middle].mean() == pytest.approx(wanted, rel=1e-2)
    for name, spoil in (
        ("pair_force:flyer-target", lambda f: 1.03 * f),
        ("friction_work", lambda work: work + 0.05 * waves.sticking * waves.transverse * waves.area * result.time),
    ):
        assert failed(oblique_plate_impact, spoilt(result, **{name: spoil}))
    oblique_plate_impact.draw(result, tmp_path, "plates")
    assert {path.name for path in tmp_path.iterdir()} == {"tractions.png", "friction.png"}


def test_plates_that_yield_where_they_slide_converge():
    """The viscosity of contact cells keeps its elastic stiffness where the metal is soft: every static solve ends."""
    result = tc.simulate(oblique_plate_impact.scene(cells=10))
    assert not failed(oblique_plate_impact, result)
    assert result.history["plastic_strain_max"][-1] > 5e-3
    assert result.history["static_residual"].max() < 1e-4
    heavier = replace(result, scene=replace(result.scene, friction=replace(result.scene.friction, coefficient=0.01)))
    assert "shear above mu p, of the pressure" in failed(oblique_plate_impact, heavier)


@pytest.mark.parametrize(
    ("case", "wrong"),
    [
        (metal_slide, {"speed": 0.0}),
        (metal_slide, {"pressure": -1.0}),
        (metal_slide, {"heat_share": 1.5}),
        (oblique_plate_impact, {"angle": 90.0}),
        (oblique_plate_impact, {"friction": "glue"}),
        (oblique_plate_impact, {"target": "cheese"}),
        (oblique_plate_impact, {"law": "viscous"}),
        (oblique_plate_impact, {"coefficient": -0.1}),
    ],
)
def test_wrong_parameters_are_refused_by_name(case, wrong):
    with pytest.raises(tc.InputError) as caught:
        case.scene(**wrong)
    assert next(iter(wrong)) in str(caught.value)
