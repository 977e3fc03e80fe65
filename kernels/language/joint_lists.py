"""Lists of whole numbers that share one array, for kernels that would have more arguments than Taichi takes.

The array begins with the place of every list; number i of list k is array[array[k] + i]. Kernels only read them.
"""

import numpy as np

from ..engine import ti


@ti.func
def number_of_list(array: ti.template(), k: ti.template(), i):
    """Return number i of list k."""
    return array[array[k] + i]


class JointList:
    """List k of a joint array inside a kernel; it is indexed like an array of its own."""

    def __init__(self, array, k: int) -> None:
        self.array, self.k = array, k

    def __getitem__(self, i):
        return number_of_list(self.array, self.k, i)


def joined(lists: list[np.ndarray]) -> np.ndarray:
    """Return the joint array [int32] of flat lists."""
    ends = np.cumsum([len(lists), *(part.size for part in lists)])
    return np.concatenate([ends[:-1], *(part.ravel() for part in lists)]).astype(np.int32)
