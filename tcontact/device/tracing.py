"""Speed up the tracing of kernels: Taichi repeats work for every node of the source and every call of a function.

For every node it makes an excerpt of the source for error messages, for every call of a `ti.func` it reads, parses and
re-wraps the source of that function, for every number it asks NumPy for the limits of its type, and for every
definition it reads the source around it to learn whether that is a class. It also copies each argument of a `ti.func`
into a new variable, which its compiler has to remove again: here an argument that is a variable already is passed as it
is, unless the function assigns to it; only to functions of this package, since those of others may change an argument
in other ways. All this takes more than half of the time to the first step. The names replaced here are internal to
Taichi: where one is missing, tracing stays slow.
Errors in kernels then name file, line and function without the excerpt.
"""

from __future__ import annotations

import ast
import functools
import inspect
import linecache
import operator
import sys
import textwrap
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import CodeType, SimpleNamespace
from typing import Any

from ..base import stages


@contextmanager
def quick_import() -> Iterator[None]:
    """Import Taichi inside: for each of its own functions it would search the module that every loaded file belongs to.

    The search serves source that is in no file.
    """
    search = inspect.getmodule
    inspect.getmodule = lambda *_arguments, **_options: None
    try:
        yield
    finally:
        inspect.getmodule = search


@dataclass
class Kernels:
    """The kernels of this process: how many were compiled, and how many there will be, 0 where that is not known."""

    so_far: int = 0
    expected: int = 0

    def another(self) -> str:
        """Count one more; return its number in words, such as "3 of 9"."""
        self.so_far += 1
        return f"{self.so_far} of {self.expected}" if self.so_far <= self.expected else str(self.so_far)


kernels = Kernels()


def _told(materialize: Any) -> Any:
    """Return the function that traces a kernel such that it says which one begins."""

    @functools.wraps(materialize)
    def telling(self: Any, key: Any = None, *arguments: Any, **options: Any) -> Any:
        if key is None or key not in self.compiled_kernels:
            stages.say(f"compiling kernel {kernels.another()}: {self.func.__name__}")
        return materialize(self, key, *arguments, **options)

    return telling


def quicken() -> None:
    """Replace the slow functions of Taichi, once per process, after its import."""
    try:
        from ..kernels.engine import ti

        impl, kernel_impl = ti.lang.impl, ti.lang.kernel_impl
        ast_transformer_utils = ti.lang.ast.ast_transformer_utils
        context: Any = ast_transformer_utils.ASTTransformerContext
        lines, file = functools.cache(_source_lines(kernel_impl.getsourcelines)), kernel_impl.getsourcefile
        kernel_impl.textwrap, kernel_impl._inside_class, context.get_pos_info  # noqa: B018 - raises if one is missing
        trees = _Trees(kernel_impl.ast.parse, kernel_impl.transform_tree)
        arguments = _Arguments(impl, kernel_impl, lines, trees)
        builder: Any = ast_transformer_utils.Builder
        build = _quick_build(builder.__call__)
        expr = ti.lang.expr
        transformer: Any = ti.lang.ast.ast_transformer.ASTTransformer
        binary = _quick_binary(transformer.build_BinOp)
        constant = _quick_constant(expr.make_constant_expr, expr.Expr, expr._ti_core, impl, ti)
    except (ImportError, AttributeError):
        return
    kernel_impl.Kernel.materialize = _told(kernel_impl.Kernel.materialize)
    context.get_pos_info = _place
    kernel_impl.getsourcelines = lines
    kernel_impl.getsourcefile = functools.cache(file)
    kernel_impl._inside_class = _inside_class
    kernel_impl.textwrap = SimpleNamespace(fill=_line, dedent=_dedented)
    kernel_impl.ast = SimpleNamespace(**(vars(kernel_impl.ast) | {"parse": trees.parse}))
    kernel_impl.transform_tree = trees.transform
    impl.expr_init, impl.expr_init_func = arguments.variable, arguments.parameter
    kernel_impl._process_args = arguments.process
    builder.__call__ = build
    expr.make_constant_expr = constant
    transformer.build_BinOp = staticmethod(binary)


