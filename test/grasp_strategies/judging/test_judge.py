"""Verdicts on made-up observations of an object: what was seen is stated, and so is the answer."""

import math

import numpy as np
import pytest

from grasp_strategies.judging.judge import GraspJudge, GraspResult
from grasp_strategies.scene import Observation
from grasp_strategies.strategy import Success

HAND = frozenset({"thumb", "index"})
REST = 2**-5  # height of the object at the start [m], without rounding
UP = REST + 0.12
HELD, FALLEN, CAUGHT = frozenset({"thumb"}), frozenset({"table"}), HAND | {"wall"}


def seen(time, height=UP, touching=HELD, drift=0.0):
    """The object at a height [m], `drift` [m] from where the wrist took it, touched by bodies."""
    wrist = np.array([0.0, 0.2, height + 0.0625])
    return Observation(
        time,
        wrist,
        np.array([0.0, 0.0, 0.0, 1.0]),
        np.zeros(3),
        wrist + [drift, 0.0, -0.0625],
        np.array([0.0, 0.0, 0.0, 1.0]),
        np.zeros(2),
        np.zeros(2),
        touching,
    )


def judged(*observations, success=None, before=()):
    """The verdict on a hold of these observations, after others outside of the hold phase."""
    judge = GraspJudge(success or Success(), HAND, seen(10.0, REST, FALLEN))
    for observation in before:
        judge.watch(observation, holding=False)
    for observation in observations:
        judge.watch(observation, holding=True)
    return judge.result()


def hold(start, stop, step=0.1, **state):
    """Observations that are all alike, from start to stop [s]."""
    count = round((stop - start) / step) + 1
    return [seen(time, **state) for time in np.linspace(start, stop, count)]


def test_an_object_held_as_asked_is_gripped_and_the_figures_are_those_of_what_was_seen():
    result = judged(*hold(12.0, 13.1, drift=0.002))
    assert result.outcome == "gripped" and result.completed and result.safe
    assert result.lift_height == pytest.approx(0.12)
    assert result.hold_time == pytest.approx(1.1)
    assert result.duration == pytest.approx(3.1)
    assert result.slip == pytest.approx(0.0, abs=1e-12)  # where the hold began is no slip
    assert (
        result.reason == "lifted 120 mm, held 1.10 s by the hand alone, slip 0.00 mm, turn 0.0 deg"
    )


def test_the_slip_is_the_greatest_of_the_hold_though_the_object_comes_back():
    drifts = [0.0, 0.004, 0.012, 0.005, 0.0]
    result = judged(*(seen(12.0 + 0.3 * i, drift=drift) for i, drift in enumerate(drifts)))
    assert result.slip == pytest.approx(0.012)
    assert result.outcome == "lost"
    assert result.reason == "the object slipped by 12.0 mm in the hold, more than 10.0 mm"


@pytest.mark.parametrize(("slip", "outcome"), [(0.0099, "gripped"), (0.0101, "lost")])
def test_the_slip_may_be_as_large_as_the_strategy_allows(slip, outcome):
    assert judged(seen(12.0), seen(13.0, drift=slip)).outcome == outcome


def test_a_slip_of_exactly_the_limit_is_allowed():
    result = judged(seen(12.0), seen(13.0, drift=0.25), success=Success(max_slip=0.25))
    assert result.slip == 0.25 and result.gripped


@pytest.mark.parametrize(
    ("spoiled", "reason"),
    [
        ({"touching": CAUGHT}, "wall touched the object in the hold"),
        ({"touching": frozenset()}, "nothing touched the object in the hold"),
        ({"height": REST + 0.05}, "the object was only 50 mm up in the hold"),
        ({"height": REST, "touching": FALLEN}, "table touched the object in the hold"),
    ],
)
def test_a_hold_that_is_interrupted_counts_anew_afterwards(spoiled, reason):
    result = judged(*hold(12.0, 12.6), seen(12.7, **spoiled), *hold(12.8, 13.5))
    assert result.outcome == "lost"
    assert result.hold_time == pytest.approx(0.7)  # the longer part, not their sum
    assert result.reason == reason


@pytest.mark.parametrize("state", [{"touching": CAUGHT}, {"height": REST, "touching": FALLEN}])
def test_time_in_which_the_object_is_touched_or_dropped_is_no_hold(state):
    result = judged(*hold(12.0, 12.4), *hold(12.5, 14.0, **state))
    assert result.hold_time == pytest.approx(0.4)
    assert result.outcome == "lost"


