"""Pulses against what they do, on pressures given by hand."""

import numpy as np
import pytest

from pneumaticbox_driver.faults.pulse_effect import (
    EXPECTED_EFFECT,
    WHILE_OPEN,
    WIDEST_GROWTH,
    PulseEffect,
    Seen,
)
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT

REST = 30e-6
DT = 2e-3
GAS = GAS_CONSTANT * 293.15
FLOW = 20e-6  # of the inlet [kg/s]
SETTINGS = BoxSettings(("a",), (REST,), (150e3,), ("mass",))
PER_MASS = GAS / (REST + WIDEST_GROWTH)  # [Pa/kg]
NOISE = np.array([11.0])


class Channel:
    """One channel with a capacity (volume) and valves that do as they are told, or not."""

    def __init__(self, volume=REST, gauge=20e3, moves=True):
        self.effect = PulseEffect(SETTINGS)
        self.rate, self.moves = GAS / volume, moves
        self.gauge, self.mass, self.noise = gauge, 0.0, NOISE

    def run(self, direction, duration, push=0.0):
        """`push` [Pa/s] is what others add to the pressure."""
        for _ in range(round(duration / DT)):
            gained = direction * FLOW * DT
            self.mass += gained
            self.gauge += self.moves * gained * self.rate + push * DT
            seen = (np.array([self.gauge]), self.noise, np.array([direction * FLOW]))
            valves = np.array([direction], dtype=np.int8)
            self.effect.look(DT, Seen(*seen, np.array([self.mass])), 300e3, valves)

    @property
    def idle(self):
        return bool(self.effect.idle[0])

    @property
    def unvented(self):
        return bool(self.effect.unvented[0])


def open_time(share=1.0):
    """For which the inlet must be open until so much is expected [s]."""
    return share * EXPECTED_EFFECT / (FLOW * PER_MASS)


def test_a_pulse_that_should_have_moved_the_widest_channel_and_did_not_is_idle():
    channel = Channel(moves=False)
    channel.run(1, open_time(1.05))
    assert not channel.idle  # a hand that opens may have kept the pressure
    channel.run(0, 0.12)
    assert channel.idle


def test_less_than_that_is_no_evidence_until_further_pulses_add_up():
    channel = Channel(moves=False)
    channel.run(1, open_time(0.4))
    channel.run(0, 0.3)
    channel.run(1, open_time(0.4))
    channel.run(0, 0.3)
    assert not channel.idle
    channel.run(1, open_time(0.4))
    channel.run(0, 0.3)
    assert channel.idle


def test_a_pulse_keeps_its_verdict_when_one_the_other_way_follows_at_once():
    channel = Channel(moves=False)
    channel.run(1, open_time(1.1))
    channel.run(0, 0.06)
    channel.run(-1, 0.01)
    assert channel.idle


def test_pulses_too_short_for_their_own_verdict_add_up_too():
    channel = Channel(moves=False)
    for _ in range(round(1.1 * open_time() / 0.046)):
        channel.run(1, 0.046)
        channel.run(0, 0.06)
    channel.run(0, 0.2)
    assert channel.idle


def test_pulses_shorter_than_a_valve_takes_to_open_are_no_evidence():
    channel = Channel(moves=False)
    for _ in range(500):
        channel.run(1, 0.006)
        channel.run(0, 0.004)
    channel.run(0, 0.2)
    assert not channel.idle


@pytest.mark.parametrize("volume", [5e-6, REST, REST + WIDEST_GROWTH])
def test_up_to_the_widest_channel_pulses_that_act_are_never_idle(volume):
    channel = Channel(volume)
    for _ in range(20):
        channel.run(1, 0.1)
        channel.run(0, 0.2)
        channel.run(-1, 0.1)
        channel.run(0, 0.2)
    assert not channel.idle and not channel.unvented


def test_a_flow_overestimated_fourfold_in_the_widest_channel_is_not_idle_either():
    channel = Channel(4 * (REST + WIDEST_GROWTH))
    channel.run(1, 4.0)
    channel.run(0, 0.2)
    assert not channel.idle


