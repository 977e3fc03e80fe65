"""Kernels traced quickly are the kernels that were written (tcontact/device/tracing.py)."""

import gc
import importlib
import inspect
import pkgutil

import numpy as np
import pytest

from tcontact import kernels
from tcontact.device import runtime, tracing

ti = runtime.start()


@ti.func
def doubled(x):
    x = 2.0 * x
    return x


@ti.func
def with_first_doubled(values):
    values[0] = 2.0 * values[0]
    return values[0] + values[1]


@ti.func
def total(values):
    return values[0] + values[1]


@ti.func
def later(x, values: ti.types.ndarray(ti.f64, 1)):
    values[0] = 7.0
    return x


@ti.kernel
def calls(values: ti.types.ndarray(ti.f64, 1)):
    for _ in range(1):
        a = values[0]
        b = [a, values[1]]
        values[2] = doubled(a) + doubled(doubled(a))
        values[3] = with_first_doubled(b)
        values[4] = total(b) + total([total(b), total([a, b[1]])])
        c = later(a, values)
        d = later(values[5], values)
        a += 1.0
        b[1] = 0.0
        values[6] = a
        values[7] = total(b)
        values[8] = c + d


def test_a_function_changes_only_its_own_copies():
    values = np.array([3.0, 5.0, 0, 0, 0, 1.0, 0, 0, 0])
    calls(values)
    assert values.tolist() == [7.0, 5.0, 6.0 + 12.0, 11.0, 8.0 + 16.0, 1.0, 4.0, 3.0, 3.0 + 1.0]


def functions():
    for module in pkgutil.walk_packages(kernels.__path__, kernels.__name__ + "."):
        importlib.import_module(module.name)
    kernel_impl = pytest.importorskip("taichi.lang.kernel_impl")
    return [one.func for one in gc.get_objects() if isinstance(one, (kernel_impl.Func, kernel_impl.Kernel))]


def test_the_source_of_a_function_is_that_of_inspect():
    read = tracing._source_lines(inspect.getsourcelines)
    found = functions()
    assert len(found) > 300
    for function in found:
        lines, first = read(function)
        expected, start = inspect.getsourcelines(function)
        assert first == start
        assert "".join(lines).rstrip() == "".join(expected).rstrip(), function
