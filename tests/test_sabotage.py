"""The evidence can fail: with the computation spoilt, every case comes out wrong that cannot help it.

The hard cases do so in test_stability.py, where their kernels are compiled anyway.
"""

import pytest
import sabotage
from conftest import THREADS

import tcontact as tc
from tcontact import cases

# small sizes, and what each case cannot feel
RIGID = {"modulus": "it is compared with a rigid body"}
FREE = {"modulus": "energy and momenta are kept with every modulus"}
SMALL = {
    "bar-impact": ({"cells": 20}, {}),
    "ball-drop": ({"cells": 2}, {}),
    "block-on-block": ({"cells": 2, "lower_cells": 3}, RIGID),
    "bouncing-bar": ({"cells": 20, "contacts": 2}, {}),
    "clamped-plate": ({"cells": 12}, {"wall": "there is no wall"}),
    "cube-impact": ({"cells": 6}, {}),
    "hertz-impact": ({"cells": 3}, {}),
    "hot-slide": ({"cells": 2}, {}),
    "inflated-ring": (
        {"cells": 12, "periods": 6.0},
        {"wall": "there is no wall", "method": "there is no contact", "density": "it is compared at rest"},
    ),
    "layered-bar": ({"cells": 12}, {}),
    "incompressible-beam": ({"cells": 10, "duration": 0.5}, FREE),
    "metal-slide": (
        {"cells": 3},
        {"wall": "there is no wall", "friction": "the layers bear no more than half of mu p"},
    ),
    "oblique-plate-impact": ({"cells": 10, "law": "elastic", "friction": "coulomb"}, {"wall": "there is no wall"}),
    "penetration-energy": ({"cells": 4}, {}),
    "plate-impact": ({"cells": 30}, {}),
    "pressure-shear": ({"cells": 20}, {}),
    "pressed-seal": ({"cells": 2}, {"density": "it is compared at rest"}),
    "ring-in-ring": ({"cells": 16, "outer_cells": 48}, {"density": "the pressure is that of elastic rings"}),
    "rolling-cylinder": ({"cells": 12}, RIGID),
    "sliding-block": ({"cells": 4}, RIGID),
    "stack": ({"cells": 2, "blocks": 3}, {"modulus": "every stack carries its weight"}),
    "striker": ({"cells": 6, "striker": "box", "law": "linear", "poisson": 0.0}, {}),
    "two-bars": ({"cells": 12}, {"wall": "there is no wall"}),
    "two-cubes": ({"cells": 3}, FREE | {"wall": "there is no wall"}),
    "two-materials": ({"cells": 40}, {}),
    "two-spheres": ({"cells": 8}, {"wall": "there is no wall"}),
    "taylor-bar": ({"cells": 3}, {"modulus": "the yield stress stops the bar"}),
    "tumbling-block": ({"cells": 3, "duration": 4e-3}, FREE),
    "wall-shock": ({"cells": 40}, {}),
}


def run_case(name, change=None):
    """Checks of a small run of a case that fail, and whether the change altered anything; a refusal is noticed."""
    case = cases.load(name)
    scene = case.scene(**SMALL[name][0])
    words = dict(getattr(case, "SCHEME", {"scheme": "central-difference"}))
    kinds = (tc.CentralDifference, tc.DiscreteGradient, tc.PaperImplicit)
    scheme = {kind.name: kind for kind in kinds}[words.pop("scheme")](**words)
    simulate = sabotage.Spoilt(change) if change else tc.simulate
    try:
        found = case.checks(simulate(scene, scheme, threads=THREADS))
    except tc.InputError as refusal:
        return [str(refusal)], True
    return [check for check in found if not check.passed], getattr(simulate, "altered", False)


@pytest.mark.parametrize("change", ["wall", "modulus", "density", "duration"])
@pytest.mark.parametrize("name", ["bar-impact", "bouncing-bar", "cube-impact"])
def test_a_quick_case_notices_a_spoilt_computation(name, change):
    failed, altered = run_case(name, change)
    assert altered
    assert failed


@pytest.mark.slow
@pytest.mark.parametrize("name", SMALL)
def test_every_case_notices_a_spoilt_computation(name):
    """Right as it is; wrong with every change that alters its scene and that it can feel."""
    cannot_feel = SMALL[name][1]
    assert run_case(name) == ([], False)
    for change in sabotage.CHANGES:
        failed, altered = run_case(name, change)
        assert bool(failed) == (altered and change not in cannot_feel), change


def test_every_mechanical_case_is_spoilt():
    assert set(SMALL) == {name for name in cases.names() if hasattr(cases.load(name), "scene")}
