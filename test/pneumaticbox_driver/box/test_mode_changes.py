"""Every change of control mode in every state of the box, with bottles and with a hand."""

from itertools import product

import pytest
from bottle_rig import BottleRig
from hand_rig import HandRig

from pneumaticbox_driver.modes import MODES

MG = 1e-6
SOON = 0.15  # [s]
TARGETS = {"mass": 8 * MG, "mass_flow": 4 * MG, "pressure": 12e3, "volume": 4e-6, "time": 1.0}


def leave(rig):
    """As it is after its start."""


def fill_some(rig):
    rig.box.command(rig.names[:1], [point_of("mass", 10 * MG)], 0.0, rig.box.time)
    rig.run(1.0)


def point_of(mode, value):
    from pneumaticbox_driver.box.commands import TrajectoryPoint

    return TrajectoryPoint(0.0, **{MODES[mode].field: [value]})


def vent(rig):
    fill_some(rig)
    rig.box.vent()
    rig.run(SOON)


def disable(rig):
    fill_some(rig)
    rig.box.enable(False)
    rig.run(SOON)


STATES = {"never commanded": leave, "commanded": fill_some, "venting": vent, "disabled": disable}


def rig_of(plant):
    return HandRig() if plant == "hand" else BottleRig(channels=4, volume=1e-4)


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("plant", ["hand", "bottles"])
def test_every_change_of_modes_is_survived_in_every_state(plant, state):
    rig = rig_of(plant)
    rig.run(1.0, 4e-3)
    STATES[state](rig)
    reasons = list(rig.box.latch.reasons)
    modes = [mode for mode in MODES if plant == "hand" or mode != "volume"]
    for one, other in product(modes, modes):
        rig.box.set_modes([one, other, one, "mass"])
        rig.run(SOON, 1e-2)
        rig.box.set_modes([other, other, one, one])
        rig.run(SOON, 1e-2)
        assert rig.box.latch.reasons == reasons
    assert rig.box.control.modes == (modes[-1],) * 4


@pytest.mark.parametrize("plant", ["hand", "bottles"])
def test_a_channel_in_each_mode_is_controlled_beside_channels_without_a_target(plant):
    rig = rig_of(plant)
    for mode in MODES:
        if plant == "bottles" and mode == "volume":
            continue
        rig.run(1.0, 4e-3)
        rig.box.set_modes([mode, "pressure", "mass", "mass"])
        take = rig.box.schedule_valves if MODES[mode].scheduled else rig.box.command
        take(rig.names[:1], [point_of(mode, TARGETS[mode])], 0.0, rig.box.time)
        rig.run(0.5, 4e-3)
        assert not rig.box.latch and rig.box.openings[0] > 0
        rig.box.set_modes(["mass"] * 4)


@pytest.mark.parametrize("mode", MODES)
def test_a_start_in_any_mode_needs_no_command(mode):
    rig = HandRig(mode=mode).started()
    rig.run(SOON)
    assert not rig.box.latch and not rig.box.valves.any()
