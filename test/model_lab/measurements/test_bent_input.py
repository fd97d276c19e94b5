"""What the input did between samples is the same to all that takes time."""

import numpy as np
import pytest
from lab_sets import bending

from model_lab.experiments.forward import Forward
from model_lab.measurements.bent_input import bends, between, with_bends
from softhand_model.effects import effect_classes

COARSE, FINER = np.linspace(0.0, 12.0, 81), 20  # [s]; fine samples from one to the next
FINE = np.linspace(0.0, 12.0, 80 * FINER + 1)
LATE = {
    "tube_lag": {"time_constant": 0.06},
    "angle_sensor_lag": {"time_constant": 0.06},
    "viscoelasticity": {"relative_modulus": 0.4, "relaxation_time": 0.1},
    "clock_offset": {"offset": 0.06, "drift": 0.0},
}
RAMPS = np.interp(COARSE, [0.0, 3.0, 6.0, 9.0], [0.0, 1.0, 1.0, 0.2])


def course(time):
    """Smooth ups and downs [Pa] from rest."""
    return 20e3 * (1.0 - np.cos(2.0 * np.pi * 0.4 * time))


def angles(time, **effects):
    made = [effect_classes()[name](**values) for name, values in effects.items()]
    forward = Forward(bending(course(time), time=time), fixed=made, free_calibration=False)
    return forward.predict(np.zeros((1, 0)))[0]


@pytest.mark.parametrize("name", LATE)
def test_few_samples_of_a_smooth_course_say_as_much_as_many(name):
    effect = {name: LATE[name]}
    true, found = angles(FINE, **effect)[::FINER], angles(COARSE, **effect)
    shown = np.sqrt(np.mean((true - angles(COARSE)) ** 2))
    assert np.sqrt(np.mean((found - true) ** 2)) < 0.02 * shown


def test_no_rival_has_another_course_between_samples():
    """A short lag is a short delay, whatever the distance of the samples."""
    delayed = angles(COARSE, clock_offset={"offset": 0.01, "drift": 0.0})
    lagging = angles(COARSE, tube_lag={"time_constant": 0.01})
    none = angles(COARSE)
    assert np.abs(delayed - lagging).max() < 0.05 * np.abs(delayed - none).max()


def test_ramps_with_corners_at_samples_stay_straight():
    data = bending(RAMPS, time=COARSE)
    finer, own = with_bends(data)
    assert finer.runs[0] is data.runs[0]
    assert np.array_equal(own, np.arange(81))


def test_a_parabola_is_met_between_uneven_samples():
    time = np.sort(np.random.default_rng(0).uniform(0.0, 4.0, 40))
    wanted = np.linspace(time[1], time[-2], 500)
    found = between(time, time**2, bends(time, time**2), wanted)
    assert found == pytest.approx(wanted**2)


def test_more_samples_stand_where_the_input_bends_and_all_own_ones_are_kept():
    data = bending(course(COARSE), RAMPS, time=COARSE)
    finer, own = with_bends(data)
    assert finer.runs[0].samples > 2 * 81 and finer.runs[1].samples == 81
    for name in ("time", "pressure"):
        kept = np.concatenate([run.columns[name] for run in finer.runs])[own]
        given = np.concatenate([run.columns[name] for run in data.runs])
        assert kept == pytest.approx(given)
