"""What controllers decide on made-up states of the box: each is stated, and so is the valve."""

import numpy as np
import pytest
from made_up_box import GAS, KPA, MG, REST, SHORTEST, SUPPLY, MadeUpChannel, Swelling, made_up_view

from pneumaticbox_driver.control.channels import (
    PRESENT,
    ChannelControl,
    ControlError,
    TimeController,
)
from pneumaticbox_driver.control.mass import MassController, MassFlowController
from pneumaticbox_driver.control.pulsewise import Pressure, PulsewiseController, Volume
from softhand_model.gas import AMBIENT_PRESSURE

HELD = 10 * MG


def decided(controller, **state):
    (valve,) = controller.update(made_up_view(**state)).tolist()
    return valve


# ---------------------------------------------------------------- mass
@pytest.mark.parametrize(
    ("error", "valve"),
    [(1.09, 0), (1.11, 1), (-0.54, 0), (-0.56, -1), (0.0, 0), (5.0, 1), (-5.0, -1)],
)
def test_a_valve_opens_for_a_good_half_of_what_the_smallest_pulse_moves(error, valve):
    """2 mg into the channel, 1 mg out of it."""
    assert decided(MassController(), mass=HELD, setpoints=HELD + error * MG) == valve


@pytest.mark.parametrize(("error", "valve"), [(0.09, 0), (0.11, 1), (-0.09, 0), (-0.11, -1)])
def test_a_valve_opens_for_a_tenth_of_a_milligram_at_least(error, valve):
    state = {"mass": HELD, "setpoints": HELD + error * MG, "gain": 0.0, "loss": 0.0}
    assert decided(MassController(), **state) == valve


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(("left", "stays"), [(0.051, True), (0.049, False), (-0.2, False)])
def test_a_valve_closes_at_the_sample_nearest_to_the_target(direction, left, stays):
    """50 mg/s move 0.05 mg in half a sample of 2 ms."""
    valve = decided(
        MassController(),
        mass=HELD,
        setpoints=HELD + direction * left * MG,
        direction=direction,
        flow=direction * 50 * MG,
    )
    assert valve == (direction if stays else 0)


@pytest.mark.parametrize("direction", [0, 1, -1])
@pytest.mark.parametrize("target", [0.0, -5 * MG])
@pytest.mark.parametrize("empty", [True, False])
def test_a_target_of_nothing_empties_to_where_the_mass_is_known(direction, target, empty):
    state = {"mass": 0.0, "setpoints": target, "direction": direction, "empty": empty}
    assert decided(MassController(), **state) == (0 if empty else -1)


@pytest.mark.parametrize("direction", [0, 1, -1])
def test_without_a_target_the_valves_close(direction):
    assert decided(MassController(), mass=HELD, setpoints=np.nan, direction=direction) == 0


def test_each_channel_is_decided_on_by_itself_from_the_pulse_of_its_present_pressure():
    view = made_up_view([HELD, HELD, 0.0], [HELD + 5 * MG, HELD - 5 * MG, np.nan])
    assert MassController().update(view).tolist() == [1, -1, 0]
    ((duration, pressures_abs, supply_abs),) = view.asked
    assert (duration, supply_abs) == (SHORTEST, SUPPLY)
    assert pressures_abs is view.pressures_abs


# ---------------------------------------------------------------- mass flow
def flowing(flow, seconds, mass=HELD, gain=2 * MG, loss=1 * MG, controller=None, **state):
    """Times at which the valve is asked for while the estimate stands at `mass` [kg]."""
    controller = controller or MassFlowController()
    view = made_up_view(mass, flow, gain=gain, loss=loss, **state)
    valves = [int(controller.update(view)[0]) for _ in range(round(seconds / view.dt))]
    return np.array(valves), controller, view


