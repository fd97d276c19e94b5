from types import SimpleNamespace as Fields

import numpy as np
import pytest

from grasp_strategies.ros.messages import (
    Feed,
    read_air_state,
    read_force,
    read_modes,
    read_pose,
    read_report,
    read_touching,
)


def pose(position=(1.0, 2.0, 3.0), orientation=(0.0, 0.0, 0.6, 0.8), frame="world"):
    return Fields(frame=frame, numbers=(*position, *orientation))


def contacts(*pairs, action=0):
    return Fields(markers=[Fields(ns=pair, action=action) for pair in pairs])


def state(name=("a", "b"), position=(1e-5, 2e-5), effort=(3e4, 4e4)):
    return Fields(name=list(name), position=list(position), effort=list(effort))


def test_a_pose_is_read_and_its_quaternion_normalised():
    read = read_pose(pose(orientation=(0.0, 0.0, 0.603, 0.804)))
    assert read.position.tolist() == [1.0, 2.0, 3.0]
    assert read.orientation == pytest.approx([0.0, 0.0, 0.6, 0.8])


@pytest.mark.parametrize(
    ("message", "field"),
    [
        (pose(frame="wrist"), "header.frame_id: expected world, got 'wrist'"),
        (pose(position=(1.0, np.nan, 3.0)), "pose.position: expected 3 finite numbers"),
        (pose(orientation=(0.0, 0.0, 0.0, 0.0)), "pose.orientation: expected a unit quaternion"),
        (pose(orientation=(0.0, 0.0, np.inf, 0.0)), "pose.orientation: expected 4 finite"),
    ],
)
def test_a_pose_that_cannot_be_used_is_refused_by_field(message, field):
    with pytest.raises(ValueError, match=field):
        read_pose(message)


@pytest.mark.parametrize(
    ("message", "field"),
    [
        (state(position=(1e-5,)), "position: expected 2 finite numbers"),
        (state(effort=(1.0, np.nan)), "effort: expected 2 finite numbers"),
        (state(name=("a", "a")), "name: expected channel names without duplicates"),
        (state(name=(), position=(), effort=()), "name: expected channel names"),
    ],
)
def test_a_state_that_cannot_be_used_is_refused_by_field(message, field):
    with pytest.raises(ValueError, match=field):
        read_air_state(message)


def test_air_is_read_by_channel():
    air = read_air_state(state())
    assert air.channels == ("a", "b")
    assert air.air_mass.tolist() == [1e-5, 2e-5]
    assert air.pressure.tolist() == [3e4, 4e4]


def test_a_force_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="wrench.force"):
        read_force(Fields(numbers=(np.nan, 0.0, 0.0, 1.0, 1.0, 1.0)))


def test_touching_is_every_other_side_of_the_object():
    message = contacts("index/object", "object/table", "thumb/object", "index/table")
    assert read_touching(message) == {"index", "table", "thumb"}


def test_deleted_markers_touch_nothing():
    assert read_touching(contacts("", "index/object", action=3)) == frozenset()


def test_a_contact_name_that_is_no_pair_is_refused():
    with pytest.raises(ValueError, match=r"markers\.ns: expected <body>/<body>, got 'index'"):
        read_touching(contacts("index"))


def status(name, level, message):
    return Fields(name=name, level=bytes([level]), message=message, values=[])


def report_of(*statuses, node="pneumaticbox"):
    return read_report(Fields(status=list(statuses)), node, 1.0)


def test_what_a_node_says_is_told_from_what_others_say():
    own = [status("pneumaticbox: sensors", 1, "no sample"), status("pneumaticbox", 0, "well")]
    others = [status("hand_sim: simulation", 2, "diverged"), status("pneumaticbox2: a", 2, "x")]
    report = report_of(*others, *own)
    assert (report.worst, report.fault, report.preparing) == ("no sample", "", False)
    assert report_of(*others) is None


def test_a_fault_is_an_error_or_a_driver_that_is_disabled():
    warned = status("pneumaticbox: sensors", 1, "no sample")
    vented = status("pneumaticbox: safety", 2, "vented until reset")
    disabled = status("pneumaticbox: safety", 1, "disabled: valves are closed")
    assert report_of(warned, vented).fault == "vented until reset"
    assert report_of(warned, disabled).fault == "disabled: valves are closed"
    assert report_of(warned, status("pneumaticbox: safety", 0, "in operation")).fault == ""


