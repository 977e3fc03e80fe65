"""Runs on several ranks give what one rank gives: every term of explicit scenes, results, frames and files."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import tiers
from rank_scenes import CONTACT_RANKS, REASONS, SCENES
from test_ranks import HERE, mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing

from tcontact.planning.planning import plan
from tcontact.results.files.vtkhdf import ResultData

NOISE = ("static_residual", "energy_error")  # columns of rounding errors
BY_MPRGP = ("rubber",)  # rounding errors change the number of its products, not what they give
CANCEL = {"contact_force": "pair_force:lower-upper", "impulse": "pair_force:lower-upper"}
# test_rank_recut.py says of most of these with --long that two ranks and one process give the same
RECUT = ("corner", "pushed", "rigid", "pulled", "varied", "pressed", "crossed", "squeezed", "tied")
ELSEWHERE = () if tiers.slow() else (*RECUT, "hung", "mashed", "scraped")
ON_TWO = tiers.of_tier(
    ("normal", "walls", "loose"),
    (name for name in SCENES if name not in ("halves", "springy", "knocked", *ELSEWHERE)),
)
SEVERAL = {
    3: tiers.of_tier(("pair",), ("averaged", "normal", "halves", "springy", "knocked", "bonded")),
    4: tiers.of_tier(("free",), ("held", "halves")),
}


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Results of one process."""
    folder = tmp_path_factory.mktemp("alone")
    environment = os.environ | {"PYTHONPATH": str(HERE.parent), "OMP_NUM_THREADS": "1"}
    names = dict.fromkeys(name for _count, name in CASES)
    command = [sys.executable, "rank_results.py", str(folder), *names]
    subprocess.run(command, cwd=HERE, env=environment, check=True, timeout=1200)
    return folder


@pytest.fixture(scope="module")
def together(tmp_path_factory):
    """Results of several ranks, by their number."""
    found = {}

    def run(count):
        if count not in found:
            found[count] = tmp_path_factory.mktemp(f"ranks-{count}")
            done = mpiexec(count, "rank_results.py", found[count], *SEVERAL.get(count, ON_TWO), timeout=1200)
            assert done.returncode == 0, done.stderr
            assert not done.stderr
        return found[count]

    return run


def scale(values):
    """Largest finite magnitude of values."""
    return np.abs(np.where(np.isfinite(values), values, 0.0)).max(initial=0.0)


def differs(one, other, bound, unit=0.0):
    """Return whether arrays differ by more than the bound over the largest value, or over `unit`."""
    if one.shape != other.shape or not np.array_equal(np.isfinite(one), np.isfinite(other)):
        return True
    with np.errstate(invalid="ignore"):
        apart = np.where(one == other, 0.0, one - other)
    return bool(scale(apart) > bound * max(scale(one), unit))


def units(known):
    """Return by column what its numbers are compared with where they cancel: a moment, a force, an energy."""
    start = {name: scale(known[f"history {name}"]) for name in ("momentum", "kinetic", "energy")}
    force = scale(known["history contact_force"]) + start["momentum"] / known["history time"][-1]
    found = dict.fromkeys(
        ("angular_momentum", "momentum", "impulse", "damping_impulse", "support_impulse"), start["momentum"]
    )
    return found | dict.fromkeys(("contact_force", "support_force", "applied_force"), force)


def unlike(known, found, noise=NOISE):
    """Return the values of a run on several ranks that are not those of one process: (name, difference, size).

    noise: columns of the history that are not compared.
    """
    wrong = []
    scales = units(known)
    for key in known.files:
        column = key.removeprefix("history ")
        if key == "reason" or column in noise:
            continue
        bound = 1e-6 if key.startswith("pressure") else 1e-11  # records hold float32
        unit = scales.get(column, 0.0)
        if "moment" in column or "rotation" in column or "angular" in column:
            unit = max(unit, 1.0)
        if differs(known[key], found[key], bound, unit):
            wrong.append((key, scale(known[key] - found[key]), scale(known[key])))
    return wrong


CASES = [(2, name) for name in ON_TWO] + [(count, name) for count, names in SEVERAL.items() for name in names]


