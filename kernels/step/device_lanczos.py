"""Lanczos vectors on a GPU for the stable step of a body, without the host between two products.

With K w = -M (f(u + s w) - f(u))/s, s = D/max|w|, the products and recurrence of schemes/explicit/stable_step.py are

    r = M^-1 K w_k - beta_(k-1) w_(k-1),  alpha_k = w_k.M r,  r <- r - alpha_k w_k,  beta_k = |r|_M,  w_(k+1) = r/beta_k

All numbers stay in `numbers`: for every vector alpha, beta and max|w|, then the sums for the first vector. They are
combined over the threads by a fixed tree (device_folds.py). The vectors are kept in 16 bits, two numbers over the
largest one in a whole number, for the start of the next search.

A vector of zero length gives zeros from there on; the host looks for it in the numbers at the end.
"""

import functools

from ..engine import ti
from ..lanes import DEVICE_BLOCK
from ..language.arguments import ARRAY, INDEX
from ..language.threads import fold, turns_of
from .device_folds import FOLDERS, fold_threads, make_fold

ENTRY, ALPHA, BETA, LARGEST = 3, 0, 1, 2  # numbers of a vector, and their places
SUMS = 3  # numbers behind those of the vectors
UNIT = 32767.0  # of the kept vectors


@ti.func
def inverse_or_zero(a):
    """Return 1/a, or 0 of what is not positive."""
    return ti.select(a > 0.0, 1.0 / ti.select(a > 0.0, a, 1.0), 0.0)


@ti.func
def whole(value):
    """Return a number of [-1, 1] in 16 bits."""
    return ti.cast(ti.round(ti.max(-1.0, ti.min(1.0, value)) * UNIT), ti.i32) & 65535


@ti.func
def part_of(packed, place: ti.template()):
    """Return one of the two numbers in a whole number."""
    shifted = packed << 16 if ti.static(place == 0) else packed
    return ti.cast(shifted >> 16, ti.f64) / UNIT


