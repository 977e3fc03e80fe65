"""Exact solutions of a bar against a wall, and the figures a computed contact force is judged by."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class BarImpact:
    """Linear bar of Poisson's ratio 0: length, gap [m], area [m^2], young [Pa], density [kg/m^3], speed [m/s]."""

    length: float
    area: float
    young: float
    density: float
    speed: float
    gap: float = 0.0

    @property
    def wave_speed(self):
        return np.sqrt(self.young / self.density)

    @property
    def force(self):
        """rho c v0 A [N]."""
        return self.density * self.wave_speed * self.speed * self.area

    @property
    def touch(self):
        return self.gap / self.speed

    @property
    def release(self):
        return self.touch + 2 * self.length / self.wave_speed

    def impulse(self, time):
        """Integral of the contact force from the start [N s]; zero before it."""
        return self.force * (np.clip(time, self.touch, self.release) - self.touch)

    def mean_force(self, time, dt):
        """Contact force averaged over [time - dt/2, time + dt/2] [N]."""
        return (self.impulse(time + dt / 2) - self.impulse(time - dt / 2)) / dt


def bar_metrics(exact, time, force, dt, momentum_end):
    """What a bar run is judged by; force [s] [N] along the bar's axis, momentum_end away from the wall [N s]."""
    mean = exact.mean_force(time, dt)
    running = np.concatenate([[0.0], np.cumsum((force[1:] + force[:-1]) * dt / 2)])
    share = (time - exact.touch) / (exact.release - exact.touch)
    plateau = force[(share > 0.1) & (share < 0.9)] / exact.force - 1
    threshold = 1e-6 * exact.force
    mass = exact.density * exact.area * exact.length
    return {
        "force_error": float(np.linalg.norm(force - mean) / np.linalg.norm(mean)),
        "impulse_error": float(np.abs(running - exact.impulse(time)).max() / exact.impulse(np.inf)),
        "plateau": float(np.sqrt(np.mean(plateau**2))),
        "variation": float(np.abs(np.diff(force)).sum() / (2 * exact.force)),
        "releases": int(np.sum((force[:-1] > threshold) & (force[1:] <= threshold))),
        "overshoot": float(force.max() / exact.force - 1),
        "rebound": float(momentum_end / (mass * exact.speed)),
    }


def characteristic_bar(exact, gravity, duration, count=2000):
    """Bar that falls (gravity [m/s^2] towards the wall) and bounces, by characteristics with unit Courant number.

    The waves are carried without error; touch and release are resolved to one step length / (count c).
    Returns time [s], contact force [N], height of the lower end above the wall [m], mean upward velocity [m/s].
    """
    c, rho = exact.wave_speed, exact.density
    dt = exact.length / count / c
    steps = int(duration / dt)
    # up = v - s/(rho c) travels away from the wall, down = v + s/(rho c) towards it (s = axial stress), one per cell
    up = np.full(count, -exact.speed)
    down = np.full(count, -exact.speed)
    time = np.arange(steps + 1) * dt
    force, height, mean = np.zeros(steps + 1), np.zeros(steps + 1), np.zeros(steps + 1)
    height[0], mean[0] = exact.gap, -exact.speed
    for n in range(steps):
        end = down[0] - gravity * dt / 2  # arriving at the lower end: v + s/(rho c)
        speed = max(end, -height[n] / dt)  # free end, or stopped at the wall
        stress = end - speed
        top = up[-1] - gravity * dt / 2
        force[n + 1] = -rho * c * stress * exact.area
        height[n + 1] = height[n] + speed * dt
        leaving = speed - stress
        up = np.concatenate([[leaving - gravity * dt / 2], up[:-1] - gravity * dt])
        down = np.concatenate([down[1:] - gravity * dt, [top - gravity * dt / 2]])
        mean[n + 1] = (up + down).mean() / 2
    return time, force, height, mean
