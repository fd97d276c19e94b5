"""Effects of bellows, clocks and sensors: each equation against its own formula."""

import numpy as np
import pytest
from scipy.integrate import quad

from softhand_model.effects import Parameter, effect_classes
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import Strain

EFFECTS = effect_classes()
PRESSURE = np.array([-5e3, 0.0, 10e3, 20e3, 40e3])


def effect(name, **values):
    return EFFECTS[name](**values)


def test_chambers_that_touch_add_load_in_proportion_to_what_is_above_the_onset():
    found = effect("chamber_contact", gain=3.0, onset=20e3).act_on_load(PRESSURE, PRESSURE, None)
    assert found.tolist() == [-5e3, 0.0, 10e3, 20e3, 40e3 * (1 + 3.0)]


def test_ballooning_multiplies_the_load_about_its_onset_and_levels_off():
    swelling = effect("ballooning", gain=5.0, onset=20e3, sharpness=12.0)
    found = swelling.act_on_load(np.ones(5), PRESSURE, None)
    ratio = (np.maximum(PRESSURE, 0.0) / 20e3) ** 12.0
    assert found == pytest.approx(1 + 5 * ratio / (1 + ratio))
    assert found[[0, 1, 3]].tolist() == [1.0, 1.0, 3.5]
    assert swelling.act_on_load(1.0, np.array(200e3), None) == pytest.approx(6.0)


def test_rubber_ages_from_run_to_run_and_never_to_nothing():
    ageing = effect("ageing", per_run=-0.03)
    staged = StagedEffects([ageing, effect("temperature_modulus", coefficient=0.01)])
    assert float(staged.modulus_factor(np.array(293.15))) == 1.0  # in the first run, if not told
    ageing.around = {"run_order": np.array([1.0, 11.0, 101.0])}
    assert staged.modulus_factor(np.array(303.15)) == pytest.approx([1.1, 0.77, 0.011])


def test_creep_under_a_held_stretch_is_a_logarithm_of_time():
    """The stress falls by `rate` of itself for every decade beyond the onset, from 1 at once."""
    creep, memory, strain = effect("creep", rate=0.05, onset_time=0.2), {}, Strain(np.ones(1))
    one = np.ones(1)
    assert creep.stress(one, strain, None, {}, 0.0) == pytest.approx(one)
    creep.remember(one, strain, None, memory, 0.0)
    times = np.array([0.05, 0.3, 2.0, 20.0, 400.0])
    for time, step in zip(times, np.diff(times, prepend=0.0), strict=True):
        found = creep.stress(one, strain, None, memory, step)
        creep.remember(one, strain, None, memory, step)
        assert found[0] == pytest.approx(1 - 0.05 * np.log10(1 + time / 0.2), abs=8e-4)


def test_creep_under_a_ramp_is_the_sum_over_its_history_whatever_the_steps():
    rate, onset, speed = 0.08, 0.1, 0.4

    def at(time):
        lost, _ = quad(lambda since: np.log10(1 + since / onset), 0.0, time)
        return speed * (time - rate * lost)

    for steps in (1, 7, 60):
        creep, memory, strain = effect("creep", rate=rate, onset_time=onset), {}, Strain(np.ones(1))
        creep.remember(np.zeros(1), strain, None, memory, 0.0)
        for time in np.linspace(0.0, 5.0, steps + 1)[1:]:
            stress = np.array([speed * time])
            found = creep.stress(stress, strain, None, memory, 5.0 / steps)
            creep.remember(stress, strain, None, memory, 5.0 / steps)
        assert found[0] == pytest.approx(at(5.0), rel=1e-3)


def test_delay_is_that_of_two_clocks():
    staged = StagedEffects([effect("clock_offset", offset=0.2, drift=-0.01)])
    assert staged.delays
    assert staged.delay(np.array([0.0, 10.0])) == pytest.approx([0.2, 0.1])
    assert not StagedEffects([effect("tube_lag", time_constant=0.2)]).delays


@pytest.mark.parametrize("factor", [0.6, 1.0, 1.7])
def test_a_camera_aslant_sees_a_direction_projected_and_right_angles_as_they_are(factor):
    camera = effect("camera_perspective", foreshortening=factor)
    angle = np.array([-0.7, 0.0, 0.4, 1.3, 1.8, 3.0, 4.0])
    found = camera.reading(angle, {}, 0.0)
    seen = np.stack([np.cos(angle), factor * np.sin(angle)])
    assert np.cos(found) == pytest.approx(seen[0] / np.hypot(*seen))
    assert np.sin(found) == pytest.approx(seen[1] / np.hypot(*seen))
    assert np.abs(found - angle).max() < 0.5
    right = np.pi / 2 * np.arange(4)
    assert camera.reading(right, {}, 0.0) == pytest.approx(right)


def drifting(steps, value=0.0, before=0.0, **values):
    """Readings of a sensor that drifts, after each of the steps [s], with so many runs before."""
    staged = StagedEffects([effect("sensor_drift", **values)])
    staged.output[0].around = {"session": np.asarray(before)}
    return [np.asarray(staged.reading("tip_force", np.asarray(value), dt)) for dt in steps]


def test_a_drift_goes_on_or_comes_to_rest():
    steps = [0.0, 1.0, 2.0, 7.0]
    going_on = drifting(steps, value=1.0, rate=0.01, settling_time=1e6, per_run=0.0)
    assert np.array(going_on) == pytest.approx([1.0, 1.01, 1.03, 1.1], rel=1e-4)
    ending = drifting(steps, rate=0.01, settling_time=2.0, per_run=0.0)
    assert np.array(ending) == pytest.approx(0.02 * (1 - np.exp(-0.5 * np.cumsum(steps))))


def test_a_drift_goes_on_from_run_to_run_and_a_long_rest_before_a_run_is_none():
    late = drifting(
        [1e12, 2.0],
        rate=0.01,
        settling_time=1e6,
        per_run=-0.1,
        before=[0.0, 3.0],
    )
    assert late[0] == pytest.approx([0.0, -0.3])
    assert late[1] == pytest.approx([0.02, -0.28], rel=1e-4)


def test_a_sensor_that_saturates_ends_at_its_limit():
    staged = StagedEffects([effect("saturation", limit=1.2)])
    assert staged.reading("stress", np.array([0.5, 1.2, 3.0]), 0.0).tolist() == [0.5, 1.2, 1.2]
    assert staged.reading("torque_x", np.array([3.0]), 0.0).tolist() == [3.0]


def test_sensors_act_in_the_order_in_which_a_reading_comes_about():
    names = ["saturation", "sensor_drift", "angle_offset", "angle_sensor_lag", "camera_perspective"]
    staged = StagedEffects([EFFECTS[name].in_lanes({}) for name in names])
    assert [one.name for one in staged.all] == names[::-1]


def test_a_range_relative_to_what_is_measured_is_kept_beside_the_absolute_one():
    onset = EFFECTS["ballooning"].parameters[1]
    assert onset.relative == ("pressure", 0.45, 0.95) and onset.typical == (5e3, 100e3)
    assert Parameter("p", "", 0.0, 1.0).relative is None
