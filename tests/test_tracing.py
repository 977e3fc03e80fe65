"""Kernels traced quickly are the kernels that were written (tcontact/device/tracing.py)."""

import ast
import gc
import importlib
import inspect
import linecache
import os
import pkgutil
import sys

import numpy as np
import pytest

from tcontact import kernels
from tcontact.device import runtime, tracing

ti = runtime.start()


def own(function):
    """Make a function one of the package, to which arguments are passed as they are."""
    function.__module__ = "tcontact.kernels.trial"
    return function


@ti.func
@own
def doubled(x):
    x = 2.0 * x
    return x


@ti.func
@own
def with_first_doubled(values):
    values[0] = 2.0 * values[0]
    return values[0] + values[1]


@ti.func
@own
def total(values):
    return values[0] + values[1]


@ti.func
@own
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


@ti.func
def raised(x: ti.template()):
    x += 1.0
    return x


@ti.func
def passed_on(x):
    return raised(x)


@ti.func
def before(x, same: ti.template()):
    same += 1.0
    return x


@ti.func
def read(x):
    return x


@ti.func
def added_at_once(x):
    ti.atomic_add(x, 1.0)
    return x


@ti.func
def first_passed_on(values):
    return raised(values[0])


@ti.func
def filled(vector):
    vector.fill(7.0)
    return vector[0]


@ti.kernel
def calls_of_others(values: ti.types.ndarray(ti.f64, 1)):
    for _ in range(1):
        a, b, c, d = values[0], values[0], values[0], values[0]
        values[1] = passed_on(a)
        values[2] = a
        values[3] = before(b, b)
        values[4] = read(c) + raised(c)
        values[5] = added_at_once(d)
        values[6] = d
        e = [values[0], values[0]]
        values[7] = first_passed_on(e)
        values[8] = e[0]
        f = ti.Vector([values[0], values[0]])
        values[9] = filled(f)
        values[10] = f[0]


def test_functions_of_others_get_copies_whatever_they_do_with_them():
    """What Taichi alone computes: a template changed through a copy, an atomic addition, a method that writes."""
    values = np.full(11, 1.0)
    calls_of_others(values)
    assert values.tolist() == [1.0, 2.0, 1.0, 1.0, 3.0, 2.0, 1.0, 2.0, 1.0, 7.0, 1.0]


def test_no_function_of_the_package_changes_an_argument_that_it_passes_on():
    """Passed as it is, the argument would change where the function was called; calls of fields are not followed."""
    trees = [(one, ast.parse(tracing._text(inspect.getsourcelines(one)[0])).body[0]) for one in functions()]
    changed, wrong, size = set(), set(), -1
    while size != len(changed):
        size = len(changed)
        for function, tree in trees:
            assigned, handed = tracing._assigned(tree), handed_on(function, tree, changed)
            for place, one in enumerate(tree.args.args):
                if one.annotation is None:
                    if one.arg in handed - assigned:
                        wrong.add(f"{function.__module__}.{function.__name__}({one.arg})")
                elif "template" in ast.unparse(one.annotation) and one.arg in assigned | handed:
                    changed.add((function, place))
    assert len(changed) > 5
    assert not wrong


def handed_on(function, tree, changed):
    """Return the names that a function hands to a place where they are changed."""
    names = set()
    for call in ast.walk(tree):
        if isinstance(call, ast.Call):
            called = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
            target = getattr(function.__globals__.get(called), "__wrapped__", None)
            for place, argument in enumerate(call.args):
                root = argument
                while isinstance(root, (ast.Subscript, ast.Attribute)):
                    root = root.value
                if isinstance(root, ast.Name) and ((target, place) in changed or called.startswith("atomic_")):
                    names.add(root.id)
    return names


def test_a_file_that_is_written_anew_is_read_anew(tmp_path, monkeypatch):
    """As a notebook does that reloads the modules of its user."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    source = "import taichi as ti\n@ti.kernel\ndef one() -> ti.f64:\n    return {}\n"
    path = tmp_path / "reloaded_kernels.py"
    path.write_text(source.format("1.0"))
    module = importlib.import_module("reloaded_kernels")
    assert module.one() == 1.0
    assert linecache.getlines(str(path))
    path.write_text("# moved\n" + source.format("23.0"))
    os.utime(path, (1, 1))
    assert importlib.reload(module).one() == 23.0


def functions():
    for module in pkgutil.walk_packages(kernels.__path__, kernels.__name__ + "."):
        importlib.import_module(module.name)
    kernel_impl = pytest.importorskip("taichi.lang.kernel_impl")
    found = [one.func for one in gc.get_objects() if isinstance(one, (kernel_impl.Func, kernel_impl.Kernel))]
    return [
        one for one in found if (one.__module__ or "").startswith(kernels.__name__) and one.__name__ not in globals()
    ]


def test_the_source_of_a_function_is_that_of_inspect():
    read = tracing._source_lines(inspect.getsourcelines)
    found = functions()
    assert len(found) > 300
    for function in found:
        lines, first = read(function)
        expected, start = inspect.getsourcelines(function)
        assert first == start
        assert "".join(lines).rstrip() == "".join(expected).rstrip(), function


def test_assigned_names_are_those_of_the_whole_tree():
    """All names that are stored to anywhere, or into an item or a part of which something is stored."""
    some = 0
    for function in functions():
        tree = ast.parse(tracing._text(inspect.getsourcelines(function)[0]))
        names = set()
        for node in ast.walk(tree):
            if not isinstance(getattr(node, "ctx", None) or ast.Load(), ast.Load):
                while isinstance(node, (ast.Subscript, ast.Attribute)):
                    node = node.value
                names |= {node.id} if isinstance(node, ast.Name) else set()
        assert tracing._assigned(tree) == names, function
        some += len(names)
    assert some > 1000


def test_this_taichi_is_traced_quickly():
    """Where a name that is replaced is missing, all stays slow without a word."""
    impl, expr = ti.lang.kernel_impl, ti.lang.expr
    replaced = [impl._process_args, expr.make_constant_expr, ti.lang.ast.ast_transformer.ASTTransformer.build_BinOp]
    assert {function.__module__ for function in replaced} == {tracing.__name__}


@ti.kernel
def numbers(values: ti.types.ndarray(ti.f64, 1), whole: ti.types.ndarray(ti.i32, 1)):
    for _ in range(1):
        values[0], values[1], values[2] = 1e-300, -0.1, 3
        values[3] = (7.0 - 2.0) / 4 + 0.5 * 3 - 2.0**3
        whole[0], whole[1] = 2147483647, -2147483648
        whole[2] = (17 // 5) * 10 + 17 % 5 + (1 << 4) + (6 & 3) + (6 | 1) - (5 ^ 1)
        whole[3] = 3 if True else 4


@ti.kernel
def too_large(whole: ti.types.ndarray(ti.i32, 1)):
    for _ in range(1):
        whole[0] = 2147483648


def test_numbers_and_operators_mean_what_they_mean_in_python():
    values, whole = np.zeros(4), np.zeros(4, np.int32)
    numbers(values, whole)
    assert values.tolist() == [1e-300, -0.1, 3.0, (7.0 - 2.0) / 4 + 0.5 * 3 - 2.0**3]
    expected = (17 // 5) * 10 + 17 % 5 + (1 << 4) + (6 & 3) + (6 | 1) - (5 ^ 1)
    assert whole.tolist() == [2147483647, -2147483648, expected, 3]
    with pytest.raises(ti.TaichiTypeError, match="exceeded the range"):
        too_large(whole)
