"""Phase and cause of failures whose course is made up; and of runs that end early."""

import math
import threading

import grasp_courses as course
import pytest
from mock_scene import MockScene
from scipy.spatial.transform import Rotation

from grasp_strategies.judging.failure import (
    STAGE_AFTER_HOLD,
    STAGE_BEFORE_LIFT,
    STAGE_HOLD,
    STAGE_LIFT,
    GraspWatch,
    stages,
)
from grasp_strategies.scene import SceneError
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import load_strategy

END = 9.9  # [s] later than any phase
PLAN = """
format: softhand-strategy/1
name: plan
description: the phases of the made-up courses
hand: rbo_hand_2
phases:
  - {name: approach, wrist: {frame: object, position: [0, 0, 0.1]}, duration: 0.5}
  - {name: close, air_mass: {a: 1.0e-5}, air_ramp: 0.5}
  - {name: lift, wrist: {frame: wrist_level, position: [0, 0, 0.14]}, duration: 1.0}
  - {name: steady, duration: 0.3}
  - {name: hold, duration: 1.1}
  - {name: lower, wrist: {frame: wrist_level, position: [0, 0, -0.1]}, duration: 1, option: down}
"""


@pytest.fixture
def plan(write_strategy):
    return load_strategy(write_strategy(text=PLAN))


@pytest.fixture
def watched(plan):
    """What is said of a course after its last observation."""

    def watch(moments, first=course.FIRST):
        grasp = GraspWatch(plan, course.HAND, first)
        for moment in moments:
            grasp.watch(moment.observation, moment.phase)
        return grasp

    return watch


def lies(phase, begin=0.0, **state):
    """The object lies from a time in a phase on."""
    return course.after(course.gripped(), phase, begin, course.lying(**state))


def in_hold(begin, end, change):
    return course.changed(course.gripped(), "hold", begin, end, change)


def about_x(angle):
    return Rotation.from_euler("x", angle, degrees=True)


def rolling(seen, elapsed):
    """Rolls along y at 0.1 m/s from the moment on at which the hand pushes it, until 80 mm away."""
    way = min(0.08, 0.1 * elapsed)
    touching = course.TABLE | course.GRIP if elapsed < 0.1 else course.TABLE
    return course.lying(y=way, turn=about_x(-math.degrees(way / course.REST)), touching=touching)(
        seen, elapsed
    )


def with_lift(moments, **state):
    """The course that ends with the object lying from the lift on."""
    return course.after(moments, "lift", 0.0, course.lying(**state))


