"""Pulses against what they do, on pressures given by hand."""

import numpy as np
import pytest

from pneumaticbox_driver.faults.pulse_effect import (
    EXPECTED,
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
        self.gauge, self.mass = gauge, 0.0

    def run(self, direction, duration, push=0.0):
        """`push` [Pa/s] is what others add to the pressure."""
        for _ in range(round(duration / DT)):
            gained = direction * FLOW * DT
            self.mass += gained
            self.gauge += self.moves * gained * self.rate + push * DT
            seen = (np.array([self.gauge]), NOISE, np.array([direction * FLOW]))
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
    return share * EXPECTED / (FLOW * PER_MASS)


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