@pytest.mark.parametrize(("flow", "due", "valve"), [(1.0, 1.1, 1), (-1.0, 0.55, -1)])
def test_a_flow_opens_the_valve_when_a_good_half_of_the_smallest_pulse_is_owed(flow, due, valve):
    valves, _, _ = flowing(flow * MG, 2.0)
    opened = np.flatnonzero(valves)
    assert 2e-3 * (opened[0] + 1) == pytest.approx(due, abs=5e-3)
    assert set(valves[opened[0] :].tolist()) == {valve}


@pytest.mark.parametrize(
    ("flow", "caught_up", "valve"),
    [(1.0, 4.8, 1), (1.0, 5.0, 0), (-1.0, -5.3, -1), (-1.0, -5.6, 0)],
)
def test_a_flow_that_cannot_be_followed_waits_three_smallest_pulses_ahead(flow, caught_up, valve):
    """Three times 2 mg, the larger; the valve opens for 1.1 mg in, 0.55 mg out."""
    _, controller, view = flowing(flow * MG, 20.0, dt=2e-2)
    view.observer.mass[:] = HELD + caught_up * MG
    view.setpoints[:] = 0.0
    assert controller.update(view).tolist() == [valve]


def test_what_a_channel_without_pulses_is_owed_is_limited_too():
    _, controller, view = flowing(1 * MG, 5.0, gain=0.0, loss=0.0, dt=2e-2)
    view.setpoints[:] = 0.0
    view.observer.mass[:] = HELD + 0.15 * MG
    assert controller.update(view).tolist() == [1]
    view.observer.mass[:] = HELD + 0.25 * MG
    assert controller.update(view).tolist() == [0]


def test_a_flow_that_begins_anew_is_owed_nothing():
    _, controller, view = flowing(1 * MG, 1.0)
    view.setpoints[:] = np.nan
    assert controller.update(view).tolist() == [0]
    view.setpoints[:] = 1 * MG
    valves = [int(controller.update(view)[0]) for _ in range(500)]
    assert not any(valves)  # 1 mg, less than the 1.1 for which the valve opens


def test_a_flow_goes_on_from_what_it_is_owed():
    _, controller, view = flowing(1 * MG, 1.0)
    valves = [int(controller.update(view)[0]) for _ in range(100)]
    assert any(valves)


@pytest.mark.parametrize(
    ("flow", "empty", "valve"), [(-1.0, False, -1), (-1.0, True, 0), (0.0, False, 0)]
)
def test_a_flow_out_of_an_empty_channel_empties_it_and_no_flow_leaves_it(flow, empty, valve):
    valves, _, _ = flowing(flow * MG, 0.1, mass=-0.5 * MG, empty=empty)
    assert set(valves.tolist()) == {valve}


def test_only_the_channels_of_the_mode_have_a_reference():
    controller = MassFlowController()
    view = made_up_view([HELD, HELD], [1 * MG, np.nan])
    for _ in range(600):
        wanted = controller.update(view)
    assert wanted.tolist() == [1, 0]
    view.setpoints[:] = 1 * MG
    assert controller.update(view).tolist() == [1, 0]


# ---------------------------------------------------------------- pressure and volume
def pressure(setpoint, **options):
    return MadeUpChannel(PulsewiseController(Pressure()), setpoint, **options)


def test_a_pulse_brings_the_air_that_the_model_asks_for_and_one_is_enough():
    channel = pressure(40 * KPA).run(2.0)
    assert channel.gauge == pytest.approx(40 * KPA, abs=150.0)  # half a sample of flow
    assert channel.pulses == 1
    channel.view.setpoints[:] = 10 * KPA
    channel.run(2.0)
    assert channel.gauge == pytest.approx(10 * KPA, abs=150.0)
    assert channel.pulses == 2 and -1 in channel.valves


def test_a_pressure_is_judged_from_ten_samples_and_when_it_has_settled():
    channel = pressure(40 * KPA).run(2.0)
    opened = channel.valves.index(1)
    assert opened == 9
    channel = pressure(40 * KPA, rest=2 * REST).run(3.0)
    valves = np.array(channel.valves)
    switches = np.flatnonzero(np.diff(valves != 0)) + 1
    # 0.12 s after the command that closed it, and the tenth sample from there on
    assert switches[2] - switches[1] == 60 + 9


