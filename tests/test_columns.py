"""The table of columns alone knows where a number stands: in any other order the results are the same."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scenes import python, simulate, thrown

import tcontact as tc
from tcontact.kernels.columns import COLUMNS, SUMS

REVERSED = """
import json
from importlib.machinery import SourceFileLoader

original = SourceFileLoader.get_code

def get_code(self, name):
    if not name.endswith("kernels.columns"):
        return original(self, name)
    source, mark = self.get_data(self.path).decode(), "\\nSHARED = "
    assert source.count(mark) == 1
    return compile(source.replace(mark, "\\nCOLUMNS = COLUMNS[::-1]" + mark), self.path, "exec")

SourceFileLoader.get_code = get_code
import test_columns
"""


def scene(removal):
    """A block that rubs along two walls which move, with every term that measures something."""
    contact = tc.MasslessContact(removal=removal) if removal else tc.PenaltyContact(1e11)
    found = thrown(kind="tet4", cells=2, walls=2, contact=contact, gap=0.001, speed=0.2, duration=1.0)
    walls = [replace(wall, velocity=(0.3, -0.2, 0.1)) for wall in found.obstacles]
    friction, damping = tc.Coulomb(0.3), tc.MassDamping(50.0)
    viscosity = tc.BulkViscosity() if removal else None
    return replace(found, obstacles=walls, friction=friction, damping=damping, viscosity=viscosity)


def history(removal):
    """Return the columns of the run of a scene as lists."""
    return {name: column.tolist() for name, column in simulate(scene(removal)).history.items()}


def order():
    """Return the names of the columns in their order, and name and place of those that share one array."""
    return [column.name for column in COLUMNS], [[name, place] for name, place in SUMS._asdict().items()]


@pytest.mark.parametrize("removal", [None, pytest.param("normal", marks=pytest.mark.slow)])
def test_the_order_of_the_table_changes_nothing(removal):
    """Exactly but for the sums of several columns, whose order is that of the table."""
    here = history(removal)
    done = python(REVERSED + f"print(json.dumps([test_columns.order(), test_columns.history({removal!r})]))")
    assert done.returncode == 0, done.stderr[-2000:]
    (names, places), there = json.loads(done.stdout)
    assert names == order()[0][::-1]
    assert not {*map(tuple, places)} & {*map(tuple, order()[1])}, "every number stands somewhere else"
    assert there.keys() == here.keys()
    assert list(there) != list(here)
    for name in ("contact_force", "friction_work", "damping_work", *(name for name in here if "moment:" in name)):
        assert np.abs(here[name]).max() > 0.0, name
    for name, column in here.items():
        if name in ("energy", "energy_error"):
            assert there[name] == pytest.approx(column, rel=1e-9, abs=1e-9 * max(here["kinetic"])), name
        else:
            assert there[name] == column, name
