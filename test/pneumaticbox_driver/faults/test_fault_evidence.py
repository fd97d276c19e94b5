"""Fault watch on made-up readings: what was seen is stated, and so is what must be said of it."""

from dataclasses import replace

import numpy as np
import pytest

from pneumaticbox_driver.faults.fault_watch import FaultView, FaultWatch
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import AMBIENT_PRESSURE

DT = 0.01
KPA, MG = 1e3, 1e-6
SUPPLY = 300 * KPA
LOST = "channel a: has lost its pressure with the valve closed: burst, or outlet stuck open"
NO_SUPPLY = "supply lost: its pressure is below what any channel needs"
BACKFLOW = "channel a: the supply is below its pressure, air flows back"
IDLE = "channel a: pulses do not move its pressure: valve stuck or burst"
UNVENTED = "channel a: pressure does not fall with the outlet commanded open"
SHUT_OFF = f"{UNVENTED}: shut off the supply"


class Watch:
    """A watch over channels a and b; of b nothing ever happens."""

    def __init__(self, rest=30e-6):
        settings = BoxSettings(("a", "b"), (rest, rest), (150 * KPA,) * 2, ("mass",) * 2)
        self.watch, self.time = FaultWatch(settings), 0.0

    def look(self, duration, pressure, **state):
        """Let a stand at a gauge pressure [Pa]; the reasons that were given, with their times."""
        told = {}
        for _ in range(round(duration / DT)):
            self.time += DT
            seen = view(pressure, **state)
            # without noise: that such a reading stands still means nothing
            assert self.watch.due(DT, AMBIENT_PRESSURE + np.append(seen.pressures, seen.supply))
            for reason in self.watch.look(seen):
                told.setdefault(reason, self.time)
        return told


def view(pressure, supply=SUPPLY, valve=0, flow=0.0, mass=15 * MG, known=True, ready=True):
    return FaultView(
        np.array([pressure, 0.0]),
        supply,
        np.array([valve, 0], dtype=np.int8),
        np.array([flow, 0.0]),
        np.array([mass, 0.0]),
        np.array([known, True]),
        ready,
    )


# ---------------------------------------------------------------- pressure lost
def after_loss(rest=30e-6, before=40 * KPA, after=0.0, duration=1.0, **state):
    watch = Watch(rest)
    assert watch.look(1.0, before, **state) == {}
    return watch.look(duration, after, **state), watch


def test_a_closed_channel_that_falls_to_ambient_with_air_in_it_has_lost_its_pressure():
    told, _ = after_loss()
    assert list(told) == [LOST]
    # 0.4 s at ambient pressure, and what the low-pass of 0.03 s takes to get there
    fall = 0.03 * np.log(40e3 / 240)
    assert told[LOST] == pytest.approx(1.0 + 0.4 + fall, abs=0.05)


@pytest.mark.parametrize(
    "state",
    [{"mass": 4.9 * MG}, {"known": False}, {"after": 245.0}, {"after": -245.0}, {"before": 470.0}],
    ids=lambda state: "-".join(state),
)
def test_there_is_no_loss_without_air_or_pressure_to_lose(state):
    assert after_loss(**state)[0] == {}


@pytest.mark.parametrize(
    "state",
    [{"mass": 5.1 * MG}, {"after": 235.0}, {"after": -235.0}, {"before": 490.0}],
    ids=lambda state: "-".join(state),
)
def test_a_loss_is_seen_from_there_on(state):
    assert list(after_loss(**state)[0]) == [LOST]


@pytest.mark.parametrize(("mass", "seen"), [(59 * MG, False), (62 * MG, True)])
def test_the_air_that_a_large_channel_must_hold_is_a_twentieth_of_its_fill(mass, seen):
    # a litre holds 1.204 g at rest
    assert (LOST in after_loss(rest=1e-3, mass=mass)[0]) == seen


def test_a_pressure_that_passes_through_ambient_is_no_loss():
    told, watch = after_loss(duration=0.4)
    assert told == {}
    assert watch.look(0.1, 2 * KPA) == {}
    assert watch.look(0.4, 0.0) == {}
    assert list(watch.look(0.2, 0.0)) == [LOST]


@pytest.mark.parametrize("valve", [-1, 1])
def test_with_a_valve_open_the_pressure_may_fall(valve):
    watch = Watch()
    watch.look(1.0, 40 * KPA)
    assert LOST not in watch.look(0.7, 0.0, valve=valve)
    told = watch.look(1.0, 0.0)
    # what was there before the outlet opened was let out
    assert (LOST in told) == (valve > 0)


