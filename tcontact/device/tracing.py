"""Speed up the tracing of kernels: Taichi repeats work for every node of the source and every call of a function.

For every node it makes an excerpt of the source for error messages, for every call of a `ti.func` it reads and
re-wraps the source of that function, and for every definition it reads the source around it to learn whether that is a
class. This takes more than half of the time to the first step. The names replaced here are
internal to Taichi: where one is missing, tracing stays slow. Errors in kernels then name file, line and function
without the excerpt.
"""

from __future__ import annotations

import functools
import inspect
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any


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


def quicken() -> None:
    """Replace the slow functions of Taichi, once per process, after its import."""
    try:
        from taichi.lang import kernel_impl
        from taichi.lang.ast import ast_transformer_utils

        context: Any = ast_transformer_utils.ASTTransformerContext
        lines, file = kernel_impl.getsourcelines, kernel_impl.getsourcefile
        kernel_impl.textwrap, kernel_impl._inside_class, context.get_pos_info  # noqa: B018 - raises if one is missing
    except (ImportError, AttributeError):
        return
    context.get_pos_info = _place
    kernel_impl.getsourcelines = functools.cache(lines)
    kernel_impl.getsourcefile = functools.cache(file)
    kernel_impl._inside_class = _inside_class
    kernel_impl.textwrap = SimpleNamespace(fill=_line, dedent=textwrap.dedent)


def _place(context: Any, node: Any) -> str:
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


def _inside_class(level_of_class_stackframe: int) -> bool:
    return "__qualname__" in sys._getframe(level_of_class_stackframe - 1).f_locals  # a name in the body of a class


def _line(line: str, tabsize: int = 4, **_options: Any) -> str:
    return line.expandtabs(tabsize).rstrip()
