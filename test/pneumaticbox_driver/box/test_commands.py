"""Commands: what is refused, by which field, and how setpoints follow what is taken."""

import math

import numpy as np
import pytest

from pneumaticbox_driver.box.commands import CommandRules, Setpoints, TrajectoryPoint

RULES = CommandRules(("a", "b", "c"), ("mass", "mass", "mass"))


def point(time, *positions):
    return TrajectoryPoint(time, positions)


@pytest.mark.parametrize(
    ("names", "points", "stamp", "expected"),
    [
        ([], [point(0, 1)], 0, "joint_names: expected channels out of ['a', 'b', 'c'], got none"),
        (["a", "z"], [point(0, 1, 1)], 0, "expected channels out of ['a', 'b', 'c'], got 'z'"),
        (["a", "a"], [point(0, 1, 1)], 0, "joint_names: expected each channel once"),
        (["a"], [], 0, "points: expected at least one, got none"),
        (["a", "b"], [point(0, 1)], 0, "points[0].positions: expected 2 values, got 1"),
        (["a"], [point(0, 1), point(1)], 0, "points[1].positions: expected 1 values, got 0"),
        (
            ["a", "b"],
            [point(0, 1, math.nan)],
            0,
            "points[0].positions[1]: expected a finite number, got nan",
        ),
        (["a"], [point(0, math.inf)], 0, "points[0].positions[0]: expected a finite number"),
        (["a"], [point(-0.1, 1)], 0, "points[0].time_from_start: expected 0 s or later, got -0.1"),
        (
            ["a"],
            [point(1, 1), point(1, 2)],
            0,
            "points[1].time_from_start: expected more than 1, got 1",
        ),
        (["a"], [point(math.nan, 1)], 0, "points[0].time_from_start: expected 0 s or later"),
        (["a"], [point(0, 1)], -1.0, "header.stamp: expected 0 s or later, got -1.0"),
    ],
)
def test_a_command_that_cannot_be_used_is_refused_by_its_field(names, points, stamp, expected):
    with pytest.raises(ValueError) as error:
        RULES.check(names, points, stamp)
    assert expected in str(error.value)


def test_each_mode_reads_its_own_field():
    rules = CommandRules(("a", "b"), ("mass_flow", "pressure"))
    given = TrajectoryPoint(0.0, velocities=(0.0, 1e-5), effort=(2e4, 0.0))
    command = rules.check(["b", "a"], [given])
    assert command.channels == (1, 0)
    np.testing.assert_array_equal(command.values, [[2e4, 1e-5]])
    with pytest.raises(ValueError, match=r"points\[0\].effort: expected 1 values, got 0"):
        rules.check(["b"], [TrajectoryPoint(0.0, positions=(1.0,))])


def follow(setpoints, times):
    return [setpoints.at(t).tolist() for t in times]


def taken(setpoints, now, names, *points, stamp=0.0):
    setpoints.take(RULES.check(names, points, stamp), now)


def test_before_any_command_there_is_no_setpoint():
    assert np.isnan(Setpoints(3).at(1.0)).all()


def test_a_first_point_at_time_zero_is_a_step():
    setpoints = Setpoints(3)
    taken(setpoints, 2.0, ["b"], point(0, 7))
    assert setpoints.at(2.0)[1] == 7
    assert np.isnan(setpoints.at(2.0)[[0, 2]]).all()


def test_setpoints_are_linear_between_points_and_held_after_the_last():
    setpoints = Setpoints(3)
    taken(setpoints, 0.5, ["a"], point(0, 1))
    taken(setpoints, 1.0, ["a"], point(1, 3), point(2, 0))
    values = [row[0] for row in follow(setpoints, [1.0, 1.25, 2.0, 2.5, 3.0, 9.0])]
    assert values == pytest.approx([1, 1.5, 3, 1.5, 0, 0])


def test_a_stamp_in_the_future_schedules_and_the_old_plan_goes_on_until_then():
    setpoints = Setpoints(3)
    taken(setpoints, 0.0, ["a"], point(0, 0), point(10, 10))
    taken(setpoints, 1.0, ["a"], point(0, 100), stamp=5.0)
    values = [row[0] for row in follow(setpoints, [1.0, 3.0, 4.99, 5.0, 8.0])]
    assert values == pytest.approx([1, 3, 4.99, 100, 100])


def test_a_later_command_cuts_what_was_planned_after_its_start_and_only_for_its_channels():
    setpoints = Setpoints(3)
    taken(setpoints, 0.0, ["a", "b"], point(0, 0, 0), point(4, 4, 4), point(8, 0, 0))
    setpoints.at(1.0)
    taken(setpoints, 1.0, ["a"], point(1, 3))
    values = follow(setpoints, [1.5, 2.0, 4.0, 6.0])
    assert [row[0] for row in values] == pytest.approx([2, 3, 3, 3])
    assert [row[1] for row in values] == pytest.approx([1.5, 2, 4, 2])


def test_the_first_command_with_a_later_point_waits_for_it():
    setpoints = Setpoints(3)
    taken(setpoints, 0.0, ["a"], point(1, 5))
    assert math.isnan(setpoints.at(0.5)[0])
    assert setpoints.at(1.0)[0] == 5


def test_a_stamp_in_the_past_joins_the_trajectory_where_it_is():
    setpoints = Setpoints(3)
    taken(setpoints, 10.0, ["a"], point(0, 0), point(4, 4), stamp=8.0)
    assert setpoints.at(10.0)[0] == pytest.approx(2)


def test_many_commands_leave_no_plan_behind():
    setpoints = Setpoints(3)
    for k in range(2000):
        taken(setpoints, 0.001 * k, ["a"], point(0, k), point(5, k))
    assert setpoints.at(2.0)[0] == pytest.approx(1999)
    assert len(setpoints._curves[0].times) < 20


def test_hold_drops_everything():
    setpoints = Setpoints(3)
    taken(setpoints, 0.0, ["a"], point(0, 1), point(5, 2))
    setpoints.hold()
    assert np.isnan(setpoints.at(1.0)).all()
    assert math.isnan(setpoints.last_time)