@pytest.mark.parametrize(("valve", "lost"), [(0, True), (-1, False)])
def test_what_falls_just_after_an_outlet_was_open_was_let_out(valve, lost):
    watch = Watch()
    watch.look(0.5, 2 * KPA, valve=valve)
    assert (LOST in watch.look(1.0, 0.0)) == lost


def test_a_reset_forgets_the_evidence():
    _, watch = after_loss(duration=0.45)
    watch.watch.restart()
    assert watch.look(1.0, 0.0) == {}


def test_nothing_is_said_before_the_sensors_have_been_averaged():
    assert after_loss(ready=False)[0] == {}


# ---------------------------------------------------------------- supply
@pytest.mark.parametrize(("supply", "lost"), [(19.5 * KPA, True), (20.5 * KPA, False)])
def test_a_supply_that_was_there_and_is_gone_is_lost(supply, lost):
    watch = Watch()
    watch.look(0.1, 0.0)
    told = watch.look(0.2, 0.0, supply=supply)
    assert list(told) == ([NO_SUPPLY] if lost else [])
    if lost:
        assert told[NO_SUPPLY] == pytest.approx(0.1 + 0.06, abs=0.0101)


@pytest.mark.parametrize(("seen", "lost"), [(39 * KPA, False), (41 * KPA, True)])
def test_a_supply_that_was_never_there_is_not_missed_while_nothing_is_inflated(seen, lost):
    watch = Watch()
    watch.look(0.1, 0.0, supply=seen)
    assert (NO_SUPPLY in watch.look(0.2, 0.0, supply=0.0)) == lost


@pytest.mark.parametrize(("valve", "lost"), [(0, False), (-1, False), (1, True)])
def test_a_supply_that_was_never_there_is_missed_when_a_channel_inflates(valve, lost):
    assert (NO_SUPPLY in Watch().look(0.2, 0.0, supply=0.0, valve=valve)) == lost


def test_a_supply_that_drops_for_a_moment_is_not_lost():
    watch = Watch()
    for _ in range(5):
        assert watch.look(0.05, 0.0) == {}
        assert watch.look(0.05, 0.0, supply=0.0) == {}


@pytest.mark.parametrize(("below", "told"), [(20.5 * KPA, []), (21.5 * KPA, [BACKFLOW])])
def test_air_flows_back_where_the_supply_is_clearly_below_an_inflating_channel(below, told):
    watch = Watch()
    watch.look(0.5, 80 * KPA)
    found = watch.look(0.3, 80 * KPA, valve=1, supply=80 * KPA - below)
    assert list(found) == told
    if told:
        assert found[BACKFLOW] == pytest.approx(0.5 + 0.11, abs=0.0101)


def test_no_air_flows_back_through_a_closed_inlet_or_in_a_moment():
    watch = Watch()
    assert watch.look(0.5, 80 * KPA, supply=30 * KPA) == {}
    for _ in range(4):
        assert watch.look(0.1, 80 * KPA, supply=30 * KPA, valve=1) == {}
        assert watch.look(0.1, 80 * KPA, supply=30 * KPA, valve=-1) == {}


# ---------------------------------------------------------------- pulses
def pulsed(direction, pressure=40 * KPA, duration=2.0, flow=50 * MG):
    """A watch that saw a long pulse without any effect; the reasons, told before and after."""
    watch = Watch()
    watch.look(0.5, pressure)
    told = watch.look(duration, pressure, valve=direction, flow=direction * flow)
    return watch, told


def test_pulses_without_effect_are_told():
    watch, told = pulsed(1)
    assert list(told) == [IDLE]
    assert watch.watch.stuck_outlets() == []


def test_an_outlet_without_effect_is_told_as_that_and_what_to_do_about_it():
    watch, told = pulsed(-1)
    assert UNVENTED in told
    assert watch.watch.stuck_outlets() == [SHUT_OFF]
    assert list(watch.look(0.01, 40 * KPA, valve=-1, flow=-50 * MG)) == [UNVENTED]


def test_of_sound_pulses_nothing_is_told():
    watch = Watch()
    for step in range(100):
        assert watch.look(0.02, step * KPA, valve=1, flow=50 * MG) == {}


# ---------------------------------------------------------------- sensors
def taught(noise=60.0):
    """A watch whose sensors have shown their noise, with the readings of a sample to come."""
    watch, drawn = Watch().watch, np.random.default_rng(3)
    for _ in range(100):
        watch.due(2e-3, AMBIENT_PRESSURE + 61.0 * np.round(drawn.normal(0, noise, 3) / 61.0))
    return watch


