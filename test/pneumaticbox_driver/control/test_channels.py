"""Switching control modes at run time: no jump, others untouched; and time-based control."""

from itertools import product

import numpy as np
import pytest
from bottle_rig import BottleRig, Swelling

from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.modes import MODES

MG = 1e-6
FINGER = {"volume": 30e-6, "compliance": 0.8}


def filled(**options):
    model = Swelling(FINGER["volume"], FINGER["compliance"], 3)
    rig = BottleRig(channels=3, model=model, volume_model="hand", **{**FINGER, **options}).started()
    rig.command(15 * MG, 15 * MG, 15 * MG)
    rig.run(2.5)
    rig.openings[:] = 0
    return rig


def test_every_switch_at_standstill_leaves_the_valves_closed_for_a_second():
    rig = filled()
    for before, after in product(MODES, MODES):
        rig.box.set_modes([before] * 3)
        rig.run(0.3, 5e-3)
        rig.box.set_modes([after] * 3)
        rig.run(1.0, 5e-3)
        assert not rig.openings.any(), (before, after)
        assert rig.box.control.modes == (after,) * 3


def test_the_new_setpoint_of_mass_is_the_estimate_and_others_keep_theirs():
    rig = filled()
    rig.box.set_modes(["mass", "time", "mass"])
    np.testing.assert_allclose(rig.box.commands.setpoints.at(rig.box.time), [15 * MG, 0.0, 15 * MG])
    rig.schedule((0.0, -1.0), (0.2, 0.0), names=["b"])
    rig.run(1.0)
    rig.box.set_modes(["mass"] * 3)
    estimate = rig.box.observer.mass[1]
    assert 2 * MG < estimate < 10 * MG
    np.testing.assert_allclose(
        rig.box.commands.setpoints.at(rig.box.time), [15 * MG, estimate, 15 * MG]
    )


def test_modes_that_cannot_be_change_nothing():
    rig = filled()
    for wrong, named in ((["mass"] * 2, "3 entries, got 2"), (["time", "mass", "x"], "got 'x'")):
        with pytest.raises(ValueError, match=named):
            rig.box.set_modes(wrong)
    assert rig.box.control.modes == ("mass",) * 3
    np.testing.assert_allclose(rig.box.commands.setpoints.at(rig.box.time), 15 * MG)


def test_a_vented_or_empty_channel_has_no_setpoint_after_a_switch():
    rig = filled()
    rig.box.vent()
    rig.box.set_modes(["time"] * 3)
    rig.box.set_modes(["mass"] * 3)
    assert np.isnan(rig.box.commands.setpoints.at(rig.box.time)).all()


# time-based control


def test_a_schedule_acts_at_the_samples_nearest_to_its_events():
    rig = BottleRig(channels=2, mode="time").started()
    start = rig.box.time
    events = [(0.1007, 1.0), (0.1512, 0.0), (0.3003, -1.0), (0.4508, 0.0)]
    rig.schedule(*events, names=["a"])
    rig.run(1.0)
    got = [(time - start, valve) for time, channel, valve in rig.switchings]
    assert [valve for _, valve in got] == [1, 0, -1, 0]
    np.testing.assert_allclose([t for t, _ in got], [t for t, _ in events], atol=0.001 + 1e-9)
    assert rig.box.openings.tolist() == [2, 0]


def test_a_schedule_far_ahead_keeps_its_time_and_the_earlier_plan_goes_on():
    rig = BottleRig(channels=1, mode="time").started()
    start = rig.box.time
    rig.schedule((0.0, 1.0), (3.0, 0.0))
    rig.schedule((0.0, 0.0), stamp=start + 1.0)
    rig.run(2.0)
    times = [time - start for time, _, _ in rig.switchings]
    np.testing.assert_allclose(times, [0.002, 1.0], atol=0.0021)


@pytest.mark.parametrize(
    ("names", "events", "expected"),
    [
        (["b"], [(0, 1)], "joint_names: expected channels in mode time, got b in mass"),
        (["a"], [(0, 0.5)], r"points\[0\].positions\[0\]: expected -1, 0 or 1, got 0.5"),
        (
            ["a"],
            [(0, 1), (0.02, 0)],
            "expected an open valve to stay as it is for 45 ms at least, got 20",
        ),
        (["a"], [(0, 1), (1, 0), (1.01, 1)], "expected a closed valve .* 60 ms at least, got 10"),
        (["a"], [(0, 1), (1, -1)], "expected 0 between 1 and -1, for 60 ms at least"),
    ],
)
def test_a_schedule_that_valves_cannot_follow_is_refused(names, events, expected):
    rig = BottleRig(channels=2)
    rig.box.set_modes(["time", "mass"])
    rig.started()
    with pytest.raises(ValueError, match=expected):
        rig.schedule(*events, names=names)
    rig.run(0.5)
    assert not rig.box.openings.any()


def test_a_command_to_a_channel_in_mode_time_is_refused_and_names_the_topic():
    rig = BottleRig(channels=2)
    rig.box.set_modes(["mass", "time"])
    with pytest.raises(ValueError, match=r"\['b'\] in mode time.*pneumaticbox/valve_schedule"):
        rig.box.command(["a", "b"], [TrajectoryPoint(0.0, (1e-5, 1e-5))], 0.0, 0.0)


def test_a_vented_box_takes_no_schedule():
    rig = BottleRig(channels=1, mode="time").started()
    rig.box.vent()
    with pytest.raises(ValueError, match="vented until reset"):
        rig.schedule((0.0, 1.0))