@pytest.mark.parametrize("truth", [0.5, 2.0])
def test_what_a_pulse_did_corrects_the_next_where_the_volume_is_another(truth):
    channel = pressure(40 * KPA, rest=truth * REST)
    channel.view.observer.mass[0] = AMBIENT_PRESSURE * (truth - 1.0) * REST / GAS
    channel.run(4.0)
    assert channel.gauge == pytest.approx(40 * KPA, rel=0.02)
    assert channel.pulses <= 3


@pytest.mark.parametrize("truth", [0.5, 2.0])
def test_so_it_does_where_air_is_let_out(truth):
    channel = pressure(20 * KPA, rest=truth * REST)
    filled = (60 * KPA + AMBIENT_PRESSURE) * truth * REST - AMBIENT_PRESSURE * REST
    channel.view.observer.mass[0] = filled / GAS
    channel.run(4.0)
    assert channel.gauge == pytest.approx(20 * KPA, rel=0.03)
    assert channel.pulses <= 3


def test_what_one_channel_learns_does_not_change_the_other():
    controller, view = PulsewiseController(Pressure()), made_up_view([0.0, 0.0], [40 * KPA, np.nan])
    volumes = np.array([2 * REST, REST])

    def run(seconds):
        for _ in range(round(seconds / view.dt)):
            view.pressures_abs = AMBIENT_PRESSURE + view.observer.mass * GAS / volumes
            view.direction = controller.update(view)
            view.observer.flow = 50 * MG * view.direction
            view.observer.mass = view.observer.mass + view.observer.flow * view.dt

    run(3.0)
    view.setpoints[:] = [np.nan, 30 * KPA]
    run(0.5)
    assert view.pressures_abs[1] - AMBIENT_PRESSURE == pytest.approx(30 * KPA, abs=150.0)


def test_a_pulse_ends_when_the_pressure_has_passed_its_setpoint_clearly():
    channel = pressure(40 * KPA, rest=0.5 * REST)
    channel.view.observer.mass[0] = -AMBIENT_PRESSURE * 0.5 * REST / GAS
    channel.run(0.5)
    assert 40.3 * KPA < channel.gauge < 41.2 * KPA  # 300 Pa, and a sample of flow


@pytest.mark.parametrize(("rise", "first"), [(60.0, 26), (96.0, 10), (43.0, 49), (41.0, None)])
def test_a_pulse_is_opened_for_three_times_the_noise_of_the_average(rise, first):
    """100 Pa for one sample, an average over 50 at most."""
    channel = pressure(rise, rest=REST, model=Swelling([10.0], 0.0))
    channel.view.observer.mass[0] = 0.0
    channel.run(0.4)
    opened = channel.valves.index(1) + 1 if 1 in channel.valves else None
    assert opened == first


@pytest.mark.parametrize(("rise", "pulses"), [(300.0, 0), (320.0, 1), (-300.0, 0), (-320.0, 1)])
def test_a_pulse_is_not_opened_for_less_than_half_of_the_smallest(rise, pulses):
    """0.2 mg; a good half is 0.11 mg, and 309 Pa in 30 ml."""
    channel = pressure(20 * KPA + rise)
    channel.view.observer.mass[0] = 20 * KPA * REST / GAS
    assert channel.run(0.2).pulses == pulses


@pytest.mark.parametrize("setpoint", [0.0, -1000.0])
def test_a_setpoint_of_nothing_opens_the_outlet_until_the_channel_is_empty(setpoint):
    channel = pressure(setpoint)
    channel.view.observer.mass[0] = HELD
    channel.step()
    assert channel.valves == [-1]
    channel.view.empty[:] = True
    channel.step()
    assert channel.valves == [-1, 0]


