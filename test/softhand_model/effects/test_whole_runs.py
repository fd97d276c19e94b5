"""What effects that remember make of whole runs, against steps and against an integrator."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from softhand_model.effects import effect_classes
from softhand_model.effects.whole_runs import LONG, RunTimes, in_whole_runs, lagged_in_runs

CLASSES = effect_classes()
SAMPLES, LANES = 60, 4
METHODS = {
    "tube_lag": "chamber_pressure",
    "growing_chamber_lag": "chamber_pressure",
    "angle_sensor_lag": "reading",
    "sensor_drift": "reading",
    "tip_friction": "tip_force",
}
IN_LANES = {
    "tube_lag": {"time_constant": np.geomspace(1e-4, 100.0, LANES)},
    "growing_chamber_lag": {
        "time_constant": np.geomspace(0.02, 1.0, LANES),
        "doubling_pressure": np.geomspace(1.0, 20.0, LANES),
    },
    "angle_sensor_lag": {"time_constant": np.geomspace(0.02, 1.0, LANES)},
    "sensor_drift": {
        "rate": np.linspace(-0.1, 0.1, LANES),
        "settling_time": np.geomspace(0.1, 50.0, LANES),
        "per_run": np.zeros(LANES),
    },
    "tip_friction": {"coefficient": np.linspace(0.0, 0.5, LANES)},
}


def course():
    """Three runs with uneven steps, of which the second starts steady, and one of their inputs."""
    random = np.random.default_rng(3)
    dt = random.uniform(0.005, 0.1, (3, SAMPLES))
    dt[:, 0] = 0.0
    dt[2, 1:] = 0.02
    values = np.cumsum(random.normal(0.0, 1.0, (3, SAMPLES)), axis=1) + 5.0
    times = RunTimes(np.arange(4) * SAMPLES, dt.ravel(), steady=np.array([False, True, False]))
    return times, values.reshape(1, -1, 1)


def stepped(effect, method, times, values):
    act, runs = getattr(effect, method), []
    for run, (first, end) in enumerate(zip(times.starts[:-1], times.starts[1:], strict=True)):
        memory = {}
        if times.steady[run]:
            act(values[:, first : first + 1], memory, LONG)
        else:
            act(0.0 * values[:, first : first + 1], memory, 0.0)
        rows = range(first, end)
        runs += [act(values[:, row : row + 1], memory, times.dt[row]) for row in rows]
    return np.concatenate(runs, axis=1)


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("lanes_of_input", [1, LANES])
def test_whole_runs_are_what_steps_make_of_them(name, lanes_of_input):
    times, values = course()
    values = values * np.linspace(1.0, 2.0, lanes_of_input)[:, None, None]
    effect = CLASSES[name].in_lanes(IN_LANES[name])
    found = in_whole_runs(effect, METHODS[name])(values.copy(), times)
    expected = stepped(effect, METHODS[name], times, values)
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-11)
    assert np.ptp(expected, axis=0).max() > 1e-3  # lanes differ


def test_the_lag_of_a_growing_chamber_is_that_of_its_equation():
    time = np.linspace(0.0, 3.0, 301)
    given = 30.0 * np.minimum(time, 1.0)  # a ramp, then rest
    times = RunTimes(np.array([0, 301]), np.diff(time, prepend=0.0), np.array([False]))
    found = lagged_in_runs(given.reshape(1, -1, 1), times, 0.2, 20.0)[0, :, 0]
    exact = solve_ivp(
        lambda t, y: (np.interp(t, time, given) - y) / (0.2 * (1.0 + y / 20.0)),
        (0.0, 3.0),
        [0.0],
        t_eval=time,
        rtol=1e-9,
        atol=1e-9,
        max_step=0.01,
    )
    assert found == pytest.approx(exact.y[0], abs=2e-3)


def test_a_lag_is_that_of_its_equation():
    times, values = course()
    found = lagged_in_runs(values, times, 0.3)[0, SAMPLES : 2 * SAMPLES, 0]
    time, given = np.cumsum(times.dt[SAMPLES : 2 * SAMPLES]), values[0, SAMPLES : 2 * SAMPLES, 0]
    exact = solve_ivp(
        lambda t, y: (np.interp(t, time, given) - y) / 0.3,
        (0.0, time[-1]),
        given[:1],  # steady at its first value
        t_eval=time,
        rtol=1e-9,
        atol=1e-9,
        max_step=0.002,
    )
    assert found == pytest.approx(exact.y[0], abs=1e-5)


def test_a_method_of_ones_own_is_stepped():
    class Own(CLASSES["tube_lag"]):
        def chamber_pressure(self, pressure, memory, dt):
            return pressure + 1.0

    class Renamed(CLASSES["tube_lag"]):
        pass

    assert in_whole_runs(Own(time_constant=1.0), "chamber_pressure") is None
    assert in_whole_runs(Renamed(time_constant=1.0), "chamber_pressure") is not None
    assert in_whole_runs(CLASSES["dead_zone"](threshold=1.0), "chamber_pressure") is None
