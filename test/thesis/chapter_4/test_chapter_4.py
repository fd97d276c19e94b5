"""Each experiment in a small version; figures against closed forms where there are some."""

import math

import numpy as np
import pytest

from softhand_model.gas import GAS_CONSTANT, orifice_flow
from thesis.chapter_4 import drift_pulses, finger_posture, six_channels, supply_rejection
from thesis.chapter_4.boxes import PERIOD, SUPPLIES, box_of, inlet_flows
from thesis.chapter_4.finger_posture import Fingers
from thesis.chapter_4.flow_function import psi_approx
from thesis.chapter_4.rig_run import final_drift, under
from thesis.frame import Job, experiments

GAS = GAS_CONSTANT * 293.15  # [J/kg]


@pytest.mark.parametrize("name", experiments("chapter_4"))
def test_every_experiment_gives_finite_figures_a_verdict_and_a_picture(
    name, check_small_run, small
):
    check_small_run(name)
    assert "thesis" in small(name)[1].verdict


def test_the_flow_functions_differ_by_what_the_errata_list(small):
    report = small("flow_function")[1]
    assert report["RMS error, scaled to fit"] == pytest.approx(0.9, abs=0.05)
    assert report["Psi at sonic flow, factor 7.0 as printed"] == pytest.approx(0.685, abs=5e-4)
    np.testing.assert_array_equal(psi_approx(np.array([1.0, 1.3])), 0.0)


def test_the_noise_of_the_ground_truth_is_that_of_two_averaged_readings(small):
    sensor = box_of(1).channel_sensor
    step = sensor.range / 2**sensor.bits
    reading = math.sqrt(sensor.noise**2 + step**2 / 12)
    expected = math.sqrt(2 / 100) * reading * 0.5e-3 / GAS
    noise = 1e-6 * small("pulse_error")[1]["noise of the ground truth"]
    assert noise == pytest.approx(expected, rel=0.25)


def test_the_full_model_beats_a_baseline_that_is_fitted_to_the_same_pulses(small):
    assert small("pulse_error")[1]["deflation: baseline / full model"] > 3


def test_the_supply_varies_by_the_share_that_is_asked_for():
    given = supply_rejection.Parameters()
    supply = supply_rejection.varied(given)
    times = np.arange(0.0, given.end, 0.01)
    course = np.array([supply(time) for time in times])
    assert np.ptp(course) / given.supply == pytest.approx(0.25, rel=1e-3)
    assert (course[times < given.fill] == given.supply).all()
    slope = np.abs(np.diff(course)).max() / 0.01  # down and up again four times, evenly
    assert slope == pytest.approx(2 * 4 * np.ptp(course) / given.duration, rel=1e-2)


def test_external_chokes_add_what_the_gas_law_has_for_their_dead_volume(small):
    report = small("dead_volume")[1]
    measured = report["added air of an inflation, measured"]
    assert measured == pytest.approx(report["added air of an inflation, gas law"], rel=0.1)


def test_a_choke_lets_pass_what_an_orifice_at_sonic_flow_does(small):
    series = small("choke_size")[0]
    box = box_of(1)
    supply = box.supply.pressure + box.ambient_pressure
    flows = inlet_flows(box, 1, 0)
    areas = [c * math.pi / 4 * 0.2e-3**2 for c in box.choke.discharge_coefficient]
    low, high = (float(orifice_flow(supply, 126e3, area)) for area in areas)
    assert 0.9 * low < flows[0] < high
    assert series["flow"][1] / series["flow"][0] == pytest.approx(4, rel=0.1)


def test_fast_valves_take_smaller_steps_and_the_dead_volume_limits_them(small):
    report = small("valve_speed")[1]
    fast = report["smallest pulse, slow / fast"]
    assert 2 < fast < report["smallest pulse, slow / fast without dead volume"]


def test_scheduled_events_act_at_the_nearest_sample(small):
    errors = small("scheduled_events")[0]["simulated"] / PERIOD
    assert np.abs(errors).max() <= 0.5 + 1e-6
    assert errors.std() == pytest.approx(1 / math.sqrt(12), rel=0.3)


def test_a_shared_calibration_is_worse_and_the_driver_says_so(tmp_path):
    # on the ideal box: few pulses in bottles that warm and cool make a poor calibration anyway
    given = six_channels.Parameters(seed=1, **six_channels.SMALL)
    job = Job(tmp_path, lambda what, share: None)
    report = six_channels.report(six_channels.on_box(box_of(1, "ideal"), given, job), given)
    worst = "final drift, shared calibration, worst channel"
    assert report[worst] > 1.5 * report["final drift, worst channel, by the sensors"]
    assert report["the driver warns of a shared calibration"] == 1.0


def test_the_posture_differs_by_what_the_drift_of_the_air_does_to_the_angle(small):
    series, report = small("finger_posture")
    fingers = Fingers(4)
    gauge = np.full(4, 8e3)
    slope = (fingers.tip_angles(gauge * 1.01) - fingers.tip_angles(gauge)) / (
        fingers.mass(gauge * 1.01) - fingers.mass(gauge)
    )
    moved = series["truth"][-1] - series["truth"][np.searchsorted(series["time"], 4.0)]
    off = [report[f"{name}: deviation of the tip angle"] for name in finger_posture.NAMES]
    np.testing.assert_allclose(off, np.degrees(slope * moved), atol=1.0, rtol=0.4)


def test_drift_counts_from_the_pulses_of_each_channel():
    time = np.arange(5.0)
    run = {
        "time": time,
        "pulses": np.array([[0, 0], [1, 0], [1, 2], [2, 4], [4, 4]], dtype=float),
        "truth": np.array([[0, 0], [1, 0], [1, 2], [2, 4], [4, 4]], dtype=float),
        "estimate": np.zeros((5, 2)),
        "measured": np.zeros((5, 2)),
    }
    given = drift_pulses.Parameters(pulses=4)
    np.testing.assert_allclose(
        drift_pulses.over_pulses(run, given), np.arange(5.0)[:, None] * [1, 1]
    )
    np.testing.assert_allclose(final_drift(run), [4, 4])
    assert set(under("own", run)) == {f"own_{name}" for name in run}


def test_boxes_of_other_seeds_have_calibrations_of_their_own(once):
    first, other = (once(box_of(k), 1, 24, k, lambda *_: None, SUPPLIES)[0] for k in (0, 1))
    assert abs(other.inflate.injector / first.inflate.injector - 1) > 1e-3
