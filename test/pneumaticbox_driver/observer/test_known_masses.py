"""Masses that are known, from made-up readings: at the start, at ambient, in free posture."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up_box import GAS, KPA, MG, REST, Swelling

from pneumaticbox_driver.observer.coefficients import ChannelCalibration, PulseCoefficients
from pneumaticbox_driver.observer.drift import DriftBound, PostureMass, combine
from pneumaticbox_driver.observer.zeroing import Zeroing
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import AMBIENT_PRESSURE

SLOPE = 0.4e-9  # growth of the volume with the pressure [m3/Pa]
SETTINGS = BoxSettings(("a",), (REST,), (150e3,), ("mass",))
DT = 4e-3  # 25 samples of a window
CLOSED, OPEN, FILLING = 0, -1, 1


def posture(slope=SLOPE):
    return PostureMass(SETTINGS, Swelling([REST], slope))


def free_mass(gauge, slope=SLOPE):
    """Air above the fill at rest in free posture [kg]."""
    volume = REST + slope * gauge
    return ((gauge + AMBIENT_PRESSURE) * volume - AMBIENT_PRESSURE * REST) / GAS


# ---------------------------------------------------------------- what pressure and volume tell
def test_pressure_and_volume_tell_the_mass_with_the_errors_of_sensor_and_model():
    gauge = 40 * KPA
    mass, variance = posture().at(np.array([AMBIENT_PRESSURE + gauge]))
    assert mass[0] == pytest.approx(free_mass(gauge))
    by_pressure = (free_mass(gauge + 0.5) - free_mass(gauge - 0.5)) / 1.0
    sensor = by_pressure * np.hypot(15.0, 0.003 * gauge)
    model = 0.01 * SLOPE * gauge * (gauge + AMBIENT_PRESSURE) / GAS
    assert variance[0] == pytest.approx(sensor**2 + model**2, rel=1e-5, abs=0.0)
    _, rigid = posture(0.0).at(np.array([AMBIENT_PRESSURE + gauge]))
    expected = (REST / GAS * np.hypot(15.0, 0.003 * gauge)) ** 2
    assert rigid[0] == pytest.approx(expected, rel=1e-9, abs=0.0)


def test_what_stays_in_an_actuator_that_is_held_bent_at_ambient_pressure():
    held, kept = posture().bent_at(np.array([40 * KPA]))
    assert held[0] == pytest.approx(free_mass(40 * KPA))
    assert kept[0] == pytest.approx(AMBIENT_PRESSURE * SLOPE * 40 * KPA / GAS)


@pytest.mark.parametrize(
    ("variance", "measured", "expected", "used", "far"),
    [
        (4.0, 5.0, 4.0, True, False),
        (1.1, 1.0, 1.1 / 2.1, True, False),
        (0.9, 1.0, 0.0, False, False),  # worse than the estimate
        (1.0, 1.0, 0.0, False, False),
        (3.0, 9.9, 7.425, True, False),
        (3.0, 10.1, 0.0, False, True),  # beyond five standard deviations of both
        (3.0, -10.1, 0.0, False, True),
        (0.5, 7.0, 0.0, False, True),
    ],
)
def test_estimates_and_measurements_are_weighed(variance, measured, expected, used, far):
    one = np.ones(1)
    mass, left, *flags = combine(0 * one, variance * one, measured * one, one)
    assert mass[0] == pytest.approx(expected)
    assert [bool(flag[0]) for flag in flags] == [used, far]
    assert left[0] == pytest.approx(variance / (1.0 + variance) if used else variance)


def test_the_bound_knows_inflating_and_deflating_pulses_apart():
    def fit(bias, jitter):
        covariance = np.diag([bias**2, 0, 0, 0, 0])
        return PulseCoefficients(0, 0, 0, 0, jitter=jitter, covariance=covariance)

    bound = DriftBound([ChannelCalibration(fit(3.0, 0.1), fit(4.0, 0.2))] * 2)
    every, one = np.ones(2, bool), np.ones((5, 2))
    bound.add(every, np.array([True, False]), one, np.array([10.0, 10.0]))
    assert bound.bound == pytest.approx([2 * np.hypot(3.0, 1.0), 2 * np.hypot(4.0, 2.0)])
    bound.add(np.array([True, False]), np.array([False, False]), one, np.array([10.0, 10.0]))
    assert bound.variance() == pytest.approx([9 + 1 + 16 + 4, 16 + 4])
    assert bound.pulses.tolist() == [2, 1]
    bound.restart(0)
    assert bound.variance() == pytest.approx([0, 20]) and bound.pulses.tolist() == [0, 1]
    bound.set_calibrations([ChannelCalibration(fit(1.0, 0.0), fit(1.0, 0.0))] * 2)
    bound.add(every, every, one, np.zeros(2))
    assert bound.variance() == pytest.approx([1, 21])


# ---------------------------------------------------------------- when masses are set
class Known:
    """The zeroing of one channel, on readings and an estimate that are given by hand."""

    def __init__(self, offset=0.0, slope=SLOPE):
        self.mass, self.bound, self.pulses = np.zeros(1), np.zeros(1), np.zeros(1, dtype=int)
        self.notes, self.offset, self.valve, self.time = [], offset, CLOSED, 0.0
        observer = SimpleNamespace(
            mass=self.mass,
            flow=np.zeros(1),
            drift_bound=self.bound,
            pulses=self.pulses,
            set_mass=self.set_mass,
            lift=self.lift,
        )
        self.zeroing = Zeroing(SETTINGS, observer, Swelling([REST], slope), self.notes)

    def set_mass(self, channel, mass):
        self.mass[channel], self.bound[channel], self.pulses[channel] = mass, 0.0, 0

    def lift(self, masses):
        self.mass += masses

    def see(self, duration, gauge, valve=CLOSED):
        """Let the true gauge pressure [Pa], or what a function of the time says, stand."""
        for _ in range(round(duration / DT)):
            self.time += DT
            true = gauge(self.time) if callable(gauge) else gauge
            reading = np.array([true + AMBIENT_PRESSURE + self.offset])
            self.zeroing.look(DT, reading - self.zeroing.offsets, np.array([self.valve]))
            if valve != self.valve:
                self.valve = valve
                self.zeroing.switched(np.array([True]), np.array([valve]))
        return self

    @property
    def empty(self):
        return bool(self.zeroing.empty[0])

    def filled(self, gauge=40 * KPA, mass=None):
        """Started, then with air in it that a pulse has brought."""
        self.see(0.4, 0.0).see(0.1, 1 * KPA, FILLING).see(0.3, gauge)
        self.mass[:] = free_mass(gauge) if mass is None else mass
        self.pulses[:] = 1
        return self


def test_at_the_start_two_quiet_windows_tell_offset_and_mass():
    known = Known(offset=800.0)
    known.mass[:] = 5 * MG
    known.see(0.19, 0.0)
    assert not known.zeroing.ready
    known.see(0.02, 0.0)
    assert known.zeroing.ready and known.empty
    assert known.zeroing.offsets[0] == pytest.approx(800.0)
    assert known.mass[0] == 0.0 and known.notes == []


@pytest.mark.parametrize(("reading", "taken"), [(4.9, True), (-4.9, True), (5.1, False)])
def test_an_offset_is_no_more_than_the_zero_band(reading, taken):
    known = Known(offset=reading * KPA).see(0.3, 0.0)
    assert known.empty == taken
    assert known.zeroing.offsets[0] == pytest.approx(reading * KPA if taken else 0.0)


def test_a_start_under_pressure_takes_the_mass_of_the_free_posture():
    known = Known().see(0.3, 30 * KPA)
    assert known.mass[0] == pytest.approx(free_mass(30 * KPA))
    assert not known.empty and known.zeroing.drift_bound[0] > 0.1 * MG
    assert known.notes == ["tared under pressure by the free volume: ['a']"]


def test_pressures_that_do_not_stand_still_are_waited_for_a_second():
    known = Known().see(0.9, lambda time: 1e3 * time)
    assert not known.zeroing.ready
    assert known.see(0.25, lambda time: 1e3 * time).zeroing.ready


@pytest.mark.parametrize(("slide", "still"), [(400.0, True), (500.0, False)])
def test_a_pressure_stands_still_within_45_pascal_from_window_to_window(slide, still):
    known = Known().see(0.6, lambda time: slide * time)
    assert known.zeroing.ready == still


def test_an_outlet_at_ambient_pressure_makes_the_mass_known():
    known = Known().filled()
    known.see(0.1, 20 * KPA, OPEN)
    assert not known.empty
    known.mass[:] = 0.4 * MG
    known.offset = 250.0  # has drifted since the start
    known.see(0.25, 0.0, OPEN)
    assert known.empty and known.mass[0] == 0.0
    assert known.zeroing.offsets[0] == pytest.approx(250.0)
    assert known.notes == []


def test_an_offset_that_was_found_is_off_the_averaged_pressure_at_once():
    known = Known().filled().see(0.1, 20 * KPA, OPEN)
    known.mass[:] = 0.4 * MG
    known.offset = 250.0
    while not known.empty:
        known.see(DT, 0.0, OPEN)
    steady = known.zeroing.steady(np.full(1, np.nan))
    assert steady[0] == pytest.approx(AMBIENT_PRESSURE, abs=1.0)


@pytest.mark.parametrize(
    "state", [{"gauge": 6 * KPA, "valve": OPEN}, {"gauge": 0.0, "valve": CLOSED}]
)
def test_without_ambient_pressure_or_an_open_outlet_it_is_not(state):
    known = Known().filled().see(0.1, 20 * KPA, OPEN)
    known.mass[:] = 0.4 * MG
    known.see(0.004, state["gauge"], state["valve"]).see(0.5, state["gauge"], state["valve"])
    assert known.mass[0] == 0.4 * MG and not known.empty


@pytest.mark.parametrize(
    ("gauge", "empty"), [(0.9, True), (-0.9, True), (1.1, False), (-1.1, False)]
)
def test_pressure_in_an_emptied_channel_says_that_it_was_not_empty(gauge, empty):
    known = Known().see(0.4, 0.0)
    assert known.see(0.02, gauge * KPA).empty == empty


def test_air_that_is_let_in_ends_the_emptiness():
    known = Known().see(0.4, 0.0)
    assert known.empty
    known.see(0.01, 0.0, FILLING)
    assert not known.empty


def vented(mass, peak=40 * KPA, bound=0.0, **changed):
    """A channel that was at a peak pressure, comes to ambient pressure and is said to hold this."""
    known = Known(**changed).filled(peak).see(0.1, 0.5 * peak, OPEN)
    known.mass[:], known.bound[:] = mass, bound
    return known.see(0.35, 0.0, OPEN)


SHARE = 0.1  # of what was held at the peak
HELD, KEPT = free_mass(40 * KPA), AMBIENT_PRESSURE * SLOPE * 40 * KPA / GAS


@pytest.mark.parametrize(
    ("mass", "bound", "stays"),
    [
        (SHARE * HELD + 0.6 * MG, 0.0, True),
        (SHARE * HELD + 0.4 * MG, 0.0, False),
        (SHARE * HELD + 4.0 * MG, 1.0 * MG, True),
        (SHARE * HELD + 3.2 * MG, 1.0 * MG, False),
        (1.19 * KEPT, 0.0, True),
        (1.21 * KEPT, 0.0, False),
    ],
)
def test_an_actuator_that_something_holds_bent_keeps_its_air(mass, bound, stays):
    known = vented(mass, bound=bound)
    assert known.empty
    assert known.mass[0] == (pytest.approx(mass) if stays else 0.0)


def test_what_is_kept_for_five_seconds_is_drift_after_all():
    known = vented(0.8 * KEPT).see(4.5, 0.0, OPEN)
    assert known.mass[0] == pytest.approx(0.8 * KEPT) and known.notes == []
    known.see(0.8, 0.0, OPEN)
    assert known.mass[0] == 0.0
    assert known.notes == [
        f"channel a kept {0.8e6 * KEPT:.1f} mg at ambient pressure for 5 s: zeroed, as if nothing "
        "held its actuator"
    ]


def test_the_five_seconds_begin_anew_when_air_was_let_in_meanwhile():
    known = vented(0.8 * KEPT).see(2.0, 0.0, OPEN)
    known.see(0.3, 20 * KPA, FILLING).see(0.2, 40 * KPA).see(0.1, 20 * KPA, OPEN)
    known.mass[:] = 0.8 * KEPT
    known.see(4.6, 0.0, OPEN)
    assert known.mass[0] == pytest.approx(0.8 * KEPT) and known.notes == []


@pytest.mark.parametrize(
    ("mass", "bound", "told"),
    [
        (-SHARE * HELD - 0.4 * MG, 0.0, None),
        (-SHARE * HELD - 0.6 * MG, 0.0, SHARE * HELD + 0.5 * MG),
        (-SHARE * HELD - 2.9 * MG, 1.0 * MG, None),
        (-SHARE * HELD - 3.2 * MG, 1.0 * MG, SHARE * HELD + 3.0 * MG),
        (1.3 * KEPT, 0.0, SHARE * HELD + 0.5 * MG),
    ],
)
def test_drift_that_neither_calibration_nor_posture_explains_is_told(mass, bound, told):
    notes = [
        f"calibration does not fit channel a: its air mass had drifted by {1e6 * mass:.1f} mg, of "
        f"{1e6 * told:.1f} mg at most"
        for told in [told]
        if told
    ]
    assert vented(mass, bound=bound).notes == notes


def test_after_a_fault_the_mass_is_zeroed_without_a_word_about_the_calibration():
    known = Known().filled()
    known.zeroing.doubt()
    assert not known.empty
    known.see(0.1, 20 * KPA, OPEN)
    known.mass[:] = 60 * MG
    known.see(0.35, 0.0, OPEN)
    assert known.mass[0] == 0.0 and known.notes == []


@pytest.mark.parametrize(("gauge", "known_now"), [(0.9, True), (-0.9, True), (1.1, False)])
def test_after_a_fault_a_closed_channel_at_ambient_pressure_is_known_too(gauge, known_now):
    known = Known().filled()
    known.zeroing.doubt()
    known.see(0.3, gauge * KPA)
    assert known.zeroing.doubted[0] == (not known_now)
    assert (known.mass[0] == 0.0) == known_now


def test_after_a_fault_a_closed_channel_under_pressure_stays_in_doubt():
    known = Known().filled()
    known.zeroing.doubt()
    assert known.see(0.5, 40 * KPA).zeroing.doubted[0]


# ---------------------------------------------------------------- behind an open outlet
def test_an_estimate_is_kept_above_what_the_rest_volume_holds():
    known = Known().filled().see(0.02, 1.8 * KPA, OPEN)
    known.mass[:] = -10 * MG
    known.see(0.02, 1.8 * KPA, OPEN)
    assert known.mass[0] == pytest.approx(REST * 1.5 * KPA / GAS)
    known.mass[:] = 8 * MG
    assert known.see(0.02, 1.8 * KPA, OPEN).mass[0] == 8 * MG


def test_so_it_is_at_any_pressure_that_came_by_itself():
    known = Known().see(0.4, 0.0).see(0.1, 20 * KPA).see(0.02, 20 * KPA, OPEN)
    known.mass[:] = -10 * MG
    known.see(0.02, 20 * KPA, OPEN)
    assert known.mass[0] == pytest.approx(REST * 19.7 * KPA / GAS)


def test_a_valve_that_closes_is_none_that_inflates():
    known = Known().see(0.4, 0.0).see(0.02, 0.0, OPEN).see(0.1, 20 * KPA).see(0.02, 20 * KPA, OPEN)
    known.mass[:] = -10 * MG
    known.see(0.02, 20 * KPA, OPEN)
    assert known.mass[0] == pytest.approx(REST * 19.7 * KPA / GAS)


@pytest.mark.parametrize(("gauge", "valve"), [(2.2 * KPA, OPEN), (1.8 * KPA, CLOSED)])
def test_it_is_left_alone_far_from_ambient_pressure_or_with_the_valve_closed(gauge, valve):
    known = Known().filled().see(0.02, gauge, valve)
    known.mass[:] = -10 * MG
    assert known.see(0.02, gauge, valve).mass[0] == -10 * MG


def test_what_was_lifted_is_drift_all_the_same():
    known = Known().filled().see(0.1, 20 * KPA, OPEN).see(0.004, 4 * KPA, OPEN)
    known.mass[:] = -10 * MG
    known.see(0.35, 0.0, OPEN)
    assert known.mass[0] == 0.0
    assert len(known.notes) == 1 and "had drifted by -10.0 mg" in known.notes[0]


@pytest.mark.parametrize(("more", "stays"), [(7.0, True), (4.0, False)])
def test_behind_a_sensor_that_was_off_the_rest_is_told_by_the_volume_before(more, stays):
    """What was held beyond the free posture at 20 kPa, at ambient pressure."""
    known = Known().filled()
    known.mass[:] = free_mass(20 * KPA) + more * MG
    known.offset = 2 * KPA
    known.see(0.1, 20 * KPA, OPEN)
    known.mass[:] = -30 * MG  # by a flow that the sensor feigned
    known.see(0.35, 0.0, OPEN)
    left = more * MG * AMBIENT_PRESSURE / (AMBIENT_PRESSURE + 20 * KPA)
    assert known.zeroing.offsets[0] == pytest.approx(2 * KPA)
    assert known.mass[0] == pytest.approx(left if stays else 0.0, rel=1e-3)


def test_the_volume_before_is_that_at_which_the_outlet_opened_if_it_was_nearly_empty_then():
    known = Known().filled().see(0.3, 0.5 * KPA)
    known.offset, known.mass[:] = 1 * KPA, free_mass(0.5 * KPA) + 5 * MG
    known.see(0.004, 0.5 * KPA, OPEN)
    known.mass[:] = -30 * MG
    known.see(0.35, 0.0, OPEN)
    left = 5 * MG * AMBIENT_PRESSURE / (AMBIENT_PRESSURE + 0.5 * KPA)
    assert known.mass[0] == pytest.approx(left, rel=1e-3)


def test_an_outlet_that_opens_anew_must_show_again_that_the_channel_is_empty():
    known = Known().see(0.4, 0.0)
    known.see(0.01, 0.0, OPEN)
    assert not known.empty
    known.see(0.25, 0.0, OPEN)
    assert known.empty
    assert known.see(0.01, 0.0, CLOSED).empty


def test_an_offset_found_behind_an_outlet_is_not_taken_for_another_by_a_tare():
    known = Known().filled().see(0.5, 0.0, OPEN).see(0.02, 0.0).see(0.3, 3 * KPA)
    assert known.zeroing.tare(np.array([3 * KPA + AMBIENT_PRESSURE])) == ["a"]
    assert known.mass[0] == pytest.approx(free_mass(3 * KPA), rel=1e-6)
    other = Known().see(0.3, 3 * KPA)
    assert other.empty and other.mass[0] == 0.0


def test_a_tare_by_the_user_sets_what_is_at_ambient_and_names_the_rest():
    known = Known().filled(30 * KPA, mass=3 * MG)
    known.zeroing.doubt()
    left = known.zeroing.tare(np.array([30 * KPA + AMBIENT_PRESSURE]))
    assert left == ["a"] and not known.zeroing.doubted[0]
    assert known.mass[0] == pytest.approx(free_mass(30 * KPA), rel=1e-6)


def test_a_tare_at_ambient_pressure_says_what_had_drifted():
    known = Known().filled().see(0.3, 0.0)
    known.mass[:], known.pulses[:] = 5 * MG, 1
    assert known.zeroing.tare(np.array([AMBIENT_PRESSURE])) == []
    assert known.mass[0] == 0.0
    assert len(known.notes) == 1 and "had drifted by 5.0 mg" in known.notes[0]


# ---------------------------------------------------------------- drift correction
def corrected(error, bound, pulses=1, gauge=40 * KPA):
    """A channel in free posture whose estimate is off by an error."""
    known = Known().filled(gauge)
    known.zeroing.drift_correction = True
    known.mass[:] = free_mass(gauge) + error
    known.bound[:], known.pulses[:] = bound, pulses
    return known.see(0.3, gauge)


def test_in_free_posture_a_doubtful_estimate_is_drawn_to_what_pressure_and_volume_tell():
    noise = np.sqrt(posture().at(np.array([40 * KPA + AMBIENT_PRESSURE]))[1][0])
    known = corrected(2 * noise, bound=8 * noise)
    left = known.mass[0] - free_mass(40 * KPA)
    assert left == pytest.approx(2 * noise / 17, rel=0.05)  # variances 16 to 1
    assert known.zeroing.drift_bound[0] == pytest.approx(2 * noise * np.sqrt(16 / 17), rel=0.05)
    sure = corrected(1 * noise, bound=1 * noise)
    assert sure.mass[0] == pytest.approx(free_mass(40 * KPA) + noise)


@pytest.mark.parametrize("before", [0, 1])
def test_an_estimate_far_from_the_posture_is_kept_for_five_pulses_and_then_told(before):
    known = corrected(8 * MG, bound=0.2 * MG, pulses=before)
    assert known.mass[0] == pytest.approx(free_mass(40 * KPA) + 8 * MG)
    known.pulses[:] = before + 4
    known.see(0.3, 40 * KPA)
    assert known.mass[0] == pytest.approx(free_mass(40 * KPA) + 8 * MG)
    known.pulses[:] = before + 5
    known.see(0.3, 40 * KPA)
    assert known.mass[0] == pytest.approx(free_mass(40 * KPA), rel=1e-3)
    assert len(known.notes) == 1 and "had drifted by 8.0 mg" in known.notes[0]


def test_an_estimate_that_came_near_again_is_not_counted_as_far():
    known = corrected(8 * MG, bound=0.2 * MG)
    known.mass[:] = free_mass(40 * KPA)
    known.see(0.3, 40 * KPA)
    known.mass[:], known.pulses[:] = free_mass(40 * KPA) + 8 * MG, 8
    known.see(0.3, 40 * KPA)
    assert known.mass[0] == pytest.approx(free_mass(40 * KPA) + 8 * MG) and known.notes == []


def test_with_the_correction_nothing_holds_an_actuator_bent():
    known = Known().filled().see(0.1, 20 * KPA, OPEN)
    known.zeroing.drift_correction = True
    known.mass[:] = 0.8 * KEPT
    assert known.see(0.35, 0.0, OPEN).mass[0] == 0.0
