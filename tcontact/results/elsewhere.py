"""The result of a run on the ranks other than the first, which alone has the values of nodes and cells."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any, ClassVar

from ..base.errors import InputError
from .result import ON_FIRST, Result


class ResultElsewhere(Result):
    """A `Result` without the fields `ON_FIRST`, each of which raises `InputError` where it is read."""

    rank: int
    whole: ClassVar[bool] = False

    @classmethod
    def on(cls, rank: int, **fields: Any) -> ResultElsewhere:
        """Make the result of this rank of its other fields; defaults are those of `Result`."""
        made = object.__new__(cls)
        made.__dict__.update(fields, rank=rank)
        return made

    def with_values(self, values: Mapping[str, Any]) -> Result:
        """Return the result with these values of nodes and cells."""
        return Result(**{name: value for name, value in vars(self).items() if name != "rank"}, **values)

    def reversed(self) -> Result:
        """Return this result: the velocities of the first rank are reversed."""
        return self

    def _repr_html_(self) -> str:
        """Return a line for a notebook: how it went, and who has what a picture needs."""
        where = f"rank {self.rank} has no values of nodes and cells: rank 0 has them, and shows this result"
        return f"<p>{escape(repr(self))}; {where}</p>"

    def _repr_png_(self) -> None:  # type: ignore[override]
        """Return no picture."""


def _of_first(name: str) -> property:
    def refuse(self: ResultElsewhere) -> Any:
        remedy = "the first rank alone has values of nodes and cells: read them where tc.is_first_rank() is True, or"
        remedy += " call result.on_all_ranks() on all ranks, with the communicator of the run where simulate had one"
        raise InputError(f"Result.{name}", f"on rank {self.rank}", remedy)

    return property(refuse, doc=f"Raises `InputError`: the first rank has {name}.")


for _name in ON_FIRST:
    setattr(ResultElsewhere, _name, _of_first(_name))
