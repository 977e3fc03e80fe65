"""What the commands do on one rank alone when a launcher has started several processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import Any

from ..base.errors import InputError, OutputError
from ..device.ending import ending_all
from ..device.team import team


@contextmanager
def on_first_rank(enter: Callable[[], AbstractContextManager[Any]]) -> Iterator[None]:
    """Enter a context on the first rank, or the only one; its `InputError` or `OutputError` ends all ranks."""
    found = team()
    with ExitStack() as stack:
        error: Exception | None = None
        with ending_all(found):
            if found is None:
                stack.enter_context(enter())
            elif found.leads:
                try:
                    stack.enter_context(enter())
                except (InputError, OutputError) as own:
                    error = own
            if found is not None:
                found.agree(error)
        yield