@pytest.mark.parametrize(("sensor", "name"), [(0, "a"), (1, "b"), (2, "supply")])
def test_a_sensor_that_stands_still_is_told_by_its_name(sensor, name):
    watch, drawn = taught(), np.random.default_rng(4)
    for _ in range(200):
        readings = AMBIENT_PRESSURE + 61.0 * np.round(drawn.normal(0, 1.0, 3))
        readings[sensor] = AMBIENT_PRESSURE + 122.0
        watch.due(2e-3, readings)
    assert watch.look(view(0.0)) == [f"sensor {name}: its reading is constant"]
    blind = [f"channel {name}: without its sensor it cannot be seen to empty"]
    assert watch.stuck_outlets() == (blind if sensor < 2 else [])


@pytest.mark.parametrize(
    ("gauge", "told"), [(-3400.0, True), (-3600.0, False), (149e3, True), (151e3, False)]
)
def test_a_reading_at_the_end_of_the_range_may_stand_still(gauge, told):
    watch, drawn = taught(), np.random.default_rng(4)
    for _ in range(200):
        readings = AMBIENT_PRESSURE + 61.0 * np.round(drawn.normal(0, 1.0, 3))
        readings[0] = AMBIENT_PRESSURE + gauge
        watch.due(2e-3, readings)
    assert bool(watch.look(view(0.0))) == told


def test_a_look_is_due_every_eight_milliseconds():
    watch, readings = Watch().watch, np.full(3, AMBIENT_PRESSURE)
    due = []
    for _ in range(12):
        due.append(watch.due(2e-3, readings))
        if due[-1]:
            watch.look(view(0.0))
    assert due == [False, False, False, True] * 3


@pytest.mark.parametrize("sensor", [0, 1, 2])
def test_lost_readings_are_no_look_and_leave_the_outlet_unseen_until_they_come_back(sensor):
    watch, readings = Watch().watch, np.full(3, AMBIENT_PRESSURE)
    lost = readings.copy()
    lost[sensor] = np.nan
    for _ in range(10):
        assert not watch.due(2e-3, lost)
    assert len(watch.stuck_outlets()) == (sensor < 2)
    watch.due(2e-3, readings)
    assert watch.stuck_outlets() == []


def test_a_new_beginning_forgets_what_the_sensors_and_the_supply_were():
    watch = Watch()
    watch.look(0.1, 0.0)
    watch.watch.begin()
    assert watch.look(0.5, 0.0, supply=0.0) == {}


def test_a_frozen_sensor_is_told_and_not_its_valve_besides():
    watch, drawn = taught(), np.random.default_rng(4)
    for _ in range(200):
        readings = AMBIENT_PRESSURE + 61.0 * np.round(drawn.normal(0, 1.0, 3))
        readings[0] = AMBIENT_PRESSURE + 40e3
        watch.due(2e-3, readings)
    told = set()
    for valve in (0, 1):
        for _ in range(200):
            told.update(watch.look(view(40 * KPA, valve=valve, flow=valve * 50 * MG)))
    assert told == {"sensor a: its reading is constant"}


def test_behind_a_frozen_sensor_the_other_channels_are_looked_at_all_the_same():
    watch, drawn = taught(), np.random.default_rng(4)
    still = replace(view(40 * KPA), pressures=np.full(2, 40 * KPA))
    pulses = replace(still, valves=np.array([0, 1], dtype=np.int8), flow=np.array([0.0, 50 * MG]))
    told = set()
    for seen in (still, pulses):
        for _ in range(200):
            readings = AMBIENT_PRESSURE + 40e3 + 61.0 * np.round(drawn.normal(0, 1.0, 3))
            readings[0] = AMBIENT_PRESSURE + 40e3
            watch.due(DT, readings)
            told.update(watch.look(seen))
    assert told == {"sensor a: its reading is constant", IDLE.replace("channel a", "channel b")}


def test_pulses_are_judged_by_smoothed_pressures_and_what_is_left_of_the_noise(monkeypatch):
    watch, seen = taught(), []
    sigma = watch._frozen.noise[0]
    monkeypatch.setattr(watch._effect, "look", lambda dt, given, *rest: seen.append(given))
    for pressure in [0.0] * 40 + [1000.0] * 2:
        watch.due(DT, np.full(3, AMBIENT_PRESSURE))
        watch.look(view(pressure))
    # a low-pass of 30 ms at samples 10 ms apart takes a quarter of each
    assert [given.pressures[0] for given in seen[-3:]] == pytest.approx([0.0, 250.0, 437.5])
    assert seen[0].pressures[0] == 0.0
    assert seen[-1].noise[0] == pytest.approx(sigma * np.sqrt(0.25**2 / (1 - 0.75**2)))
