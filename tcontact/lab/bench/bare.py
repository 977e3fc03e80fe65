"""The step kernel with a law that leaves out the energy density; it shows what the ledger costs in the cells."""

from copy import copy
from typing import Any

from ...cells.device_force import DeviceForce
from ...cells.internal_force import InternalForce
from ...device import runtime
from ...device.launch import Prepared


def without_energy(force: InternalForce, variant: str, law: str) -> InternalForce:
    """Return the same pass over the same arrays, without the energy density (variant, law: names of the kernels)."""
    from ...kernels.language.signatures import signature_of
    from ...kernels.materials import LAWS
    from ...kernels.step import internal_force

    name = law + " without energy"
    LAWS.setdefault(name, LAWS[law]._replace(update=_bare(LAWS[law].update)))
    other = copy(force)
    kinds = ((variant, name),)
    if isinstance(force, DeviceForce):
        other.kernel = Prepared(force.kernel_for(kinds))
    else:
        other.kernel = Prepared(internal_force.make_step(kinds, signature_of({"body": force.bundle()})))
    return other


def _bare(update: Any) -> Any:
    ti = runtime.load()

    @ti.func
    def bare(h, parameters):
        answer = update(h, parameters)
        return [answer[0], 0.0 * answer[2], answer[2]]

    return bare
