"""Limits of a friction layer: the yield limit when the pressure changes, plastic heat that would melt its node."""

import numpy as np
import pytest

from tcontact import friction_layer as layer
from tcontact.device import arrays

STEEL = layer.STAINLESS_304
SQRT3 = np.sqrt(3.0)


@pytest.mark.parametrize("reload", [False, True])
def test_pressure_that_rises_while_the_layer_flows_raises_its_stress_on_request_only(reload):
    """Y grows with the pressure. The stress follows within the step that it rises in, and to the limit, or never."""
    pressure = np.full((200, 1), 1.3e9)
    pressure[100:] = 2.6e9
    run = layer.solve(pressure=pressure, duration=2e-7, reload=reload)
    tau = run.shear_stress[:, 0]
    gain = STEEL.yields_at(300.0, 2.6e9, 0.0) / STEEL.yields_at(300.0, 1.3e9, 0.0)
    assert gain > 1.02
    if reload:
        assert tau[101] / tau[100] == pytest.approx(gain, rel=5e-3)
        assert np.diff(tau[101:]).max() <= 0.0
        assert SQRT3 * tau[-1] == pytest.approx(run.yield_stress.min(), rel=1e-9)
    else:
        assert np.diff(tau).max() <= 0.0
        assert SQRT3 * tau[-1] < 0.999 * run.yield_stress.min()  # it could bear more


def test_pressure_that_falls_lowers_the_stress_to_the_new_limit():
    pressure = np.full((200, 1), 2.6e9)
    pressure[100:] = 1.3e9
    for reload in (False, True):
        run = layer.solve(pressure=pressure, duration=2e-7, reload=reload)
        assert np.diff(run.shear_stress[:, 0]).max() <= 0.0
        assert SQRT3 * run.shear_stress[-1, 0] <= run.yield_stress.min() * (1.0 + 1e-12)


def test_plastic_heat_closes_at_most_half_of_the_distance_to_melting_in_a_step():
    """One long step at 1000 m/s leaves fifteen times the heat that would melt the surface: half of that is released."""
    cells = layer.Layer((STEEL,), 1, points=40, plastic_heat=1.0)
    numbers = np.zeros((2, cells.padded))
    numbers[:, 0] = 1000.0, 1.3e9
    rest, speed, pressure = (arrays.put(row) for row in (np.zeros(cells.padded), *numbers))

    def carried():
        return cells._profile(cells._carried, 0)[0]

    for _ in range(2):
        cells.advance(speed, pressure, 1e-6)
    waiting = carried()
    room = STEEL.volumetric_heat * (STEEL.melting_temperature - cells.temperature()[0])
    heat = cells.heat()[0]
    assert waiting[0] > 5.0 * room[0]
    cells.advance(rest, rest, 1e-6)  # open: heat spreads, nothing flows
    released = waiting - carried()
    np.testing.assert_allclose(released, np.minimum(waiting, 0.5 * room), rtol=1e-9, atol=1e-12 * room[0])
    assert cells.heat()[0] - heat == pytest.approx(released @ cells.columns[0].weight, rel=1e-9)
    assert cells.temperature().max() < STEEL.melting_temperature
