"""What a channel cannot contain, and what lies too far ahead, is refused and named."""

import numpy as np
import pytest
from bottle_rig import BottleRig
from hand_rig import HandRig

from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.modes import MODES

MG, CM3 = 1e-6, 1e-6
RT = 287.05 * 293.15  # [J/kg]


@pytest.fixture(scope="module")
def finger():
    """The box of one finger of 18.8 cm3, 44.3 cm3 at its limit of 80 kPa."""
    return HandRig("single_finger").started().box


def send(box, mode, value, time=0.0, stamp=0.0):
    box.set_modes([mode] * len(box.settings.channels))
    point = TrajectoryPoint(time, **{MODES[mode].field: [value]})
    box.command(box.settings.channels[:1], [point], stamp, box.time)


@pytest.mark.parametrize(
    ("mode", "least", "most"),
    [
        ("mass", -101.3e3 * 18.81e-6 / RT, (181.3e3 * 1.5 * 44.27e-6 - 101.3e3 * 18.81e-6) / RT),
        ("mass_flow", -143e-6 / 0.045, 143e-6 / 0.045),
        ("pressure", -101.3e3, 80e3),
        ("volume", -18.81e-6, 1.5 * 44.27e-6 - 18.81e-6),
    ],
)
def test_targets_are_taken_within_what_the_hand_can_contain(finger, mode, least, most):
    for value in (0.0, 0.99 * least, 0.99 * most):
        send(finger, mode, value)
    before = finger.commands.setpoints.at(finger.time)
    for value in (1.02 * least, 1.02 * most, 1e300, -1e300, 1e9, -1e9):
        with pytest.raises(ValueError, match=f"channel a in mode {mode}: expected -.* to") as error:
            send(finger, mode, value)
        assert f"{MODES[mode].unit}, got {value:.6g}" in str(error.value)
    np.testing.assert_array_equal(finger.commands.setpoints.at(finger.time), before)


@pytest.mark.parametrize("value", [1e300, 1.0, -1.0])
def test_a_mass_that_no_channel_contains_is_refused_without_a_known_hand_too(value):
    box = BottleRig(channels=2).started().box
    with pytest.raises(ValueError, match=r"points\[0\].positions\[0\]: channel a in mode mass"):
        send(box, "mass", value)
    send(box, "mass", 100 * MG)


def test_a_whole_command_is_refused_for_one_point_of_one_channel():
    rig = BottleRig(channels=2).started()
    points = [TrajectoryPoint(0.0, [0.0, 0.0]), TrajectoryPoint(1.0, [5 * MG, 1.0])]
    with pytest.raises(ValueError, match=r"points\[1\].positions\[1\]: channel b"):
        rig.box.command(rig.names, points, 0.0, rig.box.time)
    assert np.isnan(rig.box.commands.setpoints.at(rig.box.time)).all()


def test_a_stamp_too_far_ahead_is_refused(finger):
    send(finger, "mass", 0.0, stamp=finger.time + 59.0)
    with pytest.raises(ValueError, match=r"at most 60 s ahead \(command_lead\), got 100000 s"):
        send(finger, "mass", 0.0, stamp=finger.time + 100_000.0)


def test_a_schedule_too_far_ahead_is_refused(finger):
    finger.set_modes(["time"])
    with pytest.raises(ValueError, match="at most 60 s ahead"):
        stamp = finger.time + 61.0
        finger.schedule_valves(["a"], [TrajectoryPoint(0.0, [1.0])], stamp, finger.time)


def test_a_course_that_ends_in_years_is_refused(finger):
    send(finger, "mass", 0.0, time=3600.0)
    with pytest.raises(ValueError, match=r"points\[0\].time_from_start: expected at most 3600 s"):
        send(finger, "mass", 0.0, time=2e9)


def test_how_far_ahead_is_a_setting():
    rig = BottleRig(channels=1, command_lead=1.0, command_span=2.0).started()
    rig.command(5 * MG, stamp=rig.box.time + 0.9, after=1.9)
    with pytest.raises(ValueError, match="at most 1 s ahead"):
        rig.command(5 * MG, stamp=rig.box.time + 1.1)
    with pytest.raises(ValueError, match="at most 2 s"):
        rig.command(5 * MG, after=2.1)


def test_names_of_any_length_are_quoted_in_200_characters(finger):
    with pytest.raises(ValueError, match="got 'xxx") as error:
        finger.command(["x" * 10_000_000], [TrajectoryPoint(0.0, [0.0])], 0.0, finger.time)
    assert len(str(error.value)) < 300
