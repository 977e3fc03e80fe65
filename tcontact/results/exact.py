"""Solutions in closed form that a study compares with; each class says which equations it solves.

Symbols: density rho, wave speed c, length L, area A, impact speed v, stiffness of the wall per area kappa.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class PenaltyWall:
    """A linear bar with poisson 0 strikes a wall that pushes back with kappa p per area, p the overlap.

    With V the speed of the struck end into the wall and s = kappa p the pressure on it, V + s/(rho c) arrives from the
    bar and V - s/(rho c) leaves into it. The free end sends a wave back unchanged after T = 2L/c, so with
    a = kappa/(rho c)

        p' + a p = v                              0 < t < T
        p' + a p = v (2 exp(-a (t - T)) - 1)      T < t < 2T

    p = v/a (1 - exp(-a t)), then p = v/a [(2 - exp(-a T) + 2 a tau) exp(-a tau) - 1] with tau = t - T. Contact ends
    where this is zero again, at a tau = 1.678... for a T >> 1; a rigid wall is a -> infinity. Times count from touch.
    Valid for a T > 1.7 (the end lies in the second interval); at 5 rho c^2/L it is 10. Units: SI.
    """

    length: float
    area: float
    young: float
    density: float
    speed: float
    stiffness: float

    @property
    def rate(self) -> float:
        """a = kappa/(rho c) [1/s]."""
        return self.stiffness / np.sqrt(self.young * self.density)

    @property
    def crossing(self) -> float:
        """T = 2L/c [s]."""
        return 2.0 * self.length / np.sqrt(self.young / self.density)

    @cached_property
    def contact_time(self) -> float:
        """Time from touch to release [s]."""
        decay = np.exp(-self.rate * self.crossing)
        x = 1.6783469900166605
        for _ in range(50):  # Newton on 2 - decay + 2x = exp(x), convex: from the right it cannot fail
            x -= (np.exp(x) - 2.0 * x - 2.0 + decay) / (np.exp(x) - 2.0)
        return self.crossing + x / self.rate

    @property
    def largest_overlap(self) -> float:
        """Largest overlap [m]: at T or, where p still grows then, at the later zero of p'."""
        decay = np.exp(-self.rate * self.crossing)
        return float(self.overlap(self.crossing + max(0.0, decay / 2.0) / self.rate))

    def overlap(self, time: np.ndarray | float) -> np.ndarray:
        """Return the overlap p [m] at times since touch [s]; it is 0 before touch and after release."""
        time = np.clip(time, 0.0, self.contact_time)
        a, since = self.rate, np.maximum(np.asarray(time) - self.crossing, 0.0)
        first = -np.expm1(-a * np.minimum(time, self.crossing))
        second = (2.0 - np.exp(-a * self.crossing) + 2.0 * a * since) * np.exp(-a * since) - 1.0
        return np.maximum(0.0, np.where(since > 0.0, second, first)) * self.speed / a

    def impulse(self, time: np.ndarray | float) -> np.ndarray:
        """Return the integral of the contact force since touch [N s]."""
        time = np.clip(time, 0.0, self.contact_time)
        a, decay = self.rate, np.exp(-self.rate * self.crossing)
        early = np.minimum(time, self.crossing)
        first = early + np.expm1(-a * early) / a
        since = np.maximum(np.asarray(time) - self.crossing, 0.0)
        fall = -np.expm1(-a * since)  # integrals of exp(-x) and x exp(-x)
        second = ((2.0 - decay) * fall + 2.0 * (fall - a * since * np.exp(-a * since))) / a - since
        return self.stiffness * self.area * self.speed / a * (first + second)

    @property
    def rebound(self) -> float:
        """Mean speed of the bar after release over the speed it came with."""
        mass = self.density * self.area * self.length
        return float(self.impulse(self.contact_time)) / (mass * self.speed) - 1.0


@dataclass(frozen=True)
class WallShock:
    """A neo-Hookean block in uniaxial strain strikes a rigid wall: the jump conditions (Rankine-Hugoniot).

    Behind a shock of speed U through the reference configuration the block rests, with the stretch q = 1 - v/U and the
    nominal pressure rho U v = -P(q), P = mu (q - 1/q) + lambda (q - 1) (METHOD: the law of `NeoHookean`).
    """

    lame_lambda: float
    lame_mu: float
    density: float
    speed: float

    def stress(self, stretch: float) -> float:
        """Return the nominal stress P [Pa] at a stretch, the lateral ones being 1."""
        return self.lame_mu * (stretch - 1.0 / stretch) + self.lame_lambda * (stretch - 1.0)

    @cached_property
    def shock_speed(self) -> float:
        """Speed U [m/s] of the shock through the reference configuration, by bisection."""
        elastic = np.sqrt((self.lame_lambda + 2.0 * self.lame_mu) / self.density)
        low, high = max(self.speed * (1.0 + 1e-12), 1e-3 * elastic), 100.0 * (elastic + self.speed)
        for _ in range(200):
            middle = 0.5 * (low + high)
            if self.density * middle * self.speed + self.stress(1.0 - self.speed / middle) < 0.0:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    @property
    def stretch(self) -> float:
        """Stretch behind the shock."""
        return 1.0 - self.speed / self.shock_speed

    @property
    def pressure(self) -> float:
        """Nominal contact pressure [Pa] behind the shock, rho U v."""
        return self.density * self.shock_speed * self.speed


