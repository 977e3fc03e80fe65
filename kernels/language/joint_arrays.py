"""Arrays of a kernel that stand in two large ones (tcontact/device/joint.py); indexed like arrays of their own.

The array of whole numbers begins with the place and the size of every part. Those of joint_lists.py are lists of whole
numbers alone, which kernels only read, on CPUs too.
"""

from typing import Any, NamedTuple

from ..engine import ti

REALS, WHOLES = "joint_reals", "joint_wholes"  # arguments of a kernel with the two arrays
HEAD = 2  # numbers of a part at the beginning of the whole numbers


class _Parts(NamedTuple):
    array: Any
    wholes: Any
    number: int


class JointArray(_Parts):
    """Part `number` of the joint array `array`, of which `wholes` has the places; a tuple, which Taichi passes on."""

    def __getitem__(self, i: Any) -> Any:
        """Return number i, to read or to write."""
        return _at(self.array, _at(self.wholes, HEAD * self.number) + i)

    @property
    def shape(self) -> tuple[Any]:
        """Return its size."""
        return (_at(self.wholes, HEAD * self.number + 1),)


class Place(NamedTuple):
    """Which part of the joint arrays an argument is: its number, and whether its numbers are whole."""

    number: int
    whole: bool

    @property
    def needs(self) -> tuple[str, ...]:
        """Return the arguments that stand for it."""
        return (WHOLES,) if self.whole else (REALS, WHOLES)

    @property
    def source(self) -> str:
        """Return the text that makes it in a kernel, from the names above and JointArray."""
        return f"JointArray({WHOLES if self.whole else REALS}, {WHOLES}, {self.number})"


def _at(array: Any, place: Any) -> Any:
    builder = ti.lang.impl.get_runtime().compiling_callable.ast_builder()
    return ti.lang.impl.subscript(builder, array, place)
