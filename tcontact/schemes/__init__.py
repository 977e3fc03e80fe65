"""Time schemes by name. Each is one file that reads like its formula.

How it works. The explicit `CentralDifference` moves nodes with mass by the forces of the present position and leaves
what has no mass to the static solve; its step is bound by the fastest wave through the smallest cell
(`explicit/stable_step.py`). The implicit schemes share `implicit/scheme.py`: they solve M (c d - b) + f* - fc* = f_ext
for the step d by Newton's method and differ only in where and how the forces f*, fc* are taken, which their class
attributes say. `order`, `conserves` and `name` are attributes of every scheme.
"""

from __future__ import annotations

from typing import Any

from ..base.errors import InputError, hint
from .explicit.central_difference import CentralDifference
from .implicit.discrete_gradient import DiscreteGradient
from .implicit.dissipative import Dissipative
from .implicit.gonzalez import Gonzalez
from .implicit.hilber_hughes_taylor import HilberHughesTaylor
from .implicit.midpoint import Midpoint
from .implicit.paper_implicit import PaperImplicit
from .implicit.scheme import ImplicitScheme
from .implicit.transport_averaging import StressAveraging, TransportAveraging
from .implicit.trapezoidal import Trapezoidal

Scheme = CentralDifference | ImplicitScheme

IMPLICIT: tuple[type[ImplicitScheme], ...] = (
    DiscreteGradient,
    Gonzalez,
    TransportAveraging,
    StressAveraging,
    Midpoint,
    Trapezoidal,
    HilberHughesTaylor,
    Dissipative,
    PaperImplicit,
)
SCHEMES: dict[str, type[Scheme]] = {CentralDifference.name: CentralDifference} | {
    scheme.name: scheme for scheme in IMPLICIT
}


def scheme_of(value: Any) -> Scheme:
    """Return a scheme object, from itself or from its name. Raises `InputError` for anything else."""
    if isinstance(value, str):
        if value not in SCHEMES:
            raise InputError("scheme", value, hint(value, SCHEMES) + "use one of " + ", ".join(map(repr, SCHEMES)))
        return SCHEMES[value]()
    if not isinstance(value, (CentralDifference, ImplicitScheme)):
        raise InputError("scheme", value, "give a scheme object or one of " + ", ".join(repr(name) for name in SCHEMES))
    return value
