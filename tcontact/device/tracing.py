"""Speed up the tracing of kernels: Taichi repeats work for every node of the source and every call of a function.

For every node it makes an excerpt of the source for error messages, and for every call of a `ti.func` it reads and
re-wraps the source of that function. This takes half of the time to the first step. The names replaced here are
internal to Taichi: where one is missing, tracing stays slow. Errors in kernels then name file, line and function
without the excerpt.
"""

from __future__ import annotations

import functools
import textwrap
from types import SimpleNamespace
from typing import Any


def quicken() -> None:
    """Replace the slow functions of Taichi, once per process, after its import."""
    try:
        from taichi.lang import kernel_impl
        from taichi.lang.ast import ast_transformer_utils

        context: Any = ast_transformer_utils.ASTTransformerContext
        lines, file = kernel_impl.getsourcelines, kernel_impl.getsourcefile
        kernel_impl.textwrap, context.get_pos_info  # noqa: B018 - raises if one is missing
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