@functools.cache
def make_lanczos(threads: int):
    """Return the kernels by name, for so many threads a loop, memoised; first, end: numbers of the body in a vector."""

    @ti.kernel
    def begin(u: ARRAY, first: ti.i32, end: ti.i32, trial: ARRAY, answer: ARRAY):
        """Prepare the product at u itself."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            for turn in range(turns_of(t, threads, end - first)):
                i = first + t + turn * threads
                trial[i] = u[i]
                answer[i] = 0.0

    @ti.kernel
    def norms(start: ARRAY, here: ARRAY, mass: ARRAY, first: ti.i32, end: ti.i32, partial: ARRAY):
        """Sum up start.M start, here.M here and start.M here."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            sums = [0.0, 0.0, 0.0]
            for turn in range(turns_of(t, threads, end - first)):
                i = first + t + turn * threads
                a, b, m = start[i], here[i], mass[i // 3]
                sums[0] += m * a * a
                sums[1] += m * b * b
                sums[2] += m * a * b
            for k in ti.static(range(SUMS)):
                partial[k * threads + t] = sums[k]

    @ti.kernel
    def join(
        start: ARRAY, here: ARRAY, numbers: ARRAY, sums_at: ti.i32, first: ti.i32, end: ti.i32, current: ARRAY,
        partial: ARRAY,
    ):  # fmt: skip
        """Make the first vector of start and here, each of unit length, and find its largest number."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            one, two, mixed = numbers[sums_at], numbers[sums_at + 1], numbers[sums_at + 2]
            a, b = inverse_or_zero(ti.sqrt(one)), inverse_or_zero(ti.sqrt(two))
            length = ti.sqrt(ti.max(one * a * a + two * b * b + 2.0 * mixed * a * b, 0.0))
            if length == 0.0:  # they cancel
                length, b = 1.0, 0.0
            most = 0.0
            for turn in range(turns_of(t, threads, end - first)):
                i = first + t + turn * threads
                value = (a * start[i] + b * here[i]) / length
                current[i] = value
                most = ti.max(most, ti.abs(value))
            partial[t] = most

    @ti.kernel
    def displace(
        u: ARRAY, current: ARRAY, numbers: ARRAY, entry: ti.i32, later: ti.i32, difference: ti.f64, first: ti.i32,
        end: ti.i32, trial: ARRAY, answer: ARRAY, kept: INDEX,
    ):  # fmt: skip
        """Bring a vector to unit length, keep it and prepare its product; later: 0 for the first vector.

        difference [m]: D; entry: place of its numbers.
        """
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            length = 1.0
            if later > 0:
                length = inverse_or_zero(numbers[entry - ENTRY + BETA])
            over = inverse_or_zero(numbers[entry + LARGEST])
            for turn in range(turns_of(t, threads, (end - first + 1) // 2)):
                pair = t + turn * threads
                i = first + 2 * pair
                packed = 0
                for k in ti.static(range(2)):
                    if i + k < end:
                        value = length * current[i + k]
                        current[i + k] = value
                        trial[i + k] = u[i + k] + difference * over * value
                        answer[i + k] = 0.0
                        packed = packed | (whole(value * over) << (16 * k))
                kept[pair] = packed

    @ti.kernel
    def respond(
        here: ARRAY, answer: ARRAY, current: ARRAY, before: ARRAY, mass: ARRAY, numbers: ARRAY, entry: ti.i32,
        later: ti.i32, difference: ti.f64, first: ti.i32, end: ti.i32, partial: ARRAY,
    ):  # fmt: skip
        """Put r into `before` and sum up alpha."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            beta = 0.0
            if later > 0:
                beta = numbers[entry - ENTRY + BETA]
            scale = numbers[entry + LARGEST] / difference
            total = 0.0
            for turn in range(turns_of(t, threads, end - first)):
                i = first + t + turn * threads
                value = (here[i] - answer[i]) * scale
                if later > 0:
                    value -= beta * before[i]
                before[i] = value
                total += mass[i // 3] * current[i] * value
            partial[t] = total

    @ti.kernel
    def reduce(
        current: ARRAY, before: ARRAY, mass: ARRAY, numbers: ARRAY, entry: ti.i32, first: ti.i32, end: ti.i32,
        partial: ARRAY,
    ):  # fmt: skip
        """Take alpha w off r; sum up its square and find its largest number."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            alpha = numbers[entry + ALPHA]
            total, most = 0.0, 0.0
            for turn in range(turns_of(t, threads, end - first)):
                i = first + t + turn * threads
                value = before[i] - alpha * current[i]
                before[i] = value
                total += mass[i // 3] * value * value
                most = ti.max(most, ti.abs(value))
            partial[t] = total
            partial[threads + t] = most

    @ti.kernel
    def fold_length(partial: ARRAY, numbers: ARRAY, entry: ti.i32):
        """Complete beta and the largest number of the next vector."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(FOLDERS):
            fold_threads(partial, t, ("sum", "max"), threads)
        for _ in range(1):
            total, most = fold(partial, 0, 1, FOLDERS, "sum"), fold(partial, threads, 1, FOLDERS, "max")
            beta = ti.sqrt(ti.max(total, 0.0))
            numbers[entry + BETA] = beta
            numbers[entry + ENTRY + LARGEST] = most * inverse_or_zero(beta)

    @ti.kernel
    def add_kept(kept: INDEX, weight: ti.f64, fresh: ti.i32, first: ti.i32, end: ti.i32, start: ARRAY):
        """Add a kept vector times its weight to `start`, which is 0 before if it is fresh."""
        ti.loop_config(block_dim=DEVICE_BLOCK)
        for t in range(threads):
            for turn in range(turns_of(t, threads, (end - first + 1) // 2)):
                pair = t + turn * threads
                packed = kept[pair]
                for k in ti.static(range(2)):
                    i = first + 2 * pair + k
                    if i < end:
                        old = start[i]
                        if fresh > 0:
                            old = 0.0
                        start[i] = old + weight * part_of(packed, k)

    own = (begin, norms, join, displace, respond, reduce, fold_length, add_kept)
    combined = {"fold_norms": ("sum",) * SUMS, "fold_largest": ("max",), "fold_alpha": ("sum",)}
    folds = {name: make_fold(threads, combine) for name, combine in combined.items()}
    return {kernel.__name__: kernel for kernel in own} | folds
