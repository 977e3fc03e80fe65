"""Faster tracing of kernels: Taichi repeats much work for every node of the source and every call of a function.

For every node it draws an excerpt of the source, in case an error has to show it, and for every call of a `ti.func` it
reads and re-wraps the source of that function again. Half of the time to the first step goes there. The names that are
replaced here are not promised by Taichi: where one is missing, tracing stays as slow as it was. Errors in kernels then
name file, line and function without the excerpt.
"""

from __future__ import annotations

import functools
import textwrap
from types import SimpleNamespace
from typing import Any


def quicken() -> None:
    """Do it once per process, after Taichi is imported."""
    try:
        from taichi.lang import kernel_impl
        from taichi.lang.ast import ast_transformer_utils

        context: Any = ast_transformer_utils.ASTTransformerContext
        lines, file = kernel_impl.getsourcelines, kernel_impl.getsourcefile
        kernel_impl.textwrap, context.get_pos_info  # noqa: B018 - are they there?
    except (ImportError, AttributeError):
        return
    context.get_pos_info = _place
    kernel_impl.getsourcelines = functools.cache(lines)
    kernel_impl.getsourcefile = functools.cache(file)
    kernel_impl.textwrap = SimpleNamespace(fill=_line, dedent=textwrap.dedent)


def _place(context: Any, node: Any) -> str:
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


def _line(line: str, tabsize: int = 4, **_options: Any) -> str:
    return line.expandtabs(tabsize).rstrip()
