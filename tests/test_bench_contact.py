"""`tcontact bench`: what friction costs and what a gap query costs, with their errors. No times are judged."""

import numpy as np
import pytest
from conftest import THREADS

import tcontact as tc
from tcontact.lab.bench import pairs, queries, rubbing, static_solvers
from tcontact.planning import domain


def test_friction_rows_carry_errors_and_slide(monkeypatch):
    monkeypatch.setattr(rubbing, "SIZE", 2)
    monkeypatch.setattr(rubbing, "LAW", "linear")  # kernels that other tests compile too
    monkeypatch.setattr(rubbing, "STEPS", 4)
    monkeypatch.setattr(rubbing, "ROUNDS", 2)
    found = rubbing.rubbing("cpu", THREADS)
    assert {(row["removal"], row["friction"]) for row in found["rows"]} == {
        (removal, friction) for removal in ("normal", "full") for friction in ("coulomb", "layer")
    }
    assert all(row["energy_error"] < 0.5 and row["contact_nodes"] > 0 for row in found["rows"])
    text = rubbing.lines([found | {"ok": True, "threads": THREADS}, {"ok": False, "threads": 1, "reason": "why"}])
    assert len(text) == 5
    assert "why" in text[-1]


@pytest.mark.parametrize(
    "obstacle",
    [
        tc.Plane((0.1, 0.0, 0.2), (1.0, 2.0, 3.0)),
        tc.Sphere((0.0, 0.1, 0.0), 0.4, inside=True),
        tc.Cylinder((0.0, 0.1, 0.0), (1.0, 1.0, 0.0), 0.3),
        tc.Box((0.1, 0.0, 0.0), (0.3, 0.4, 0.5), axes=np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])),
        tc.Sdf(lambda p: np.linalg.norm(p, axis=1) - 0.3, origin=(-1.0,) * 3, spacing=0.1, nodes=(21,) * 3),
    ],
    ids=lambda obstacle: obstacle.shape,
)
def test_kernels_and_obstacles_have_the_same_gap(obstacle):
    positions = np.random.default_rng(3).uniform(-0.7, 0.7, (200, 3))
    _seconds, gaps = queries._timed(obstacle, positions)
    np.testing.assert_allclose(gaps, obstacle.gap(positions), atol=1e-14)


def test_queries_compare_a_sampled_sphere_with_the_exact_one(monkeypatch):
    monkeypatch.setattr(queries, "RINGS", 24)
    monkeypatch.setattr(queries, "CELLS", 16)
    monkeypatch.setattr(queries, "POINTS", 500)
    found = queries.queries("cpu", THREADS)
    exact, sampled = found["rows"]
    assert exact["gap_error"] < 1e-15
    assert 1e-6 < sampled["gap_error"] < 1e-2
    assert len(queries.lines([found | {"ok": True, "threads": 1}])) == 2


def test_the_cost_of_pairs_is_shared_out(monkeypatch):
    monkeypatch.setattr(pairs, "ROUNDS", 2)
    found = pairs.pairs("cpu", THREADS, 4, steps=30)
    assert [row["motion"] for row in found["rows"]] == ["falling", "sheared"]
    for row in found["rows"]:
        assert row["energy_error"] < 0.1
        assert 0.0 < row["rebuilds_per_step"] <= 2.0
        assert row["products_mean"] > 0.0
        assert sum(share["median"] for share in row["shares"].values() if share) <= 1.0
        assert row["shares"]["coupling"]["low"] > 0.0
        assert row["shares"]["solve"] is row["shares"]["force"] is None  # one launch, whose parts nobody can time
    assert pairs.face_pairs(pairs.scene(4, "falling")) > 16  # every slave face meets several
    text = pairs.lines([found | {"ok": True, "threads": THREADS}, {"ok": False, "threads": 1, "reason": "why"}])
    assert len(text) == 5
    assert " % | - | - | " in text[2]
    assert "why" in text[-1]


def test_the_solve_of_a_small_cube_is_not_timed_apart_and_that_of_a_large_one_is(monkeypatch):
    monkeypatch.setattr(static_solvers, "ROUNDS", 1)
    small = static_solvers.compare(4, THREADS, poissons=(0.3,), removals=("normal",))
    assert [row["contact_s"] for row in small] == [None, None]
    assert all(" | - | " in line for line in static_solvers.lines(small)[2:])
    monkeypatch.setattr(domain, "SMALL", dict.fromkeys(domain.SMALL, 1))
    large = static_solvers.compare(4, THREADS, poissons=(0.3,), removals=("normal",))
    assert all(0.0 < row["contact_s"]["median"] < row["step_s"]["median"] for row in large)
    assert all(" | - | " not in line for line in static_solvers.lines(large)[2:])
