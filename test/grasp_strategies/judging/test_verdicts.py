"""Verdicts on whole grasps whose course is made up, from the table to the end of the hold."""

import math

import grasp_courses as course
import numpy as np
import pytest

from grasp_strategies.judging.judge import GraspJudge
from grasp_strategies.strategy import Success

END = 9.9  # [s] later than any phase


def verdict(moments, first=course.FIRST, **criteria):
    judge = GraspJudge(Success(**criteria), course.HAND, first)
    for moment in moments:
        judge.watch(moment.observation, holding=moment.phase == "hold")
    return judge.result()


def in_hold(begin, end, change):
    return course.changed(course.gripped(), "hold", begin, end, change)


def swung(seen, elapsed):
    """12 mm to the side and back within 0.4 s."""
    return course.shifted(y=0.012 * math.sin(math.pi * elapsed / 0.4))(seen, elapsed)


def sliding(seen, elapsed):
    """11 mm within 1.1 s."""
    return course.shifted(x=0.01 * elapsed)(seen, elapsed)


NEVER_LIFTED = course.after(course.gripped(), "lift", 0.0, course.lying())
LOW = course.after(course.gripped(), "lift", 0.5, course.lying(height=0.10, touching=course.GRIP))
HANGING_DOWN = course.after(course.gripped(), "lift", 0.0, course.touched_by("table"))
COURSES = {
    "held": (course.gripped(), "gripped", "lifted 140 mm, held 1.09 s"),
    "slipped 12 mm and came back": (in_hold(0.3, 0.7, swung), "lost", "slipped by 12.0 mm"),
    "slid slowly to the end": (in_hold(0.0, END, sliding), "lost", "slipped by 10.9 mm"),
    "slipped before the hold alone": (
        course.changed(course.gripped(), "lift", 0.2, 0.6, course.shifted(0.03)),
        "gripped",
        "slip 0.00 mm",
    ),
    "settled in the lift, then held": (
        course.after(course.gripped(), "lift", 0.8, course.shifted(0.009, 0.009)),
        "gripped",
        "slip 0.00 mm",
    ),
    "touched by the table for one step": (
        in_hold(0.5, 0.5, course.touched_by("table")),
        "lost",
        "table touched",
    ),
    "touched for one step before the second that counts": (
        in_hold(0.05, 0.05, course.touched_by("table")),
        "gripped",
        "held 1.04 s",
    ),
    "dropped in the hold": (
        course.after(course.gripped(), "hold", 0.5, course.falling),
        "lost",
        "nothing touched",
    ),
    "dropped in the lift": (
        course.after(course.gripped(), "lift", 0.6, course.falling),
        "lost",
        "table touched",
    ),
    "dropped and gripped again too late": (
        in_hold(0.2, 0.3, course.lying()),
        "lost",
        "table touched",
    ),
    "turned by 25 deg": (in_hold(0.5, END, course.turned(25.0)), "lost", "turned by 25.0 deg"),
    "turned by 25 deg and back": (
        in_hold(0.5, 0.5, course.turned(25.0, "z")),
        "lost",
        "turned by 25.0 deg",
    ),
    "turned by 15 deg": (in_hold(0.5, END, course.turned(15.0)), "gripped", "turn 15.0 deg"),
    "never lifted": (NEVER_LIFTED, "none", "table touched"),
    "lifted by half": (LOW, "lost", "only 68 mm up"),
    "lifted but with the table touching": (HANGING_DOWN, "none", "table touched"),
    "diverged in the hold": (in_hold(0.5, END, course.nowhere), "lost", "not finite"),
    "diverged in the lift": (
        course.after(course.gripped(), "lift", 0.5, course.nowhere),
        "lost",
        "not finite",
    ),
}


@pytest.mark.parametrize("name", COURSES)
def test_the_verdict_on_a_grasp_that_was(name):
    moments, outcome, reason = COURSES[name]
    result = verdict(moments)
    assert result.outcome == outcome
    assert reason in result.reason


def test_slip_and_turn_are_the_greatest_of_the_hold_not_the_last():
    assert verdict(in_hold(0.3, 0.7, swung)).slip == pytest.approx(0.012, rel=1e-3)
    result = verdict(in_hold(0.5, 0.6, course.turned(12.0, "y")))
    assert math.degrees(result.turn) == pytest.approx(12.0)
    assert result.gripped


def test_a_hand_that_turns_with_its_object_has_not_turned_it():
    assert verdict(course.gripped()).turn == pytest.approx(0.0, abs=1e-7)


def test_the_turn_may_be_as_large_as_the_strategy_allows():
    moments = in_hold(0.5, END, course.turned(15.0))
    assert verdict(moments, max_turn=math.radians(15.1)).gripped
    assert not verdict(moments, max_turn=math.radians(14.9)).gripped


def test_a_break_of_the_hold_does_not_forgive_a_slip():
    moments = in_hold(0.06, END, course.shifted(z=0.011))
    broken = course.changed(moments, "hold", 0.05, 0.05, course.touched_by("table"))
    result = verdict(broken)
    assert result.hold_time > 1.0 and result.outcome == "lost"
    assert "slipped by 11.0 mm" in result.reason


def test_the_judge_tells_since_when_the_hold_has_a_flaw():
    judge = GraspJudge(Success(), course.HAND, course.FIRST)
    told = []
    for moment in in_hold(0.5, 0.6, course.touched_by("table")):
        judge.watch(moment.observation, holding=moment.phase == "hold")
        told.append((judge.was_held, judge.flaw_time))
    assert told[0] == (False, pytest.approx(0.01))
    assert told[-1] == (True, pytest.approx(2.8))


def test_poses_that_were_no_number_at_the_start_are_no_grasp():
    assert verdict(course.gripped(), course.nowhere(course.FIRST, 0.0)).outcome == "none"


def test_where_the_object_was_in_the_hand_and_what_held_it_is_told():
    moments = course.gripped()
    result = verdict(moments)
    last = moments[-1].observation
    assert result.pose_in_hand[:3] == pytest.approx(last.object_in_wrist)
    assert np.linalg.norm(result.pose_in_hand[3:]) == pytest.approx(1.0)
    assert result.touching == ("index", "thumb")
    assert result.summary()["touching"] == "index, thumb"
    assert verdict(NEVER_LIFTED).pose_in_hand == verdict(NEVER_LIFTED).touching == ()


def test_what_was_in_the_hand_is_told_of_the_last_moment_that_it_was_held():
    result = verdict(course.after(course.gripped(), "hold", 0.5, course.falling))
    held = verdict(course.gripped())
    assert result.pose_in_hand == pytest.approx(held.pose_in_hand, abs=1e-3)
    assert result.touching == held.touching


def test_what_gave_way_in_the_lift_is_told_beside_the_verdict():
    moments = course.changed(course.gripped(), "lift", 0.4, 0.6, course.shifted(0.03))
    result = verdict(course.changed(moments, "lift", 0.7, 0.7, course.turned(30.0)))
    assert result.gripped and result.slip == pytest.approx(0.0, abs=1e-9)
    assert result.lift_slip == pytest.approx(0.03)
    assert math.degrees(result.lift_turn) == pytest.approx(30.0)


def test_the_lift_begins_when_the_object_leaves_the_ground_for_the_last_time():
    moments = course.changed(course.gripped(), "lift", 0.2, 0.3, course.shifted(0.03))
    back = course.changed(moments, "lift", 0.31, 0.31, course.touched_by("table"))
    assert verdict(back).lift_slip == pytest.approx(0.0, abs=1e-9)
    assert math.isnan(verdict(NEVER_LIFTED).lift_slip)