@pytest.mark.parametrize(("count", "name"), CASES)
def test_a_run_on_several_ranks_is_that_on_one(alone, together, count, name):
    known, found = (np.load(folder / name / "values.npz") for folder in (alone, together(count)))
    assert known.files == found.files
    assert str(found["reason"]) == str(known["reason"]) == REASONS.get(name, "finished")
    assert found["steps"] == known["steps"]
    assert abs(found["limit"] / known["limit"] - 1.0) < 1e-10
    assert unlike(known, found, (*NOISE, "sweeps") if name in BY_MPRGP else NOISE) == []


@pytest.mark.parametrize(("count", "name"), CASES)
def test_copies_of_nodes_have_equal_bits_and_ranks_share_the_contact_where_asked(together, count, name):
    told = np.load(together(count) / name / "ranks.npz")
    assert told["copies"] == 0
    if name in CONTACT_RANKS:
        assert told["touching"] == min(count, CONTACT_RANKS[name])
    else:
        assert told["touching"] <= 1


def test_a_shared_contact_takes_one_exchange_for_every_colour_of_a_sweep(together):
    """Beside these: forces of cells, of contact cells, what the solve leaves; rows of K_KK; active rows, friction.

    A pair of accelerated sweeps takes one more.
    """
    folder = together(2) / "walls"
    told, known = np.load(folder / "ranks.npz"), np.load(folder / "values.npz")
    body = plan(SCENES["walls"]()).bodies[0]
    sweeps, steps = known["history sweeps"].sum(), int(known["steps"])
    start = 100  # for the search for the stable step
    colours = body.contact.graph.colours
    assert 0.5 * colours * sweeps < told["messages"] <= (colours + 0.5) * sweeps + 8 * steps + start


def test_momentum_follows_the_impulses_where_a_shared_solve_leaves_forces_unbalanced(together):
    """They are shared out over the ranks to the nodes that carry the mass of the contact nodes."""
    known = np.load(together(2) / "loose" / "values.npz")
    momentum, impulse = known["history momentum"], known["history impulse"]
    assert known["history static_residual"].max() > 1e-5
    assert np.abs(momentum - momentum[0] - impulse).max() < 1e-14 * np.abs(momentum).max()


@pytest.mark.parametrize(("count", "name"), CASES)
def test_the_parts_of_the_ranks_hold_the_frames_of_one(alone, together, count, name):
    one, several = (ResultData.open(folder / name / "result.vtkhdf") for folder in (alone, together(count)))
    assert len(several.parts) == count
    assert np.array_equal(one.points, several.points)
    for (kind, known), (other, found) in zip(one.blocks, several.blocks, strict=True):
        assert kind == other
        assert np.array_equal(known, found)
    assert np.allclose(one.times, several.times, rtol=1e-12, atol=0.0)
    with one.opened() as first, several.opened() as second:
        frames = [(first(index), second(index)) for index in range(len(one))]
    for group in ("point_data", "cell_data"):
        for field in getattr(frames[0][0], group):
            pairs = [(getattr(known, group)[field], getattr(found, group)[field]) for known, found in frames]
            largest = max(scale(known) for known, _ in pairs)
            assert not any(differs(known, found, 1e-11, largest) for known, found in pairs), field
        assert all(getattr(known, group).keys() == getattr(found, group).keys() for known, found in frames)


def test_several_ranks_leave_the_files_of_one_and_their_parts(alone, together):
    one, several = ({path.name for path in (folder / "normal").iterdir()} for folder in (alone, together(2)))
    assert several - one == {"result-parts"}
    assert one <= several
    assert json.loads((together(2) / "normal/summary.json").read_text(encoding="utf-8"))["ranks"] == 2


@pytest.mark.parametrize(("count", "name"), [pytest.param(4, "free", marks=pytest.mark.long), (2, "walls")])
def test_the_same_run_on_the_same_ranks_has_equal_bits(together, tmp_path, count, name):
    done = mpiexec(count, "rank_results.py", tmp_path, name)
    assert done.returncode == 0, done.stderr
    first, second = (np.load(Path(folder) / name / "values.npz") for folder in (together(count), tmp_path))
    assert [key for key in first.files if first[key].tobytes() != second[key].tobytes()] == []
