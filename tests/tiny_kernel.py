"""The smallest kernel: enough for Taichi to want to keep it. Run as a script with the folder of the checkout."""

import sys

import numpy as np


def run(factor=2.0):
    """Compile and run it; returns its answer."""
    from tcontact.device import runtime

    ti = runtime.start("cpu", 1)

    @ti.kernel
    def double(x: ti.types.ndarray(dtype=ti.f64, ndim=1)):
        for i in range(x.shape[0]):
            x[i] *= factor

    values = np.ones(3)
    double(values)
    return values


if __name__ == "__main__":
    sys.path.insert(0, sys.argv[1])
    print(run().sum())
