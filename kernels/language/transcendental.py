"""Logarithm and exponential of positive numbers, or of vectors of lanes, without library calls.

    ln a = k ln 2 + 2 atanh(t/(2 + t)),  a = 2^k (1 + t), 1 + t in [0.70, 1.42)
    exp(a) - 1 = 2^k (exp(r) - 1) + (2^k - 1),  a = k ln 2 + r, |r| <= ln 2 / 2

by exponent bits and series in Estrin form (see `log_split` for the first); errors of one or two units in the last
place, for exp(a) - 1 also near a = 0. No branches: lanes stay vectors (a library call would end vectorisation). In
float32 (precision.py) they are those of single_transcendental.py.
"""

from ..engine import ti
from . import single_transcendental, tensor3
from .precision import or_in_single

JACOBIAN_FLOOR = 1e-10  # below it ln J and 1/J are taken at the floor: finite numbers for an inverted cell
LN2 = 0.6931471805599453094
R0, R1, R2, R3 = 0.66666666666666696883, 0.39999999999899443233, 0.28571428626003268742, 0.22222211130259877029
R4, R5, R6 = 0.18182889455674946039, 0.15331710618210771568, 0.14616585424888621989
LN2_HIGH = 6.93147180369123816490e-01  # 32 bits: k LN2_HIGH is exact
LN2_LOW = 1.90821492927058770002e-10
LARGEST = 300.0  # of an exponent, either way: exp(300) = 2e130 leaves room for products
TWO_52 = 4503599627370496.0
THIRD_GUESS = 5858043333968.0  # 4/3 (1023 - 0.051) 2^32, for the high 44 bits of a number
ROUND = 6755399441055744.0  # 1.5 * 2^52: adding it rounds to the nearest whole number


@ti.func
def log_series(z):
    """Return R(z) of `log_split`."""
    z2 = z * z
    low = (R0 + R1 * z) + (R2 + R3 * z) * z2
    high = (R4 + R5 * z) + R6 * z2
    return low + high * (z2 * z2)


@or_in_single(single_transcendental.log_split)
@ti.func
def log_split(change):
    """Return [e - ln(1 + e), 1/(1 + e)] of e = change, both accurate to the last digits also for tiny e.

    1 + e = 2^k (1 + t) with 1 + t in [0.70, 1.42) by exponent bits; with f = t/(2 + t), ln(1 + t) = 2 atanh f and
    t - ln(1 + t) = t f - f^3 R(f^2), R the minimax polynomial of degree 6 in Estrin form (error 5e-18 of ln).
    """
    e = ti.max(change, JACOBIAN_FLOOR - 1.0)
    jacobian = 1.0 + e
    exponent = (tensor3.to_bits(jacobian) + ti.u64(0x00095F619980C433)) >> ti.u64(52)  # splits at sqrt(1/2)
    power = tensor3.from_bits((ti.u64(2046) - exponent) << ti.u64(52))  # 2^-k
    k = tensor3.from_bits(exponent | ti.u64(0x4330000000000000)) - 4503599627371519.0  # exponent - 1023 as a float
    t = e * power + (power - 1.0)
    inverse = 1.0 / (jacobian * (2.0 + t))  # one division for both 1/(1 + e) and f
    f = t * (inverse * jacobian)
    z = f * f
    series = log_series(z)
    return [(e - t) - k * LN2 + f * (t - z * series), inverse * (2.0 + t)]


@or_in_single(single_transcendental.logarithm)
@ti.func
def logarithm(a):
    """Return ln a of a normal number a > 0; for any other finite a a finite number, so that unused lanes do no harm."""
    exponent = (tensor3.to_bits(a) + ti.u64(0x00095F619980C433)) >> ti.u64(52)  # splits at sqrt(1/2)
    mantissa = tensor3.from_bits(tensor3.to_bits(a) - ((exponent - ti.u64(1023)) << ti.u64(52)))
    k = tensor3.from_bits(exponent | ti.u64(0x4330000000000000)) - 4503599627371519.0  # exponent - 1023 as a float
    t = mantissa - 1.0
    f = t / (2.0 + t)
    z = f * f
    series = log_series(z)
    return k * LN2_HIGH + (k * LN2_LOW + (t - f * (t - z * series)))


@or_in_single(single_transcendental.inverse_cube_root)
@ti.func
def inverse_cube_root(a):
    """Return a^(-1/3) of a normal number a > 0, to one or two units in the last place, without a division.

    The bits of the result are about a constant less a third of those of a (error 4 %); three iterations of third order
    y <- y (1 + r/3 + 2 r^2/9), r = 1 - a y^3, follow.
    """
    high = tensor3.from_bits((tensor3.to_bits(a) >> ti.u64(20)) | ti.u64(0x4330000000000000)) - TWO_52
    shifted = tensor3.to_bits((THIRD_GUESS - high * (1.0 / 3.0)) + TWO_52)
    y = tensor3.from_bits((shifted & ti.u64(0x000FFFFFFFFFFFFF)) << ti.u64(20))
    for _ in ti.static(range(3)):
        r = 1.0 - (a * y) * (y * y)
        y = y + y * (r * (1.0 / 3.0 + r * (2.0 / 9.0)))
    return y


@ti.func
def exponential_less_one(a):
    """Return exp(a) - 1, with a limited to -300 .. 300."""
    return exponential_split(a)[0]


@or_in_single(single_transcendental.exponential)
@ti.func
def exponential(a):
    """Return exp(a), with a limited to -300 .. 300."""
    return 1.0 + exponential_split(a)[0]


@or_in_single(single_transcendental.exponential_split)
@ti.func
def exponential_split(a):
    """Return [exp(a) - 1, exp(a) - 1 - a], both accurate also for tiny a, with a limited to -300 .. 300."""
    b = ti.max(ti.min(a, LARGEST), -LARGEST)
    shifted = b * (1.0 / LN2) + ROUND
    k = shifted - ROUND
    power = tensor3.from_bits((tensor3.to_bits(shifted) + ti.u64(1023)) << ti.u64(52))  # 2^k
    r = (b - k * LN2_HIGH) - k * LN2_LOW
    r2 = r * r
    r4 = r2 * r2
    low = (0.5 + r * (1 / 6)) + (1 / 24 + r * (1 / 120)) * r2
    middle = (1 / 720 + r * (1 / 5040)) + (1 / 40320 + r * (1 / 362880)) * r2
    high = (1 / 3628800 + r * (1 / 39916800)) + (1 / 479001600 + r * (1 / 6227020800)) * r2
    rest = r2 * (low + r4 * (middle + r4 * high))  # exp(r) - 1 - r
    return [power * (r + rest) + (power - 1.0), power * rest + ((power - 1.0) * (1.0 + r) - k * LN2)]