def _place(context: Any, node: Any) -> str:
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


def _inside_class(level_of_class_stackframe: int) -> bool:
    return "__qualname__" in sys._getframe(level_of_class_stackframe - 1).f_locals  # a name in the body of a class


def _text(lines: list[str]) -> str:
    """Return the source of a function as Taichi puts it together."""
    return _dedented("\n".join([_line(line) for line in lines]))


_dedented = functools.cache(textwrap.dedent)  # once for every function, not for every call of it


def _line(line: str, tabsize: int = 4, **_options: Any) -> str:
    return line.expandtabs(tabsize).rstrip()


def _source_lines(slow: Any) -> Any:
    """Return a function that does what `inspect.getsourcelines` does for functions, without taking the text apart.

    A function ends where, behind its last instruction, a line is indented no further than its first one.
    """

    def source_lines(function: Any) -> tuple[list[str], int]:
        code: Any = getattr(function, "__code__", None)
        if code is not None:
            linecache.checkcache(code.co_filename)  # a file that was written anew and loaded again
        lines = linecache.getlines(code.co_filename) if code is not None else []
        if not lines:
            return slow(function)
        first, end = code.co_firstlineno - 1, _last_line(code)
        margin = _indent(lines[first])
        while end < len(lines) and (not lines[end].strip() or _indent(lines[end]) > margin):
            end += 1
        return lines[first:end], first + 1

    return source_lines


def _last_line(code: CodeType) -> int:
    inner = [_last_line(part) for part in code.co_consts if isinstance(part, CodeType)]
    return max([code.co_firstlineno, *(line for _, _, line in code.co_lines() if line is not None), *inner])


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


class _Trees:
    """Parsed sources, to be used again: each tree by one call at a time, since the calls write into it."""

    def __init__(self, parse: Any, transform: Any) -> None:
        self._parse, self._transform = parse, transform
        self._free: dict[str, list[Any]] = defaultdict(list)

    def parse(self, source: str) -> Any:
        """Return the tree of a source."""
        free = self._free[source]
        if free:
            return free.pop()
        tree = self._parse(source)
        tree.source = source
        return tree

    def release(self, tree: Any) -> None:
        """Let a tree be used again."""
        self._free[tree.source].append(tree)

    def transform(self, tree: Any, context: Any) -> Any:
        """Trace a tree and release it, unless it is a kernel, whose tree loses its arguments."""
        answer = self._transform(tree, context)
        if not context.is_kernel:
            self.release(tree)
        return answer


class _Reference:
    """An argument that the function reads where it stands."""

    def __init__(self, value: Any) -> None:
        self.value = value