def test_a_hand_that_undoes_a_pulse_exactly_is_found_out_when_the_valve_closes():
    channel = Channel()
    undone = -FLOW * channel.rate
    channel.run(1, open_time(2.0), push=undone)
    channel.run(0, 0.2, push=undone)
    assert not channel.idle


def test_pressure_that_leaks_away_between_pulses_is_no_evidence():
    channel = Channel(REST + WIDEST_GROWTH)
    gain = 0.15 * FLOW * channel.rate
    for _ in range(30):
        channel.run(1, 0.15)
        channel.run(0, 1.0, push=-gain)
    assert not channel.idle


def test_no_flow_is_expected_where_the_sensors_cannot_tell_the_drop():
    channel = Channel(gauge=270e3, moves=False)
    channel.run(1, 5.0)
    channel.run(0, 0.2)
    empty = Channel(gauge=3e3, moves=False)
    empty.run(-1, 5.0)
    assert not channel.idle and not empty.unvented


@pytest.mark.parametrize("push", [0.0, 5e3])
def test_an_outlet_from_which_the_pressure_does_not_fall_is_unvented(push):
    channel = Channel(moves=False)
    channel.run(-1, open_time(WHILE_OPEN) + 0.12, push)
    assert channel.unvented


def test_a_squeeze_over_an_open_outlet_is_not():
    channel = Channel(gauge=40e3)
    # rises for 0.3 s against the outflow, then falls
    channel.run(-1, 0.3, push=FLOW * channel.rate + 40e3)
    channel.run(-1, 0.8)
    assert not channel.unvented


def test_an_outlet_that_lets_go_after_all_is_no_longer_unvented():
    channel = Channel(moves=False)
    channel.run(-1, open_time(WHILE_OPEN) + 0.12)
    assert channel.unvented
    channel.moves = True
    channel.run(-1, 0.1)
    assert not channel.unvented


# ---------------------------------------------------------------- how much is evidence
EVIDENCE, LATENCY = 1200.0, 0.08  # [Pa] in the widest channel; [s] before anything is expected


def time_for(pressure):
    """For which a valve must be open until so much [Pa] is expected of it [s]."""
    return pressure / (FLOW * PER_MASS)


@pytest.mark.parametrize(("share", "idle"), [(0.99, False), (1.01, True)])
@pytest.mark.parametrize("direction", [1, -1])
def test_a_pulse_is_idle_from_1200_pascal_on_that_it_should_have_brought(share, idle, direction):
    channel = Channel(moves=False)
    channel.run(direction, time_for(share * EVIDENCE))
    assert not channel.idle
    channel.run(0, 0.09)
    assert not channel.idle
    channel.run(0, 0.02)
    assert channel.idle == idle


@pytest.mark.parametrize(("share", "idle"), [(0.99, False), (1.01, True)])
def test_while_its_valve_is_open_a_pulse_is_idle_from_four_times_that(share, idle):
    channel = Channel(moves=False)
    channel.run(1, time_for(share * 4 * EVIDENCE) + LATENCY)
    assert channel.idle == idle


@pytest.mark.parametrize(("share", "unvented"), [(0.99, False), (1.01, True)])
def test_an_outlet_is_unvented_from_four_times_that(share, unvented):
    channel = Channel(moves=False)
    channel.run(-1, time_for(share * 4 * EVIDENCE) + LATENCY)
    assert channel.unvented == unvented


