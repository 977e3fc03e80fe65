"""Logarithm, exponential and inverse cube root of float32 numbers, or vectors of lanes, without library calls.

The formulas of `transcendental` with exponents of 8 bits and mantissas of 23, and as many terms of the series as a
float32 needs. Constants of the logarithm: those of the C library of FreeBSD (msun, e_logf.c), a minimax polynomial.
"""

from ..engine import ti
from . import tensor3

SMALLEST_JACOBIAN = 1e-6  # as JACOBIAN_FLOOR of `transcendental`; 1 less this number differs from 1
LN2 = 0.6931471805599453094
LN2_HIGH = 0.693145751953125  # 16 bits: k LN2_HIGH is exact
LN2_LOW = 1.428606820309417232e-06
R0, R1, R2, R3 = 0.66666662693023682, 0.40000972151756287, 0.28498786687850952, 0.24279078841209412
LARGEST = 60.0  # of an exponent, either way: exp(60) = 1e26 leaves room for products
TWO_23 = 8388608.0
THIRD_GUESS = 5546987.52  # 4/3 (127 - 0.051) 2^15, for the high 23 bits of a number
ROUND = 12582912.0  # 1.5 * 2^23: adding it rounds to the nearest whole number
SPLIT = 0x004AFB0D  # splits mantissas at sqrt(1/2)


@ti.func
def log_series(z):
    """Return R(z) of `transcendental.log_split`."""
    return (R0 + R1 * z) + (R2 + R3 * z) * (z * z)


@ti.func
def exponent_of(a):
    """Return [exponent + 127, exponent as a float] of a = 2^exponent m, m in [0.70, 1.42)."""
    exponent = (tensor3.to_bits(a) + ti.u32(SPLIT)) >> ti.u32(23)
    return [exponent, tensor3.from_bits(exponent | ti.u32(0x4B000000)) - 8388735.0]


@ti.func
def log_split(change):
    e = ti.max(change, SMALLEST_JACOBIAN - 1.0)
    jacobian = 1.0 + e
    exponent = exponent_of(jacobian)
    k = exponent[1]
    power = tensor3.from_bits((ti.u32(254) - exponent[0]) << ti.u32(23))  # 2^-k
    t = e * power + (power - 1.0)
    inverse = 1.0 / (jacobian * (2.0 + t))
    f = t * (inverse * jacobian)
    z = f * f
    return [(e - t) - k * LN2 + f * (t - z * log_series(z)), inverse * (2.0 + t)]


@ti.func
def logarithm(a):
    exponent = exponent_of(a)
    k = exponent[1]
    t = tensor3.from_bits(tensor3.to_bits(a) - ((exponent[0] - ti.u32(127)) << ti.u32(23))) - 1.0
    f = t / (2.0 + t)
    z = f * f
    return k * LN2_HIGH + (k * LN2_LOW + (t - f * (t - z * log_series(z))))


@ti.func
def inverse_cube_root(a):
    """Return a^(-1/3) of a normal number a > 0; two iterations suffice."""
    high = tensor3.from_bits((tensor3.to_bits(a) >> ti.u32(8)) | ti.u32(0x4B000000)) - TWO_23
    shifted = tensor3.to_bits((THIRD_GUESS - high * (1.0 / 3.0)) + TWO_23)
    y = tensor3.from_bits((shifted & ti.u32(0x007FFFFF)) << ti.u32(8))
    for _ in ti.static(range(2)):
        r = 1.0 - (a * y) * (y * y)
        y = y + y * (r * (1.0 / 3.0 + r * (2.0 / 9.0)))
    return y


@ti.func
def exponential_parts(a):
    """Return [2^k, r, exp(r) - 1 - r, k] of a = k ln 2 + r."""
    b = ti.max(ti.min(a, LARGEST), -LARGEST)
    shifted = b * (1.0 / LN2) + ROUND
    k = shifted - ROUND
    power = tensor3.from_bits((tensor3.to_bits(shifted) + ti.u32(127)) << ti.u32(23))
    r = (b - k * LN2_HIGH) - k * LN2_LOW
    r2 = r * r
    low = (0.5 + r * (1 / 6)) + (1 / 24 + r * (1 / 120)) * r2
    high = (1 / 720 + r * (1 / 5040)) + (1 / 40320) * r2
    return [power, r, r2 * (low + (r2 * r2) * high), k]


@ti.func
def exponential_split(a):
    at = exponential_parts(a)
    power, r, rest, k = at[0], at[1], at[2], at[3]
    return [power * (r + rest) + (power - 1.0), power * rest + ((power - 1.0) * (1.0 + r) - k * LN2)]


@ti.func
def exponential(a):
    """Return exp(a) without the cancellation of 1 + (exp(a) - 1), which leaves few digits of a small one."""
    at = exponential_parts(a)
    return at[0] * (1.0 + (at[1] + at[2]))