NOT_TOUCHED = lies("approach")
PUSHED = course.changed(
    lies("approach", 0.3, x=0.05),
    "approach",
    0.3,
    0.4,
    course.lying(x=0.05, touching=course.TABLE | course.GRIP),
)
TOPPLED = course.after(
    lies("close", 0.2, height=0.02, turn=about_x(90)),
    "close",
    0.4,
    course.lying(height=0.02, turn=about_x(90)),
)
LEANED = course.changed(
    course.gripped(),
    "close",
    0.1,
    0.4,
    course.lying(height=0.05, turn=about_x(60), touching=course.TABLE | course.GRIP),
)
OFF = course.after(course.gripped(), "close", 0.3, course.lying(height=-0.4, touching=()))
SLID_OUT = course.after(course.gripped(), "lift", 0.2, course.lying())
ONE_END_UP = course.after(course.gripped(), "lift", 0.0, course.touched_by("table"))
AGAINST_WALL = course.after(course.gripped(), "steady", 0.0, course.touched_by("wall"))
LIFTED_LOW = course.after(course.gripped(), "lift", 0.5, course.lifted(0.07))
LOW = course.after(course.gripped(), "lift", 0.5, course.lying(height=0.10, touching=course.GRIP))
FAILURES = {
    "nothing but table": (NOT_TOUCHED, "close", "missed"),
    "touched in passing": (
        course.changed(NOT_TOUCHED, "approach", 0.2, 0.3, course.touched_by("index")),
        "approach",
        "missed",
    ),
    "let go before the lift": (lies("close", 0.3, y=0.01), "close", "missed"),
    "pushed aside": (PUSHED, "approach", "pushed away"),
    "rolled": (course.after(course.gripped(), "close", 0.2, rolling), "close", "rolled away"),
    "toppled": (TOPPLED, "close", "tipped"),
    "leaned in the hand, then left": (with_lift(LEANED), "lift", "slipped in the lift"),
    "off the table": (OFF, "close", "fell off the table"),
    "slid out of the fingers": (SLID_OUT, "lift", "slipped in the lift"),
    "touched by the hand, left behind": (lies("lift"), "lift", "slipped in the lift"),
    "dropped from up": (
        course.after(course.gripped(), "steady", 0.1, course.falling),
        "steady",
        "slipped in the lift",
    ),
    "hangs down to the table": (ONE_END_UP, "hold", "touched the table"),
    "leans at the wall": (AGAINST_WALL, "hold", "touched the wall"),
    "sank in the hand while lifted": (LOW, "hold", "slipped in the lift"),
    "carried not high enough": (LIFTED_LOW, "hold", "lifted too low"),
    "dropped in the hold": (
        course.after(course.gripped(), "hold", 0.5, course.falling),
        "hold",
        "slipped in the hold",
    ),
    "dropped between two looks": (lies("hold", 0.5), "hold", "slipped in the hold"),
    "slid in the hold": (
        in_hold(0.5, END, course.shifted(x=0.011)),
        "hold",
        "slipped in the hold",
    ),
    "slid in the hold, then touched": (
        course.changed(
            in_hold(0.5, END, course.shifted(x=0.011)), "hold", 0.7, END, course.touched_by("table")
        ),
        "hold",
        "slipped in the hold",
    ),
    "turned in the hold": (in_hold(0.5, END, course.turned(25.0)), "hold", "turned in the hold"),
    "touched for one step": (
        in_hold(0.5, 0.5, course.touched_by("table")),
        "hold",
        "touched the table",
    ),
    "ended in mid-hold": (
        [m for m in course.gripped() if m.phase != "hold" or m.elapsed < 0.8],
        "hold",
        "held too short",
    ),
    "diverged in the lift": (
        course.after(course.gripped(), "lift", 0.5, course.nowhere),
        "lift",
        "diverged",
    ),
    "diverged in the hold": (in_hold(0.5, END, course.nowhere), "hold", "diverged"),
}


@pytest.mark.parametrize("name", FAILURES)
def test_phase_and_cause_of_an_object_that_was(watched, name):
    moments, phase, cause = FAILURES[name]
    grasp = watched(moments)
    assert grasp.failure()[:2] == (phase, cause)
    result = grasp.result()
    assert (result.phase, result.cause) == (phase, cause)
    assert not result.gripped
    assert result.reason == grasp.judge.result().reason


def test_a_grasp_that_succeeds_has_no_failure(watched):
    grasp = watched(course.gripped())
    assert grasp.failure() is None
    assert grasp.result().gripped
    assert grasp.result().phase == grasp.result().cause == ""


def test_an_object_that_is_gripped_again_in_the_lift_was_not_lost(watched):
    moments = course.changed(course.gripped(), "lift", 0.3, 0.4, course.lying())
    assert watched(moments).failure() is None


def test_what_happens_after_the_hold_does_not_change_the_failure(watched, plan):
    failed = watched(in_hold(0.5, END, course.shifted(x=0.011)))
    good = watched(course.gripped())
    for grasp in (failed, good):
        for moment in lies("approach"):
            grasp.watch(moment.observation, "lower")
    assert failed.failure()[:2] == ("hold", "slipped in the hold")
    assert good.failure() is None


def test_the_watch_can_be_asked_at_any_time(plan):
    grasp = GraspWatch(plan, course.HAND, course.FIRST)
    told = []
    for moment in SLID_OUT:
        grasp.watch(moment.observation, moment.phase)
        told.append((grasp.stage, grasp.carried, grasp.touched, grasp.failure().cause))
    assert told[0] == (STAGE_BEFORE_LIFT, False, False, "missed")
    assert (STAGE_LIFT, True, True, "hold not reached") in told
    assert told[-1] == (STAGE_HOLD, False, False, "slipped in the lift")
    assert grasp.way == pytest.approx(0.0) and not grasp.off_table
    assert grasp.last is SLID_OUT[-1].observation


MOMENTS = {  # [s] since the first observation; the plan: 0.5 s to close, 1.0 to lift, 2.3 to hold
    "nothing but table": 1.0,
    "touched in passing": 0.31,
    "rolled": 0.5 + 0.2 + 0.1,
    "toppled": 0.5 + 0.2,
    "off the table": 0.5 + 0.3,
    "slid out of the fingers": 1.0 + 0.2,
    "dropped from up": 2.0 + 0.1,
    "dropped in the hold": 2.3 + 0.5,
    "slid in the hold": 2.3 + 0.5,
    "slid in the hold, then touched": 2.3 + 0.5,
    "turned in the hold": 2.3 + 0.5,
    "diverged in the lift": 1.0 + 0.5,
}