@pytest.mark.parametrize(
    ("noise", "owed", "change", "moved"),
    [
        (30.0, 0.6, 165.0, False),  # four sigma of a difference: 170 Pa
        (30.0, 0.6, 175.0, True),
        (1.0, 0.2, 58.0, False),  # a step of the converter: 61 Pa
        (1.0, 0.2, 64.0, True),
        (99.0, 0.9, 235.0, False),  # at most 240 Pa
        (99.0, 0.9, 245.0, True),
        (1.0, 0.9, 210.0, False),  # a fifth of the 1080 that were expected: 216 Pa
        (1.0, 0.9, 222.0, True),
        (30.0, 0.6, -165.0, False),
        (30.0, 0.6, -175.0, True),
    ],
)
def test_a_change_of_pressure_is_a_motion_beyond_noise_and_a_fifth_of_what_is_expected(
    noise, owed, change, moved
):
    channel = Channel(moves=False)
    channel.noise = np.array([noise])
    channel.run(1, time_for(owed * EVIDENCE))
    channel.run(0, 0.15)
    channel.run(1, DT)  # from which the change is judged
    channel.run(1, DT, push=change / DT)
    channel.run(1, time_for((1.05 - owed) * EVIDENCE))
    channel.run(0, 0.15)
    # a motion ends the sum of what was owed before it
    assert channel.idle == (not moved)


@pytest.mark.parametrize(("change", "idle"), [(60.0, True), (130.0, False)])
def test_small_changes_of_pulses_add_up_to_a_motion(change, idle):
    """Noise of 40 Pa hides 226 Pa."""
    channel = Channel(moves=False)
    channel.noise = np.array([40.0])
    for _ in range(3):
        channel.run(1, DT)
        channel.run(1, DT, push=change / DT)
        channel.run(1, time_for(0.4 * EVIDENCE))
        channel.run(0, 0.15)
    assert channel.idle == idle


@pytest.mark.parametrize("first", [1, -1])
def test_pulses_of_both_directions_do_not_add_up(first):
    channel = Channel(moves=False)
    for direction in (first, -first):
        channel.run(direction, time_for(0.7 * EVIDENCE))
        channel.run(0, 0.15)
    assert not channel.idle
    channel.run(-first, time_for(0.4 * EVIDENCE))
    channel.run(0, 0.15)
    assert channel.idle


@pytest.mark.parametrize(("length", "counts"), [(0.038, False), (0.044, True)])
def test_a_pulse_counts_if_it_is_longer_than_the_slowest_valve_takes_to_open(length, counts):
    channel = Channel(moves=False)
    for _ in range(1 + round(time_for(EVIDENCE) / length)):
        channel.run(1, length)
        channel.run(0, 0.15)
    assert channel.idle == counts


@pytest.mark.parametrize(("drop", "idle"), [(41e3, False), (43e3, True)])
def test_a_drop_from_the_supply_counts_from_42_kilopascal_on(drop, idle):
    channel = Channel(gauge=300e3 - drop, moves=False)
    channel.run(1, time_for(1.1 * EVIDENCE))
    channel.run(0, 0.15)
    assert channel.idle == idle


@pytest.mark.parametrize(("gauge", "idle"), [(4.9e3, False), (5.1e3, True)])
def test_an_outlet_counts_above_what_may_be_an_offset(gauge, idle):
    channel = Channel(gauge=gauge, moves=False)
    channel.run(-1, time_for(1.1 * EVIDENCE))
    channel.run(0, 0.15)
    assert channel.idle == idle


@pytest.mark.parametrize(("fall", "unvented"), [(235.0, True), (245.0, False)])
def test_a_fall_of_240_pascal_from_the_peak_shows_that_an_outlet_is_open(fall, unvented):
    channel = Channel(moves=False)
    channel.run(-1, time_for(2 * EVIDENCE) + LATENCY)
    channel.run(-1, DT, push=500.0 / DT)  # a new peak
    channel.run(-1, DT, push=-fall / DT)
    channel.run(-1, time_for(2.2 * EVIDENCE))
    assert channel.unvented == unvented


def test_a_reset_forgets_all_evidence():
    channel = Channel(moves=False)
    channel.run(1, time_for(0.9 * EVIDENCE))
    channel.run(0, 0.15)
    channel.effect.restart()
    channel.run(1, time_for(0.9 * EVIDENCE))
    channel.run(0, 0.15)
    assert not channel.idle
