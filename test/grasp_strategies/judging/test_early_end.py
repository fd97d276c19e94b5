"""A trial that ends early has the verdict of the whole one."""

import math

import grasp_courses as course
import numpy as np
import pytest

from grasp_strategies.judging.early_end import EarlyEnd, EmptyHandPath
from grasp_strategies.judging.failure import GraspWatch
from softhand_trials.trials import Placement, StartedScene, TrialSettings

STRATEGY = """
format: softhand-strategy/1
name: course
description: as the course
hand: rbo_hand_2
phases:
  - name: approach
    wrist: {frame: environment, position: [-0.03, 0, 0.12]}
    duration: 0.5
  - name: close
    air_mass: {a: 1.0e-5}
    air_ramp: 0.5
  - name: lift
    wrist: {frame: wrist_level, position: [0, 0, 0.14]}
    duration: 1.0
  - name: steady
    duration: 0.3
  - name: hold
    duration: 1.1
"""


def around(seen, half=0.04):
    """Box (2, 3) [m] around the object."""
    return np.array([seen.object_position - half, seen.object_position + half])


def hand(seen):
    """Box (1, 2, 3) [m] around a hand whose fingers reach 0.12 m down."""
    return np.array([[seen.wrist_position - [0.1, 0.1, 0.12], seen.wrist_position + 0.1]])


def boxes(watch):
    return lambda: around(watch.last), lambda: hand(watch.last)


def empty_course():
    """The hand of the course."""
    found = EmptyHandPath()
    for moment in course.gripped():
        found.keep(moment.phase, lambda seen=moment.observation: hand(seen))
    return found


def swung_back(seen, elapsed):
    return course.shifted(y=0.012 * math.sin(math.pi * elapsed / 0.4))(seen, elapsed)


def rolling(seen, elapsed):
    return course.lying(x=0.8 * elapsed)(seen, elapsed)


GRIPPED = course.gripped()
COURSE = empty_course()
COURSES = {  # course, phase in which it may end, None for the whole
    "held": (GRIPPED, None),
    "missed": (course.after(GRIPPED, "close", 0.0, course.lying()), "lift"),
    "slipped in the lift": (course.after(GRIPPED, "lift", 0.5, course.lying()), "lift"),
    "left and hooked again": (
        course.changed(GRIPPED, "lift", 0.0, 0.3, course.lying()),
        None,
    ),
    "rolled away": (course.after(GRIPPED, "approach", 0.2, rolling), "approach"),
    "off the table": (course.after(GRIPPED, "close", 0.2, course.lying(height=-0.3)), "close"),
    "slipped in the hold": (course.changed(GRIPPED, "hold", 0.1, 0.5, swung_back), "hold"),
    "touched once in the hold": (
        course.changed(GRIPPED, "hold", 0.5, 0.5, course.touched_by("table")),
        "hold",
    ),
    "touched before the second that counts": (
        course.changed(GRIPPED, "hold", 0.05, 0.05, course.touched_by("table")),
        None,
    ),
    "too low": (course.after(GRIPPED, "lift", 0.5, course.lifted(0.06)), "hold"),
}


@pytest.mark.parametrize("name", COURSES)
def test_the_verdict_at_the_early_end_is_that_of_the_whole_course(name, make_strategy):
    moments, expected = COURSES[name]
    strategy = make_strategy(text=STRATEGY)
    watch = GraspWatch(strategy, course.HAND, course.FIRST)
    early, ended, verdict = EarlyEnd(strategy, COURSE, *boxes(watch)), None, None
    for moment in moments:
        watch.watch(moment.observation, moment.phase)
        if ended is None and early(watch):
            ended, verdict = moment.phase, watch.result()
    assert ended == expected
    if ended is not None:
        assert verdict.outcome == watch.result().outcome != "gripped"
        assert verdict.duration < watch.result().duration - 0.2


def test_the_empty_hand_is_far_from_what_it_has_passed():
    passed = EmptyHandPath()
    passed.keep("sweep", lambda: np.array([[[0.0, 0.0, 0.0], [0.1, 0.1, 0.1]]]))
    passed.keep("lift", lambda: np.array([[[0.0, 0.0, 0.3], [0.1, 0.1, 0.4]]]))
    box = np.array([[0.13, 0.0, 0.0], [0.2, 0.1, 0.26]])
    assert passed.gap("sweep", box) == pytest.approx(0.03)
    assert passed.gap("lift", box) == pytest.approx(0.05)
    assert passed.gap("elsewhere", box) == 0.0


def test_a_strategy_that_looks_at_the_object_and_a_wall_have_no_course_without_it():
    """The one goes where the object is, the other sends back what rolls away."""
    looks = StartedScene(TrialSettings("rbo_hand_1_from_above", segments=2))
    walled = StartedScene(TrialSettings("rbo_hand_1_push", scene="wall", segments=2))
    assert looks.empty_course is None and walled.empty_course is None


def test_what_happens_after_the_hold_decides_nothing(make_strategy):
    strategy = make_strategy(text=STRATEGY + "  - name: lower\n    duration: 1.0\n")
    watch = GraspWatch(strategy, course.HAND, course.FIRST)
    early = EarlyEnd(strategy, COURSE, *boxes(watch))
    for moment in GRIPPED:
        watch.watch(moment.observation, moment.phase)
        assert not early(watch)
    watch.watch(GRIPPED[-1].observation, "lower")
    assert early(watch) and watch.result().gripped


def test_short_and_whole_trials_agree():
    usual = {"strategy": "rbo_hand_1_push", "segments": 3, "step": 0.01, "air_scale": 0.3}
    whole, short = (
        StartedScene(TrialSettings(**usual, object_rpy=(0, 0, 0), early_end=early))
        for early in (False, True)
    )
    for place, saved in (((0.03, -0.03), 0.0), ((-0.2, 0.3), 1.0)):
        long, ended = whole.run(Placement(place)), short.run(Placement(place))
        assert ended.outcome == long.outcome
        assert ended.duration <= long.duration - saved