@pytest.mark.parametrize("name", MOMENTS)
def test_a_failure_has_its_time(watched, name):
    result = watched(FAILURES[name][0]).result()
    assert result.failed_at == pytest.approx(MOMENTS[name], abs=2.1 * course.STEP)


def test_a_success_has_no_time_of_failure_and_an_early_end_its_own(watched):
    result = watched(course.gripped()).result()
    assert math.isnan(result.failed_at)
    assert result.stopped("no pose").failed_at is result.failed_at
    ended = result.stopped("vented", phase="lower", cause="aborted")
    assert (ended.phase, ended.cause, ended.failed_at) == ("lower", "aborted", result.duration)


def test_what_the_hand_let_go_last_is_what_it_missed(watched):
    moments = course.changed(NOT_TOUCHED, "approach", 0.2, END, course.touched_by("index"))
    moments = course.changed(moments, "close", 0.0, 0.1, course.touched_by("index"))
    assert watched(moments).failure() == ("close", "missed", pytest.approx(0.61))


def test_an_object_that_the_hand_brushes_as_it_goes_up_was_not_in_it(watched):
    moments = course.changed(NOT_TOUCHED, "lift", 0.2, 0.3, course.touched_by("index"))
    assert watched(moments).failure()[:2] == ("lift", "missed")


@pytest.mark.parametrize(("height", "off"), [(-0.019, False), (-0.021, True)])
def test_off_the_table_is_an_object_whose_centre_is_20_mm_below_its_surface(watched, height, off):
    grasp = watched(lies("close", 0.2, height=height, touching=()))
    assert grasp.off_table == off
    assert grasp.failure().cause == ("fell off the table" if off else "missed")


@pytest.mark.parametrize(("way", "cause"), [(0.0199, "missed"), (0.0201, "pushed away")])
def test_an_object_has_left_its_place_beyond_20_mm(watched, way, cause):
    assert watched(lies("approach", 0.2, x=way * 0.6, y=-way * 0.8)).failure().cause == cause


@pytest.mark.parametrize(
    ("angle", "height", "cause"),
    [(44.9, 0.02, "missed"), (45.1, 0.02, "tipped"), (-46, 0.045, "tipped"), (46, 0.03, "missed")],
)
def test_what_has_tipped_leans_by_45_deg_and_has_its_centre_at_another_height(
    watched, angle, height, cause
):
    moments = lies("approach", 0.2, turn=about_x(angle), height=height)
    assert watched(moments).failure()[:2] == ("close" if cause == "missed" else "approach", cause)


def test_an_object_that_lay_turned_from_the_start_has_not_tipped(watched):
    turn = about_x(90)
    first = course.lying(turn=turn)(course.FIRST, 0.0)
    moments = course.after(course.gripped(), "approach", 0.0, course.lying(turn=turn, height=0.02))
    assert watched(moments, first).failure()[:2] == ("close", "missed")


@pytest.mark.parametrize(("angle", "cause"), [(44.0, "missed"), (46.0, "tipped")])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_an_object_that_lay_turned_about_the_vertical_leans_by_as_much_about_any_axis(
    watched, angle, cause, axis
):
    before = Rotation.from_euler("z", 100.0, degrees=True)
    turn = Rotation.from_euler(axis, angle, degrees=True) * before
    first = course.lying(turn=before)(course.FIRST, 0.0)
    moments = lies("approach", 0.2, turn=turn, height=0.02)
    assert watched(moments, first).failure().cause == cause


def test_an_object_below_the_table_that_the_hand_holds_has_not_fallen(watched):
    held = course.lying(height=-0.03, touching=course.GRIP)
    grasp = watched(course.after(course.gripped(), "close", 0.3, held))
    assert not grasp.off_table
    assert grasp.failure().cause == "slipped in the lift"


# ---------------------------------------------------------------- stages of a strategy
def test_the_lift_of_the_shipped_strategies_is_where_the_wrist_goes_up():
    for name in ("surface_constrained", "rbo_hand_1_from_above"):
        found = stages(load_strategy(name))
        assert [phase for phase, stage in found.items() if stage == STAGE_LIFT] == [
            "lift",
            "steady",
        ]
        assert (
            found["settle"] == STAGE_BEFORE_LIFT
            and found["hold"] == STAGE_HOLD
            and found["release"] == STAGE_AFTER_HOLD
        )


