"""The loads of t = 0 on a GPU, by the block of threads that applies those of later levels (device_contact.py)."""

import functools

from ..engine import ti
from ..lanes import BLOCK_THREADS
from ..language.bundles import ContactOptions
from ..language.compile_options import LEAVE_TO_LLVM, compiled_with
from ..language.signatures import Signature, kernel_of
from ..nodes.device_nodes import step_numbers
from ..nodes.shared_loads import apply_shared_loads


@functools.cache
def make_device_loads(signature: Signature, options: ContactOptions, pulled: bool):
    """Return the kernel device_loads(g_x, g_y, g_z, *arrays), memoised.

    signature: of a Body, a Boundary and a Contact without arrays; g [m/s^2]: gravity; pulled: it is a function of time.
    """

    @ti.func
    def device_loads(
        g0: ti.template(), g1: ti.template(), g2: ti.template(), body: ti.template(), boundary: ti.template(),
        contact: ti.template(),
    ):  # fmt: skip
        ti.loop_config(block_dim=BLOCK_THREADS)
        for _ in range(BLOCK_THREADS):
            numbers = step_numbers(body, ti.static([0.0, 0.0, 0.0, g0, g1, g2]), False)
            own = ti.static(body if pulled else body._replace(params=numbers))
            apply_shared_loads(own, boundary, contact, 0, pulled)

    made = kernel_of(device_loads, signature, (), ("g0", "g1", "g2"), options=options)
    return compiled_with(made, **LEAVE_TO_LLVM)
