"""The step kernel with a law that leaves out the energy density: what is left of the ledger in the cells shows."""

from copy import copy
from typing import Any

from .. import runtime
from ..launch import Prepared
from ..packing import WIDTH
from ..terms.internal_force import InternalForce


def without_energy(force: InternalForce, variant: str, law: str) -> InternalForce:
    """The same pass over the same arrays, without the energy density (variant, law: names of the kernels)."""
    from ..kernels import internal_force, laws

    name = law + " without energy"
    laws.LAWS.setdefault(name, _bare(laws.LAWS[law]))
    laws.MODULI.setdefault(name, laws.MODULI[law])
    other = copy(force)
    other.kernel = Prepared(internal_force.make_step(variant, name, WIDTH))
    return other


def _bare(law: Any) -> Any:
    ti = runtime.load()

    @ti.func
    def bare(h, moduli):
        answer = law(h, moduli)
        return [answer[0], 0.0 * moduli[1], answer[2]]

    return bare
