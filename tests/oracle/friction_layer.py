"""Friction layer by the method of lines: cell-centred volumes, rates, a stiff integrator of SciPy. Shares no code.

States: temperature and plastic strain of every volume, and the stress. Plastic flow by a small overstress,

    dep/dt = (1 + beta ep)/(n beta) (sig/Y - 1)_+ / eta,   H dsig/dt = -3G integral of dep/dt

which tends to the rate-independent law as eta -> 0: the overstress is eta times the logarithmic rate of hardening.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp


def volumes(count: int, ratio: float, thickness: float) -> np.ndarray:
    """Widths of `count` volumes from the surface down, last/first = ratio."""
    width = np.exp(np.linspace(0.0, np.log(ratio), count))
    return thickness * width / width.sum()


def layer(
    metal,
    velocity: float,
    pressure: float,
    times: np.ndarray,
    *,
    thickness: float = 10e-6,
    heat_share: float = 0.5,
    initial: float = 300.0,
    count: int = 100,
    ratio: float = 100.0,
    eta: float = 1e-13,
    rtol: float = 1e-7,
) -> tuple[np.ndarray, np.ndarray]:
    """Surface temperature [K] and tau [Pa] at the times [s]."""
    width = volumes(count, ratio, thickness)
    centre = np.cumsum(width) - width / 2
    k, c = metal.conductivity, metal.density * metal.heat_capacity
    exponent, beta = metal.hardening_exponent, metal.hardening
    melting, modulus = metal.melting_temperature, 3.0 * metal.shear_modulus / thickness
    hot, cold, end = slice(0, count), slice(count, 2 * count), 2 * count  # temperature, plastic strain, stress
    unit = np.concatenate([np.full(count, 1e3), np.full(count, 1e-2), [1e9]])

    link = k / np.diff(centre)
    conduction = np.diag(-np.append(link, 0.0) - np.append(0.0, link)) + np.diag(link, 1) + np.diag(link, -1)
    conduction /= c * width[:, None]
    heating = heat_share * velocity / np.sqrt(3.0) / (c * width[0])

    def limit(t, strain):
        room = np.maximum(melting - t, 1e-9)
        linear = 1.0 + metal.pressure_factor * pressure - metal.thermal_softening * (t - metal.reference_temperature)
        softer = -metal.thermal_softening / linear - metal.sharpness * melting / room**2
        return metal.yield_stress * (1.0 + beta * strain) ** exponent * linear * np.exp(
            -metal.sharpness * t / room
        ), softer

    def rates(_, scaled):
        state = scaled * unit
        t, strain, sig = state[hot], state[cold], state[end]
        over = np.maximum(sig / limit(t, strain)[0] - 1.0, 0.0)
        flow = (1.0 + beta * strain) / (exponent * beta * eta) * over
        warming = conduction @ t
        warming[0] += heating * sig
        return np.concatenate([warming, flow, [-modulus * (width @ flow)]]) / unit

    def jacobian(_, scaled):
        state = scaled * unit
        t, strain, sig = state[hot], state[cold], state[end]
        stress, softer = limit(t, strain)
        flows = sig > stress
        factor = np.where(flows, (1.0 + beta * strain) / (exponent * beta * eta), 0.0)
        matrix = np.zeros((end + 1, end + 1))
        matrix[hot, hot] = conduction
        matrix[0, end] = heating
        matrix[cold, hot] = np.diag(-factor * sig / stress * softer)
        matrix[cold, cold] = np.diag(np.where(flows, (sig / stress - 1.0) / (exponent * eta) - sig / stress / eta, 0.0))
        matrix[cold, end] = factor / stress
        matrix[end] = -modulus * (width @ matrix[cold])
        return matrix * unit / unit[:, None]

    start = np.concatenate([np.full(count, initial), np.zeros(count), [limit(np.array(initial), np.array(0.0))[0]]])
    found = solve_ivp(
        rates,
        (0.0, times[-1]),
        start / unit,
        method="BDF",
        t_eval=times,
        jac=jacobian,
        rtol=rtol,
        atol=rtol * 1e-2,
        first_step=times[-1] * 1e-8,
    )
    if not found.success:
        raise RuntimeError(found.message)
    tau = found.y[end] * 1e9 / np.sqrt(3.0)
    return found.y[0] * 1e3 + heat_share * velocity * tau * width[0] / 2 / k, tau