class _Arguments:
    """Passing of arguments to functions that are inlined."""

    def __init__(self, impl: Any, kernel_impl: Any, lines: Any, trees: _Trees) -> None:
        self._variable, self._parameter = impl.expr_init, impl.expr_init_func
        self._process, self._expression = kernel_impl._process_args, kernel_impl.Expr
        self._inside, self._function = impl.inside_kernel, kernel_impl.Func
        self._lines, self._trees = lines, trees

    def variable(self, value: Any) -> Any:
        """Return a new variable with a value, marked as one."""
        made = self._variable(value)
        if type(made) is self._expression:
            made.is_variable = True
        return made

    def parameter(self, value: Any) -> Any:
        """Return a parameter of a function: the argument itself where it is passed as it is, else a copy."""
        return value.value if type(value) is _Reference else self._parameter(value)

    def process(self, function: Any, arguments: Any, named: Any) -> Any:
        """Return the arguments of a call in their order; those that the function only reads are passed as they are."""
        values = self._process(function, arguments, named)
        quick = type(function) is self._function and not function.is_real_function and _is_own(function.func)
        if quick and self._inside():
            for number in self._only_read(function):
                values[number] = self._passed(values[number])
        return values

    def _passed(self, value: Any) -> Any:
        if getattr(value, "is_variable", False):
            return _Reference(value)
        if type(value) in (list, tuple) and value:
            parts = [self._passed(part) for part in value]
            if any(type(part) is _Reference for part in parts):
                return _Reference(type(value)(self.parameter(part) for part in parts))
        return value

    def _only_read(self, function: Any) -> list[int]:
        """Return the numbers of the parameters without annotation that the function never assigns to."""
        found = getattr(function, "only_read", None)
        if found is None:
            tree = self._trees.parse(_text(self._lines(function.func)[0]))
            assigned = _assigned(tree)
            self._trees.release(tree)
            empty = inspect.Parameter.empty
            found = [
                number
                for number, one in enumerate(function.arguments)
                if one.annotation is empty and one.name not in assigned
            ]
            function.only_read = found
        return found


def _is_own(function: Any) -> bool:
    """Return whether this package defines a function: no such function changes what it passes on (tests)."""
    return str(function.__module__).startswith(__name__.partition(".")[0] + ".")


def _assigned(tree: ast.AST) -> set[str]:
    """Return the names that a source assigns to, wholly or in part."""
    names, left = set(), [tree]
    while left:
        node: Any = left.pop()
        kind = type(node)
        if kind in PARTS and type(node.ctx) is not ast.Load:
            root = node
            while type(root) in (ast.Subscript, ast.Attribute):
                root = root.value
            if type(root) is ast.Name:
                names.add(root.id)
        if kind is ast.Name or kind is ast.Constant:
            continue
        for field in kind._fields:
            part = getattr(node, field, None)
            if type(part) is list:
                left += [one for one in part if isinstance(one, ast.AST)]
            elif isinstance(part, ast.AST):
                left.append(part)
    return names


PARTS = (ast.Name, ast.Subscript, ast.Attribute)


def _quick_constant(slow: Any, expression: Any, core: Any, impl: Any, ti: Any) -> Any:
    """Return the function that makes an expression of a number, quickly for plain ones of the default kinds."""
    low, high = -(2**31), 2**31

    def constant(value: Any, dtype: Any) -> Any:
        kind = type(value)
        if dtype is None and kind is int and low <= value < high and impl.get_runtime().default_ip == ti.i32:
            return expression(core.make_const_expr_int(ti.i32, value))
        if dtype is None and kind is float and impl.get_runtime().default_fp == ti.f64:
            return expression(core.make_const_expr_fp(ti.f64, value))
        return slow(value, dtype)

    return constant


def _quick_binary(slow: Any) -> Any:
    """Return the function that traces an operation of two values, with one table of the operators for all."""
    operators: dict[type, Any] = {
        ast.Add: operator.add,
        ast.Sub: operator.sub,
        ast.Mult: operator.mul,
        ast.Div: operator.truediv,
    }

    def binary(context: Any, node: Any) -> Any:
        chosen = operators.get(type(node.op))
        if chosen is None:
            return slow(context, node)
        build = slow.__globals__["build_stmt"]
        build(context, node.left)
        build(context, node.right)
        node.ptr = chosen(node.left.ptr, node.right.ptr)
        return node.ptr

    return binary


def _quick_build(slow: Any) -> Any:
    """Return `Builder.__call__`, which visits a node, so that only statements note their place and report errors."""
    methods: dict[type, Any] = {}

    def build(self: Any, context: Any, node: Any) -> Any:
        kind = type(node)
        if kind not in methods:
            method = getattr(self, "build_" + kind.__name__, None)
            methods[kind] = None if issubclass(kind, ast.stmt) else method
        method = methods[kind]
        return slow(self, context, node) if method is None else method(context, node)

    return build