@dataclass(frozen=True)
class SofteningBar:
    """A St Venant-Kirchhoff bar (poisson 0) strikes a rigid wall: a simple wave, for compression softens the law.

    P(q) = E/2 (q^3 - q) with the stretch q; a small wave on it runs with c(q) = sqrt((3 q^2 - 1) E/(2 rho)) through the
    reference configuration, the slower the more it is compressed, so the wave spreads. Behind it the bar rests:

        v = integral of c(q) from q_wall to 1

    which has a solution up to q_wall = 1/sqrt(3), where c = 0: v <= .26603 sqrt(E/rho). Valid until the wave is back.
    """

    young: float
    density: float
    speed: float

    def reached(self, stretch: float) -> float:
        """Return the speed of impact [m/s] that compresses the bar to a stretch."""

        def integral(q: float) -> float:
            root = np.sqrt(max(q * q - 1.0 / 3.0, 0.0))
            return 0.5 * (q * root - np.log(q + root) / 3.0)

        return float(np.sqrt(1.5 * self.young / self.density) * (integral(1.0) - integral(stretch)))

    @cached_property
    def stretch(self) -> float:
        """Stretch at the wall, by bisection; that of the limit where there is no solution."""
        low, high = 1.0 / np.sqrt(3.0), 1.0
        for _ in range(100):
            middle = 0.5 * (low + high)
            if self.reached(middle) > self.speed:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    @property
    def pressure(self) -> float:
        """Nominal contact pressure [Pa], -P(q_wall)."""
        return 0.5 * self.young * self.stretch * (1.0 - self.stretch**2)


@dataclass(frozen=True)
class LameMode:
    """Free vibration of a free square block, edge L: u_y = B cos ky sin kz, u_z = -B sin ky cos kz, k = pi/L.

    It changes no volume and leaves every face free of traction for any poisson number (Lame 1852); its frequency is
    omega = k sqrt(2 mu/rho). The block starts flat with the velocity of the mode; amplitude B(t) = B sin(omega t).
    """

    edge: float
    lame_mu: float
    density: float
    amplitude: float

    @property
    def frequency(self) -> float:
        """omega [1/s]."""
        return np.pi / self.edge * np.sqrt(2.0 * self.lame_mu / self.density)

    def shape(self, points: np.ndarray) -> np.ndarray:
        """Return the displacement [n, 3] of the mode at points [n, 3], largest value 1."""
        y, z = np.pi / self.edge * points[:, 1], np.pi / self.edge * points[:, 2]
        return np.stack([np.zeros_like(y), np.cos(y) * np.sin(z), -np.sin(y) * np.cos(z)], axis=1)

    def gradient(self, points: np.ndarray) -> np.ndarray:
        """Return d(shape_i)/dX_j [n, 3, 3] [1/m]."""
        k = np.pi / self.edge
        y, z = k * points[:, 1], k * points[:, 2]
        result = np.zeros((len(points), 3, 3))
        result[:, 1, 1], result[:, 1, 2] = -k * np.sin(y) * np.sin(z), k * np.cos(y) * np.cos(z)
        result[:, 2, 1], result[:, 2, 2] = -k * np.cos(y) * np.cos(z), k * np.sin(y) * np.sin(z)
        return result

    def factor(self, time: float) -> float:
        """Return B sin(omega t) [m]."""
        return self.amplitude * float(np.sin(self.frequency * time))


@dataclass(frozen=True)
class SmoothBump:
    """Strain -(b(z)) with b = height cos^6(pi (z - centre)/(2 half)) inside centre +- half, travelling down at c.

    Over a prestrain -p the displacement is u(z) = -p z - B(z), B' = b, and the velocity -c b(z); the wall z = 0 then
    feels E A (p + 2 b(c t)): the wave arrives and doubles. Valid until its echo meets the far end.
    """

    prestrain: float
    height: float
    centre: float
    half: float

    def bump(self, z: np.ndarray) -> np.ndarray:
        """Return b(z)."""
        s = (np.asarray(z, dtype=float) - self.centre) / self.half
        return np.where(np.abs(s) < 1.0, self.height * np.cos(0.5 * np.pi * np.clip(s, -1.0, 1.0)) ** 6, 0.0)

    def integral(self, z: np.ndarray) -> np.ndarray:
        """Return B(z) [m], zero at z = 0: cos^6(x) = (10 + 15 cos 2x + 6 cos 4x + cos 6x)/32, term by term."""
        s = np.clip((np.asarray(z, dtype=float) - self.centre) / self.half, -1.0, 1.0)
        terms = 10.0 * s + sum(w * np.sin(m * np.pi * s) / (m * np.pi) for m, w in ((1, 15.0), (2, 6.0), (3, 1.0)))
        return self.height * self.half * (terms + 10.0) / 32.0