def test_a_lift_in_steps_begins_with_the_first(write_strategy):
    steps = (
        "  - {name: unstick, wrist: {frame: wrist_level, position: [0, 0, 0.01]}, duration: 1}\n"
        "  - {name: wait, duration: 0.1}\n  - {name: lift"
    )
    found = stages(load_strategy(write_strategy(("  - {name: lift", steps), text=PLAN)))
    assert [name for name, stage in found.items() if stage == STAGE_LIFT] == [
        "unstick",
        "wait",
        "lift",
        "steady",
    ]


def test_going_sideways_is_no_lift(write_strategy):
    aside = (
        "  - {name: aside, wrist: {frame: wrist_level, position: [0.1, 0, 0]}, duration: 1}\n"
        "  - {name: lift"
    )
    found = stages(load_strategy(write_strategy(("  - {name: lift", aside), text=PLAN)))
    assert found["aside"] == STAGE_BEFORE_LIFT and found["lift"] == STAGE_LIFT


def test_a_lift_that_turns_the_wrist_begins_with_the_last_motion(write_strategy):
    turning = ("[0, 0, 0.14]}", "[0, 0, 0.14], rpy: [0, 1, 0]}")
    found = stages(load_strategy(write_strategy(turning, text=PLAN)))
    assert [name for name, stage in found.items() if stage == STAGE_LIFT] == ["lift", "steady"]
    back = (
        "  - {name: close",
        "  - {name: back, wrist: {frame: wrist_level, position: "
        "[0, 0, 0], rpy: [0, 0, 0]}, duration: 1}\n  - {name: close",
    )
    found = stages(load_strategy(write_strategy(turning, back, text=PLAN)))
    assert [name for name, stage in found.items() if stage == STAGE_LIFT] == ["lift", "steady"]


def test_a_strategy_that_moves_nothing_has_no_lift(write_strategy):
    text = PLAN[: PLAN.index("  - {name: approach")] + "  - {name: hold, duration: 1.0}\n"
    assert stages(load_strategy(write_strategy(text=text))) == {"hold": STAGE_HOLD}


# ---------------------------------------------------------------- runs of a sequencer
def test_a_run_tells_phase_and_cause_of_its_failure(make_strategy):
    result = Sequencer(MockScene(drop_at=1.5), make_strategy()).run()
    assert (result.phase, result.cause) == ("lift", "slipped in the lift")
    assert result.summary()["cause"] == "slipped in the lift"
    result = Sequencer(MockScene(also_touching={"wall"}), make_strategy()).run()
    assert (result.phase, result.cause) == ("hold", "touched the wall")
    result = Sequencer(MockScene(), make_strategy()).run()
    assert (result.phase, result.cause) == ("", "")


def test_a_phase_that_took_too_long_is_named_with_its_cause(make_strategy):
    slow = make_strategy(("time_out: 2.0", "time_out: 0.5"))
    result = Sequencer(MockScene(air_rate=1e-5), slow).run()
    assert (result.phase, result.cause) == ("close", "timed out")


def test_an_abort_is_a_cause(make_strategy):
    scene, abort = MockScene(), threading.Event()
    scene.on_step = lambda: scene.time > 0.7 and abort.set()
    result = Sequencer(scene, make_strategy(), abort=abort).run()
    assert (result.phase, result.cause) == ("close", "aborted")


@pytest.mark.parametrize(
    ("sentence", "cause"),
    [
        ("the simulation diverged: the object is at nan", "diverged"),
        ("no pose for 2 s", "scene failed"),
    ],
)
def test_a_scene_that_cannot_go_on_is_a_cause(make_strategy, sentence, cause):
    def fail():
        if scene.time > 1.0:
            raise SceneError(sentence)

    scene = MockScene()
    scene.on_step = fail
    result = Sequencer(scene, make_strategy()).run()
    assert (result.phase, result.cause) == ("lift", cause)


def test_a_scene_that_was_never_seen_has_no_phase(make_strategy):
    class Dark(MockScene):
        def observe(self):
            raise SceneError("no pose of the object")

    result = Sequencer(Dark(), make_strategy()).run()
    assert (result.phase, result.cause) == ("", "not begun")