def test_the_first_flaw_of_the_hold_is_the_reason():
    result = judged(seen(12.0), seen(12.1, touching=CAUGHT), seen(12.2, REST, FALLEN))
    assert result.reason == "wall touched the object in the hold"


def test_all_that_touches_beside_the_hand_is_named():
    result = judged(seen(12.0, touching=HAND | {"wall", "table"}))
    assert result.reason == "table, wall touched the object in the hold"


def test_an_object_that_drops_after_it_was_held_long_enough_was_gripped():
    result = judged(*hold(12.0, 13.0), *hold(13.1, 14.0, height=REST, touching=FALLEN))
    assert result.outcome == "gripped"
    assert result.hold_time == pytest.approx(1.0)


def test_what_comes_between_two_holds_ends_the_first():
    judge = GraspJudge(Success(), HAND, seen(10.0, REST, FALLEN))
    for time, holding in ((12.0, True), (12.6, True), (12.7, False), (12.8, True), (13.4, True)):
        judge.watch(seen(time), holding)
    assert judge.result().hold_time == pytest.approx(0.6)
    assert judge.result().reason == "held only 0.60 s of 1.00 s"


@pytest.mark.parametrize(("held", "outcome"), [(0.999, "lost"), (1.0, "gripped")])
def test_a_hold_lasts_as_long_as_the_strategy_asks(held, outcome):
    assert judged(seen(12.0), seen(12.0 + held)).outcome == outcome


@pytest.mark.parametrize(("rise", "outcome"), [(0.0999, "lost"), (0.1001, "gripped")])
def test_a_hold_is_as_high_as_the_strategy_asks(rise, outcome):
    height = REST + rise
    assert judged(seen(12.0, height), seen(13.0, height)).outcome == outcome


def test_a_hold_at_exactly_the_height_asked_for_counts():
    asked = Success(lift_height=0.125)
    assert judged(seen(12.0, REST + 0.125), seen(13.0, REST + 0.125), success=asked).gripped


@pytest.mark.parametrize(
    ("rise", "touching", "outcome"),
    [
        (0.0101, HELD, "lost"),
        (0.0099, HELD, "none"),
        (0.0101, CAUGHT, "none"),
        (0.0101, frozenset(), "none"),
    ],
)
def test_an_object_is_lost_if_the_hand_alone_had_it_up_before(rise, touching, outcome):
    result = judged(before=[seen(11.0, REST + rise, touching), seen(11.5, REST, FALLEN)])
    assert result.outcome == outcome
    assert result.lift_height == pytest.approx(rise)
    assert result.hold_time == 0.0 and math.isnan(result.slip)
    assert result.reason == "the hold was not reached"


def test_an_object_that_never_rises_has_no_lift():
    assert judged(before=[seen(11.0, REST - 0.02, FALLEN)]).lift_height == 0.0


def test_the_slip_counts_from_where_the_first_hold_began():
    result = judged(
        seen(12.0, drift=0.001),
        seen(12.1, touching=CAUGHT, drift=0.05),
        *hold(12.2, 13.3, drift=0.008),
    )
    assert result.slip == pytest.approx(0.007)
    assert result.outcome == "gripped"


def test_a_run_that_was_stopped_keeps_what_was_seen_and_tells_why_it_ended():
    result = judged(*hold(12.0, 12.5)).stopped("aborted", safe=False)
    assert (result.outcome, result.reason) == ("lost", "aborted")
    assert not result.completed and not result.safe
    assert result.hold_time == pytest.approx(0.5)
    assert judged().stopped("aborted").safe


def test_a_strategy_that_never_saw_the_scene_took_no_time_and_got_nothing():
    result = GraspResult.not_begun("no simulator")
    assert (result.outcome, result.reason) == ("none", "no simulator")
    assert (result.lift_height, result.hold_time, result.duration) == (0.0, 0.0, 0.0)
    assert not result.completed and result.safe and not result.gripped
    assert result.summary() == {
        "outcome": "none",
        "lift_height": "0",
        "slip": "nan",
        "hold_time": "0",
        "duration": "0",
        "reason": "no simulator",
        "completed": "False",
        "safe": "True",
        "turn": "nan",
        "pose_in_hand": "",
        "touching": "",
        "lift_slip": "nan",
        "lift_turn": "nan",
        "phase": "",
        "cause": "not begun",
        "failed_at": "nan",
    }
