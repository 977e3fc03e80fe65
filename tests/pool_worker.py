"""What workers of a pool do in test_workers.py; run as a script with a folder it leaves a pool amid a run."""

import multiprocessing
import sys
from pathlib import Path

import tcontact as tc

BEGUN = multiprocessing.get_context("fork").Event()
FOLDER = Path(sys.argv[-1])


def begun(_time):
    """Gravity of a run that says when it is amid its steps [m/s^2]: it is asked for before too, to be checked."""
    if (FOLDER / "result.vtkhdf").exists():
        BEGUN.set()
    return 0.0, 0.0, -9.81


def block(duration, gravity=None):
    """A small block in free fall."""
    body = tc.Body(tc.box_mesh((0.1, 0.1, 0.1), (2, 2, 2)), tc.LinearElastic(1e6, 0.3, 1000.0))
    return tc.Scene([body], duration=duration, gravity=gravity)


def energy(strain, mu, bulk):
    """A law of an own energy."""
    return 0.5 * mu * (strain.I1_bar - 3.0) + 0.5 * bulk * (strain.J - 1.0) ** 2


def density(body):
    """The density that a body has in another process."""
    return body.material.density


def endless():
    """A run that ends by a signal alone."""
    tc.simulate(block(1e3, begun), out=FOLDER, frames=2)


if __name__ == "__main__":
    with multiprocessing.get_context("fork").Pool(1) as pool:
        pool.apply_async(endless)
        BEGUN.wait()
    print("left")
