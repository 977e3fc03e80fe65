"""A run goes on with another number of ranks: with the numbers of one that never stopped, or it is refused by name."""

import shutil
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import tiers
from test_ranks import HERE, mpiexec, pytestmark  # noqa: F401 - skips these tests where MPI is missing

from tcontact.base.errors import InputError
from tcontact.run.rank_recut import _check_known

SCENES = (
    "normal",
    "pushed",
    "pair",
    "rigid",
    "metal",
    "held",
    "pulled",
    "sensed",
    "walls",
    "rubbed",
    "varied",
    "pressed",
    "crossed",
    "squeezed",
    "tied",
    "hung",
    "mashed",
    "scraped",
    "rubber",
    "averaged",
    "bonded",
)
# all changes of all scenes with --slow alone: test_rank_runs.py has with --long what is left out from two ranks to one
ALL = SCENES if tiers.slow() else ()
ELSEWHERE = ("pair", "metal", "held", "rubber", "averaged", "bonded")
CHANGES = {
    (2, 1): tiers.of_tier(("pushed", "rubbed"), ALL, (name for name in SCENES if name not in ELSEWHERE)),
    (1, 2): tiers.of_tier(("sensed",), ALL, ("normal", "varied", "crossed", "hung", "scraped")),
    (2, 3): tiers.of_tier(("pair",), ALL, ("metal", "held", "varied", "squeezed", "averaged", "bonded")),
}
NAMES = tuple(dict.fromkeys(name for names in CHANGES.values() for name in names))
COUNTED = {1: "one process", 2: "2 ranks", 3: "3 ranks"}
BOUND = 1e-11  # of the largest value
NOISE = ("static_residual", "energy_error")  # columns of rounding errors
BY_MPRGP = ("rubber",)  # rounding errors change the number of its products, not what they give


def on(ranks, *words):
    """Run rank_resumed.py on some ranks, 1: as one process."""
    if ranks > 1:
        return mpiexec(ranks, "rank_resumed.py", *words)
    command = [sys.executable, "rank_resumed.py", *map(str, words)]
    return subprocess.run(command, cwd=HERE, capture_output=True, text=True, timeout=300, check=False)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The scenes in one process that never stops."""
    folder = tmp_path_factory.mktemp("whole")
    done = on(1, folder, "whole", *NAMES)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """The scenes stopped in step 6, by the number of ranks."""
    found = {}
    for ranks in (1, 2):
        found[ranks] = tmp_path_factory.mktemp(f"on-{ranks}")
        names = dict.fromkeys(name for (before, _), names in CHANGES.items() if before == ranks for name in names)
        done = on(ranks, found[ranks], "signalled", *names)
        assert done.returncode == 0, done.stderr
    return found


@pytest.mark.parametrize(("before", "after"), CHANGES)
def test_a_run_goes_on_with_another_number_of_ranks(whole, stopped, tmp_path, before, after):
    folder = tmp_path / "run"
    shutil.copytree(stopped[before], folder)
    done = on(after, folder, "resumed", *CHANGES[before, after])
    assert done.returncode == 0, done.stderr
    told = f"the run was on {COUNTED[before]} and goes on with {COUNTED[after]}"
    assert done.stdout.count(told) == len(CHANGES[before, after])  # every result has the warning
    for name in CHANGES[before, after]:
        one, two = (np.load(path / name / kind) for path, kind in ((whole, "whole.npz"), (folder, "resumed.npz")))
        assert str(np.load(folder / name / "signalled.npz")["reason"]) == "interrupted"
        assert str(two["reason"]) == "finished"
        assert not list((folder / name).rglob("checkpoint*"))
        for key in one.files:
            if key == "reason" or key in NOISE or (name in BY_MPRGP and key == "sweeps"):
                continue
            assert one[key].shape == two[key].shape, (name, key)
            scale = scale_of(key, one)
            same = (one[key] == two[key]) | (np.isnan(one[key]) & np.isnan(two[key]))
            assert (same | (np.abs(one[key] - np.where(same, 0.0, two[key])) <= BOUND * scale)).all(), (name, key)


def scale_of(key, values):
    """Return the largest value of a column; of forces and impulses that cancel in a pair the largest momentum."""
    momentum = np.abs(values["momentum"]).max()
    others = {"contact_force": momentum / values["time"][-1], "impulse": momentum, "energy": values["energy"].max()}
    return max(np.nanmax(np.abs(values[key]), initial=0.0), others.get(key, 1e-300))


def test_what_only_as_many_ranks_can_take_over_is_refused_by_name():
    stored = SimpleNamespace(found={"domains.0.unheard": np.zeros(1)}, values={})
    with pytest.raises(InputError, match=r"start 2 to go on, which a run with domains\.0\.unheard needs"):
        _check_known([stored, stored], 1)
