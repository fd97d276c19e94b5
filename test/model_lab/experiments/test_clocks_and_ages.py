"""What a set's clocks and the order of its runs do to predictions, on both bases."""

from dataclasses import replace

import numpy as np
import pytest
from lab_sets import bending, measured, run

from model_lab.experiments.forward import Forward, inapplicable, not_searched
from model_lab.fitting.problem import in_the_range_of
from model_lab.measurements.measurement_set import Specimen
from softhand_model.effects import effect_classes

EFFECTS = effect_classes()
TIME = np.linspace(0.0, 8.0, 81)
PRESSURE = 20e3 * (1.0 - np.cos(0.9 * TIME))


def angles(data, *effects, base="pneuflex"):
    forward = Forward(data, base, fixed=effects, free_calibration=False)
    return forward.predict(forward.start()[None])[0].reshape(len(data.runs), -1)


def late(offset, drift=0.0):
    return EFFECTS["clock_offset"](offset=offset, drift=drift)


@pytest.mark.parametrize("offset", [0.25, -0.4])
def test_an_output_on_a_late_or_early_clock_is_that_of_another_time(offset):
    data = bending(PRESSURE, PRESSURE[::-1].copy(), time=TIME)
    before = 20e3 * (1.0 - np.cos(0.9 * np.clip(TIME - offset, 0.0, 8.0)))
    expected = angles(bending(before, time=TIME))[0]
    found = angles(data, late(offset))
    assert found[0] == pytest.approx(expected, abs=1e-3)
    assert np.abs(found[0] - angles(data)[0]).max() > 0.05


def test_a_clock_that_runs_at_another_speed_comes_ever_later():
    data = bending(PRESSURE, time=TIME)
    slower = 20e3 * (1.0 - np.cos(0.9 * 0.97 * TIME))
    expected = angles(bending(slower, time=TIME))[0]
    assert angles(data, late(0.0, drift=0.03))[0] == pytest.approx(expected, abs=1e-3)


def test_runs_do_not_reach_into_one_another_whatever_their_length_and_start():
    short = run("a", 5.0 + TIME[:31], pressure=PRESSURE[:31])
    steady = run("b", 100.0 + TIME, pressure=PRESSURE + 5e3, steady=True)
    data = measured("free_bending", [short, steady])
    found = Forward(data, fixed=[late(0.3)], free_calibration=False).predict(np.zeros((1, 0)))[0]
    alone = [
        Forward(measured("free_bending", [one]), fixed=[late(0.3)], free_calibration=False)
        for one in (short, steady)
    ]
    parts = [one.predict(np.zeros((1, 0)))[0] for one in alone]
    assert found == pytest.approx(np.concatenate(parts))
    assert parts[0][:3] == pytest.approx(0.0, abs=1e-9)
    level = angles(bending(np.full(2, 5e3), time=TIME[:2]))[0, 0]
    assert parts[1][:3] == pytest.approx(level)


def test_rubber_is_as_old_as_its_specimen_has_runs():
    runs = [run(f"r{n}", TIME, pressure=PRESSURE, of="ab"[n % 2]) for n in range(4)]
    runs.append(replace(runs[0], name="again", virgin=True))
    data = measured("free_bending", runs, *(Specimen(name) for name in "ab"))
    ageing = EFFECTS["ageing"](per_run=-0.1)
    found = Forward(data, "linear", fixed=[ageing], free_calibration=False)
    values = found.predict(np.zeros((1, 0)))[0].reshape(5, -1)
    plain = Forward(data, "linear", free_calibration=False).predict(np.zeros((1, 0)))[0]
    assert values[:, -1] == pytest.approx(
        plain.reshape(5, -1)[:, -1] / np.array([1.0, 1.0, 0.9, 0.9, 1.0])
    )


@pytest.mark.parametrize("base", ["pneuflex", "linear"])
def test_a_zero_drifts_within_runs_and_from_run_to_run_of_the_session(base):
    data = bending(PRESSURE, PRESSURE, PRESSURE, time=TIME)
    drift = EFFECTS["sensor_drift"](rate=0.01, settling_time=1e6, per_run=-0.05)
    moved = angles(data, drift, base=base) - angles(data, base=base)
    assert moved == pytest.approx(0.01 * TIME - 0.05 * np.arange(3.0)[:, None], abs=1e-5)


def test_chambers_act_on_the_load_of_the_linear_base():
    data = bending(PRESSURE, time=TIME)
    runs = [
        replace(one, columns={**one.columns, "tip_angle": PRESSURE * 1e-5}) for one in data.runs
    ]
    data = replace(data, runs=tuple(runs))
    touching = EFFECTS["chamber_contact"](gain=2.0, onset=25e3)
    expected = 1e-5 * PRESSURE * (1 + 2 * np.maximum(PRESSURE / 25e3 - 1, 0))
    assert angles(data, touching, base="linear")[0] == pytest.approx(expected)


def test_usual_ranges_and_units_are_those_of_the_set():
    data = bending(3.0 * PRESSURE, time=TIME)
    runs = [replace(one, columns={**one.columns, "tip_angle": 0.02 * TIME}) for one in data.runs]
    placed = in_the_range_of(replace(data, runs=tuple(runs)), EFFECTS)
    onset = placed["chamber_contact"].parameters[1]
    assert onset.typical == pytest.approx((0.2 * 3 * PRESSURE.max(), 0.85 * 3 * PRESSURE.max()))
    limit = placed["saturation"].parameters[0]
    assert (limit.unit, limit.typical) == ("rad", pytest.approx((0.6 * 0.16, 0.16)))
    assert placed["sensor_drift"].parameters[0].unit == "rad/s"
    assert placed["dead_zone"] is EFFECTS["dead_zone"]
    assert placed["saturation"](limit=0.1).reading(0.3, {}, 0.0) == 0.1


@pytest.mark.parametrize("name", ["ageing", "sensor_drift"])
def test_what_goes_by_the_session_is_not_seen_in_one_run(name):
    one, two = (bending(*[PRESSURE] * runs, time=TIME) for runs in (1, 2))
    assert inapplicable(EFFECTS[name], one, "pneuflex").startswith("in a single run")
    assert inapplicable(EFFECTS[name], two, "pneuflex") is None


def test_a_trend_from_run_to_run_is_not_sought_in_two():
    """They may differ by as much as repeats do; on request it is fitted to them."""
    two, three = (bending(*[PRESSURE] * runs, time=TIME) for runs in (2, 3))
    assert "no trend" in not_searched(EFFECTS["ageing"], two, "pneuflex")
    assert not_searched(EFFECTS["ageing"], three, "pneuflex") is None
    assert inapplicable(EFFECTS["ageing"], two, "pneuflex") is None
