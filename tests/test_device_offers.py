"""What a step on a GPU offers to its static solve, against brute force over what a block of steps would have cost."""

import numpy as np
import pytest

from tcontact.schemes.explicit import device_offers


def cost_of(needs, offered, rest, costs):
    """Cost of steps that need so many passes each, taken one by one from offers of so many."""
    total = 0.0
    for need in needs:
        while need > 0:
            total += rest + sum(costs[min(number, len(costs) - 1)] for number in range(offered))
            need -= offered
    return total


@pytest.mark.parametrize("seed", range(20))
def test_passes_cost_least(seed):
    random = np.random.default_rng(seed)
    needs = random.integers(1, 9, 32) if seed % 2 else random.choice([1, 2, 5], 32, p=[0.8, 0.15, 0.05])
    costs, rest = list(random.uniform(20.0, 200.0, random.integers(1, 4))), random.uniform(20.0, 200.0)
    counts = np.bincount(needs, minlength=9)[1:9]
    found = device_offers.passes(counts, rest, costs)
    assert cost_of(needs, found, rest, costs) == pytest.approx(
        min(cost_of(needs, offered, rest, costs) for offered in range(1, 9))
    )


@pytest.mark.parametrize("seed", range(20))
def test_launches_of_sweeps_cost_least(seed):
    random = np.random.default_rng(seed)
    sweeps = random.choice([0, 10, 11, 40], 32, p=[0.5, 0.3, 0.15, 0.05]) if seed % 2 else random.integers(17, 25, 32)
    rest, one = random.uniform(50.0, 300.0), random.uniform(20.0, 100.0)
    needs = np.maximum(-(-sweeps // 4), 1)
    found = device_offers.launches(sweeps, 4, rest, one)
    assert cost_of(needs, found, rest, [one]) == pytest.approx(
        min(cost_of(needs, offered, rest, [one]) for offered in range(1, 12))
    )


def test_nothing_solved_offers_one():
    """No solve has ended yet, and no row is there."""
    assert device_offers.passes(np.zeros(8), 50.0, [60.0]) == 1
    assert device_offers.launches(np.zeros(0), 4, 50.0, 60.0) == 1