def test_a_volume_is_reached_by_the_air_that_the_model_asks_for():
    slope = 0.3e-9  # 12 ml at 40 kPa
    model = Swelling([REST], slope)
    channel = MadeUpChannel(PulsewiseController(Volume()), 12e-6, slope=slope, model=model).run(2.0)
    assert channel.volume - REST == pytest.approx(12e-6, abs=0.1e-6)
    assert channel.pulses == 1
    channel.view.setpoints[:] = 3e-6
    channel.run(2.0)
    assert channel.volume - REST == pytest.approx(3e-6, abs=0.1e-6)


@pytest.mark.parametrize("truth", [0.6, 1.5])
def test_what_a_pulse_did_to_the_volume_corrects_the_next(truth):
    """A pressed finger takes more air for the same volume, and more pressure."""
    slope, model = truth * 0.3e-9, Swelling([REST], 0.3e-9)
    channel = MadeUpChannel(PulsewiseController(Volume()), 10e-6, slope=slope, model=model)
    channel.run(4.0)
    assert channel.volume - REST == pytest.approx(10e-6, rel=0.03)
    assert channel.pulses <= 3


def test_a_pressure_in_a_swelling_channel_takes_the_air_of_the_larger_volume():
    slope = 0.5e-9
    channel = pressure(40 * KPA, slope=slope, model=Swelling([REST], slope)).run(2.0)
    assert channel.gauge == pytest.approx(40 * KPA, abs=150.0)
    assert channel.pulses == 1


@pytest.mark.parametrize("direction", [1, -1])
def test_a_pulse_ends_when_the_volume_has_passed_its_setpoint_clearly(direction):
    """By as much as 300 Pa would change it, here 0.06 ml, though the air has not come."""
    controller = PulsewiseController(Volume())
    start = 20 * MG
    view = made_up_view(start, np.nan, gain=0.2 * MG, loss=0.2 * MG, model=Swelling([REST], 0.3e-9))
    content = start * GAS + AMBIENT_PRESSURE * REST
    view.pressures_abs = np.array([content / (REST + 10e-6)])
    view.setpoints[:] = 10e-6 + direction * 5e-6
    while not view.direction.any():
        view.direction = controller.update(view)
    asked = view.setpoints[0] + REST
    margin = 300.0 * asked / (content / asked)
    for beyond, valve in ((0.9 * margin, direction), (1.2 * margin, 0)):
        volume = asked + direction * beyond
        view.pressures_abs = np.array([content / volume])
        assert controller.update(view).tolist() == [valve]


@pytest.mark.parametrize(
    ("push", "rise"), [(0.0, 30 * KPA), (900.0, 30 * KPA), (-900.0, 30 * KPA), (1500.0, 15 * KPA)]
)
def test_what_was_learnt_is_forgotten_when_the_pressure_moves_by_itself(push, rise):
    """The channel is twice as large as believed: without a lesson a pulse brings the half."""
    channel = pressure(20 * KPA, rest=2 * REST)
    channel.view.observer.mass[0] = AMBIENT_PRESSURE * REST / GAS
    channel.run(2.0)
    channel.view.setpoints[:], channel.push = np.nan, push
    channel.run(0.3)
    before = float(channel.view.observer.mass[0])
    channel.view.setpoints[:] = channel.gauge + push + 30 * KPA
    while not (channel.valves[-1] == 0 and channel.valves[-2] != 0):
        channel.step()
    moved = channel.view.observer.mass[0] - before
    assert moved * GAS / (2 * REST) == pytest.approx(rise, rel=0.02)