def test_a_fault_of_another_hand_is_none_of_this_one():
    vented = status("left/pneumaticbox: safety", 2, "vented until reset")
    assert report_of(vented, node="left/pneumaticbox").fault == "vented until reset"
    assert report_of(vented, node="right/pneumaticbox") is None
    assert report_of(vented) is None


def test_a_node_that_prepares_is_known_by_a_key():
    compiling = status("hand_sim: simulation", 1, "compiling")
    compiling.values = [Fields(key="preparing", value="yes")]
    report = report_of(compiling, node="hand_sim")
    assert (report.worst, report.fault, report.preparing) == ("compiling", "", True)


def test_a_feed_keeps_the_last_good_contents_and_why_a_message_was_refused():
    feed = Feed("scene/object_pose", "hand_sim", read_pose)
    feed.accept(pose(), 1.0, 100.0)
    feed.accept(pose(position=(np.nan, 0.0, 0.0)), 2.0, 101.0)
    assert feed.value.position.tolist() == [1.0, 2.0, 3.0]
    assert (feed.arrived, feed.refused) == (1.0, 1)
    assert feed.last_refusal.startswith("pose.position")


def test_a_feed_is_silent_only_when_both_scene_and_wall_time_went_on():
    feed = Feed("wrist/pose", "hand_sim", read_pose)
    assert feed.silent_for(0.0, 0.0, 0.5, 1.0)
    feed.accept(pose(), 1.0, 100.0)
    assert not feed.silent_for(9.0, 100.5, 0.5, 1.0)
    assert not feed.silent_for(1.2, 200.0, 0.5, 1.0)
    assert feed.silent_for(1.6, 101.1, 0.5, 1.0)


def test_what_is_quoted_of_a_message_is_short():
    feed = Feed("scene/object_pose", "hand_sim", read_pose)
    feed.accept(pose(frame="x" * 1_000_000), 1.0, 100.0)
    assert feed.refused == 1 and len(feed.last_refusal) == 200
    (name,) = read_touching(contacts(f"{'x' * 1_000_000}/object"))
    assert len(name) == 200
    vented = status("pneumaticbox: safety", 2, "x" * 1_000_000)
    assert len(report_of(vented).fault) == len(report_of(vented).worst) == 200


def stamped(x, at):
    message = pose(position=(x, 0.0, 0.0))
    message.header = Fields(stamp=Fields(sec=int(at), nanosec=round(at % 1 * 1e9)))
    return message


def followed(feed, messages, now):
    """Whether the feed has all of `now`, and the place that it then tells."""
    waiting = iter([*messages, None])
    done = feed.follow(lambda: next(waiting), now, 100.0)
    return done, None if feed.value is None else feed.value.position[0]


def test_a_feed_shows_the_state_of_a_tick_whatever_has_come_since():
    feed = Feed("wrist/pose", "hand_sim", read_pose)
    assert followed(feed, [stamped(1, 1.00)], 1.01) == (False, 1.0)
    assert followed(feed, [stamped(2, 1.01), stamped(3, 1.02)], 1.01) == (True, 2.0)
    assert followed(feed, [stamped(4, 1.03)], 1.02) == (True, 3.0)


def test_a_feed_by_another_clock_shows_what_came_last():
    feed = Feed("wrist/pose", "bridge", read_pose)
    assert followed(feed, [stamped(1, 1.7e9), stamped(2, 1.7e9)], 1.0) == (True, 2.0)
    assert followed(feed, [stamped(3, 0.0)], 1.0) == (False, 3.0)


def test_the_drivers_control_modes_are_read_of_its_own_report():
    told = status("pneumaticbox: commands", 0, "OK")
    told.values = [Fields(key="control modes", value="mass, pressure")]
    array = Fields(status=[status("left/pneumaticbox: commands", 0, "OK"), told])
    assert read_modes(array, "pneumaticbox") == ("mass", "pressure")
    assert read_modes(array, "left/pneumaticbox") == read_modes(array, "right/pneumaticbox") == ()