@pytest.mark.parametrize("rest", [REST, 0.2 * REST])
def test_nothing_is_inflated_beyond_97_percent_of_the_limit_and_that_is_said(rest):
    """What still flows in 30 ms while the valve closes counts too."""
    channel = MadeUpChannel(
        PulsewiseController(Volume()), 40e-6, rest=rest, model=Swelling([REST], 0.2e-9)
    )
    channel.view.observer.mass[0] = -AMBIENT_PRESSURE * (REST - rest) / GAS
    channel.run(3.0)
    late = 0.03 * channel.flow * GAS / rest
    assert 0.97 * 150 * KPA - 2 * late < channel.gauge < 0.97 * 150 * KPA
    assert channel.controller.saturated.tolist() == [True]
    assert -1 not in channel.valves
    channel.view.setpoints[:] = np.nan
    channel.run(0.5)
    assert channel.controller.saturated.tolist() == [False]
    assert channel.valves[-1] == 0


def test_without_a_setpoint_no_valve_opens():
    for quantity in (Pressure(), Volume()):
        channel = MadeUpChannel(PulsewiseController(quantity), np.nan)
        channel.view.observer.mass[0] = HELD
        assert not any(channel.run(0.3).valves)


# ---------------------------------------------------------------- all channels
def test_the_controller_of_a_mode_goes_on_when_another_channel_leaves_it_until_a_reset():
    control = ChannelControl(("mass_flow", "mass_flow"))

    def opened(samples, *setpoints):
        views = [made_up_view([HELD, HELD], setpoints) for _ in range(samples)]
        return any(control.update(view).any() for view in views)

    assert not opened(549, 1 * MG, 1 * MG)
    control.switch(("mass_flow", "mass"))
    assert opened(5, 1 * MG, HELD)
    control.restart()
    assert not opened(5, 1 * MG, HELD)
    with pytest.raises(ValueError, match="control_mode must be one of"):
        control.switch(("mass", "speed"))
    assert control.modes == ("mass_flow", "mass")


def test_targets_beyond_the_limit_are_told_of_the_channels_in_these_modes_alone():
    control = ChannelControl(("volume",))
    assert control.saturated.tolist() == [False]
    channel = MadeUpChannel(control, 40e-6, model=Swelling([REST], 0.2e-9)).run(3.0)
    assert channel.gauge > 100 * KPA and control.saturated.tolist() == [True]
    control.switch(("mass",))
    assert control.saturated.tolist() == [False]


def test_a_controller_that_fails_is_told_with_its_channels(monkeypatch):
    control = ChannelControl(("mass", "time", "mass"))
    monkeypatch.setattr(MassController, "update", lambda *_: 1 / 0)
    with pytest.raises(ControlError) as failed:
        control.update(made_up_view([HELD] * 3, [HELD] * 3))
    assert (failed.value.mode, failed.value.channels) == ("mass", [0, 2])


def test_the_present_state_is_held_by_its_own_setpoint():
    view = made_up_view([HELD], np.nan)
    steady = np.array([AMBIENT_PRESSURE + 20 * KPA])
    assert PRESENT["mass"](view, steady) == pytest.approx([HELD])
    assert PRESENT["pressure"](view, steady) == pytest.approx([20 * KPA])
    volume = (HELD * GAS + AMBIENT_PRESSURE * REST) / steady - REST
    assert PRESENT["volume"](view, steady) == pytest.approx(volume)


def test_the_schedule_is_commanded_as_it_is_and_nothing_closes():
    view = made_up_view([0.0] * 4, [1.0, -1.0, 0.0, np.nan])
    assert TimeController().update(view).tolist() == [1, -1, 0, 0]


def test_every_channel_is_decided_on_in_its_own_mode():
    control = ChannelControl(("mass", "time", "mass_flow", "mass"))
    view = made_up_view([HELD] * 4, [HELD + 5 * MG, -1.0, 0.0, HELD - 5 * MG])
    assert control.update(view).tolist() == [1, -1, 0, -1]
    assert control.modes == ("mass", "time", "mass_flow", "mass")
    control.switch(("time", "mass", "mass", "mass"))
    view = made_up_view([HELD] * 4, [-1.0, HELD + 5 * MG, np.nan, HELD])
    assert control.update(view).tolist() == [-1, 1, 0, 0]
