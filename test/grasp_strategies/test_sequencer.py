import math
import threading

import numpy as np
import pytest
from mock_scene import GRIP, MockScene
from scipy.spatial.transform import Rotation

from grasp_strategies.judging.failure import SCENE_FAILED
from grasp_strategies.pose import Pose, angle_between
from grasp_strategies.scene import SceneError
from grasp_strategies.sequencer import Sequencer, goal_pose
from grasp_strategies.strategy import Waypoint

STEP = 0.01
LIFT_DURATION = 1.875 * 0.12 / 0.2  # minimum jerk: 15/8 of the mean speed at its greatest


def run(scene, strategy, **options):
    phases = []
    sequencer = Sequencer(
        scene,
        strategy,
        control_step=STEP,
        on_phase=lambda name: phases.append((scene.time, name)),
        **options,
    )
    return sequencer.run(), phases


def names(phases):
    return [name for _, name in phases]


# ---------------------------------------------------------------- judging
def test_a_grasp_that_holds_counts_with_its_true_lift_and_no_slip(make_strategy):
    result, phases = run(MockScene(), make_strategy())
    assert result.gripped and result.completed and result.safe
    assert result.lift_height == pytest.approx(0.12, abs=1e-9)
    assert result.slip == pytest.approx(0.0, abs=1e-12)
    assert names(phases) == ["approach", "close", "lift", "hold", "done"]


def test_phases_take_the_time_their_data_says(make_strategy):
    result, phases = run(MockScene(), make_strategy())
    begins = {name: time for time, name in phases}
    assert begins["close"] == pytest.approx(0.5)
    # the air follows at once, so the error falls below 1 mg of 40 at the end of the ramp
    assert begins["lift"] - begins["close"] == pytest.approx(0.4, abs=1.1 * STEP)
    assert begins["hold"] - begins["lift"] == pytest.approx(LIFT_DURATION, abs=STEP)
    assert begins["done"] - begins["hold"] == pytest.approx(1.2, abs=STEP / 2)
    assert result.duration == pytest.approx(begins["done"])


def test_a_phase_ends_when_the_highest_pressure_has_fallen(make_strategy):
    until = "until: {pressure: {below: 3.0e+4}}\n    time_out: 9.0\n    option: lower_and_release"
    release = "- name: release\n    air_mass: {a: 0, b: 0, c: 0, d: 0}\n    "
    strategy = make_strategy((release + "option: lower_and_release", release + until))
    # 3 GPa a kg: channel a falls from 120 kPa (40 mg) to 30 kPa within 1.5 s of 20 mg/s
    scene = MockScene(air_rate=2e-5)
    _, phases = run(scene, strategy, options=["lower_and_release"])
    begins = {name: time for time, name in phases}
    assert begins["done"] - begins["release"] == pytest.approx(1.5, abs=2.1 * STEP)


@pytest.mark.parametrize("speed", [0.0005, 0.002, 0.005])
def test_slip_is_what_the_object_sank_in_the_hand_during_the_hold(make_strategy, speed):
    result, _ = run(MockScene(slip_speed=speed), make_strategy())
    assert result.slip == pytest.approx(speed * 1.2, rel=1e-6)
    assert result.hold_time == pytest.approx(1.2)
    assert result.gripped


def test_an_object_that_slips_too_far_is_lost(make_strategy):
    strategy = make_strategy(("phases:", "success: {max_slip: 0.003}\nphases:"))
    result, _ = run(MockScene(slip_speed=0.006), strategy)
    assert result.outcome == "lost"
    assert "slipped by 7.2 mm" in result.reason


def test_an_object_that_falls_in_the_hold_is_lost(make_strategy):
    result, _ = run(MockScene(drop_at=2.5), make_strategy())
    assert result.outcome == "lost"
    assert result.lift_height == pytest.approx(0.12, abs=1e-9)
    assert "table touched the object in the hold" in result.reason
    assert result.slip == pytest.approx(0.0, abs=1e-12)


def test_an_object_that_stays_on_the_table_is_none(make_strategy):
    result, _ = run(MockScene(stick=True), make_strategy())
    assert result.outcome == "none"
    assert result.lift_height == pytest.approx(0.0, abs=1e-12)
    assert math.isnan(result.slip)


def test_an_object_that_something_else_touches_is_not_gripped(make_strategy):
    result, _ = run(MockScene(also_touching={"wall"}), make_strategy())
    assert not result.gripped
    assert "wall touched the object" in result.reason


def test_a_lift_that_is_too_low_does_not_count(make_strategy):
    result, _ = run(MockScene(), make_strategy(("[0, 0, 0.12]", "[0, 0, 0.09]")))
    assert result.outcome == "lost"
    assert "90 mm up" in result.reason


def test_a_hold_that_is_too_short_does_not_count(make_strategy):
    result, _ = run(MockScene(), make_strategy(("duration: 1.2", "duration: 0.8")))
    assert result.outcome == "lost"
    assert "held only 0.80 s of 1.00 s" in result.reason


def test_putting_the_object_down_afterwards_does_not_change_the_verdict(make_strategy):
    scene = MockScene()
    result, phases = run(scene, make_strategy(), options=["lower_and_release"])
    assert result.gripped
    assert names(phases)[-3:] == ["lower", "release", "done"]
    assert scene.air.tolist() == [0.0] * 4
    assert result.hold_time == pytest.approx(1.2)


# ---------------------------------------------------------------- commands
def test_the_wrist_is_lifted_smoothly_at_the_speed_asked_for(make_strategy):
    scene = MockScene()
    _, phases = run(scene, make_strategy())
    lift, hold = (next(t for t, name in phases if name == wanted) for wanted in ("lift", "hold"))
    heights = np.array([(t, place[2]) for t, place, _ in scene.wrist_commands if lift <= t <= hold])
    s = np.minimum((heights[:, 0] - lift) / LIFT_DURATION, 1.0)
    rise = heights[:, 1] - heights[0, 1]
    assert rise == pytest.approx(0.12 * (10 * s**3 - 15 * s**4 + 6 * s**5), abs=1e-9)
    speeds = np.diff(heights[:-1, 1]) / np.diff(heights[:-1, 0])
    assert speeds.max() == pytest.approx(0.2, rel=2e-3)


def test_the_wrist_never_jumps(make_strategy):
    scene = MockScene()
    run(scene, make_strategy(), options=["lower_and_release"])
    places = np.array([place for _, place, _ in scene.wrist_commands])
    turns = [turn for _, _, turn in scene.wrist_commands]
    # at most the greatest speed of the fastest motion, the approach of 0.27 m in 0.5 s
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 1.876 * 0.28 / 0.5 * STEP
    assert max(map(angle_between, turns, turns[1:])) < 1.876 * (math.pi / 2) / 0.5 * STEP


@pytest.mark.parametrize("step", [0.01, 0.07, 0.2])
def test_a_motion_reaches_its_goal_whatever_the_control_step(make_strategy, step):
    scene = MockScene()
    Sequencer(scene, make_strategy(), control_step=step).run()
    assert scene.wrist_commands[-1][1] == pytest.approx([0.02, -0.01, 0.2525], abs=1e-9)


def test_the_air_follows_a_straight_line_to_its_goal(make_strategy):
    scene = MockScene()
    _, phases = run(scene, make_strategy())
    begin = next(t for t, name in phases if name == "close")
    for time, masses in scene.air_commands:
        share = min(1.0, max(0.0, (time - begin) / 0.4))
        assert masses == pytest.approx(share * np.array([4e-5, 2e-5, 2e-5, 2e-5]), abs=1e-12)


def test_commands_come_every_hundredth_of_a_second_unless_asked_otherwise(make_strategy):
    scene = MockScene()
    Sequencer(scene, make_strategy()).run()
    times = [time for time, *_ in scene.wrist_commands]
    assert min(np.diff(times)[:40]) == pytest.approx(0.01)
    assert max(np.diff(times)[:40]) == pytest.approx(0.01)


def test_air_is_commanded_when_a_phase_begins_and_then_only_where_it_changes(make_strategy):
    scene = MockScene()
    _, phases = run(scene, make_strategy())
    begins = {name: time for time, name in phases}
    times = [time for time, _ in scene.air_commands]
    assert times[0] == 0.0 and times[1] == pytest.approx(begins["close"])
    assert times[2:] == pytest.approx(begins["close"] + STEP * np.arange(1, len(times) - 1))
    assert times[-1] == pytest.approx(begins["close"] + 0.4, abs=1.1 * STEP)
    assert scene.pressure_commands == []


def test_a_pressure_is_commanded_along_its_ramp(make_strategy):
    scene = MockScene()
    pressure = ("air_mass: {a: 4.0e-5, b: 2.0e-5, c: 2.0e-5, d: 2.0e-5}", "pressure: {a: 3.0e+4}")
    run(
        scene,
        make_strategy(
            pressure, ("{air_mass_error: {below: 1.0e-6}}", "{pressure: {above: 2.9e+4}}")
        ),
    )
    times, values = zip(*scene.pressure_commands, strict=True)
    ramp = np.array([value[0] for value in values])
    assert len(times) > 30 and np.all(np.diff(ramp) > 0) and ramp[-1] == pytest.approx(3e4)


@pytest.mark.parametrize(("bodies", "ends"), [("[box]", True), ("[box, tray]", False)])
def test_a_phase_ends_when_all_of_its_bodies_touch_the_object(make_strategy, bodies, ends):
    until = f"until: {{touching: {bodies}}}"
    strategy = make_strategy(("until: {air_mass_error: {below: 1.0e-6}}", until))
    _, phases = run(MockScene(also_touching={"box", "wall"}), strategy)
    assert ("lift" in names(phases)) == ends


def test_a_phase_without_a_duration_takes_no_longer_than_its_motion_or_ramp(make_strategy):
    strategy = make_strategy(("position: [0, 0, 0.12]", "position: [0, 0, 0.02]"))
    _, phases = run(MockScene(), strategy, options=["lower_and_release"])
    begins = {name: time for time, name in phases}
    assert begins["hold"] - begins["lift"] == pytest.approx(LIFT_DURATION / 6, abs=STEP)
    assert begins["done"] - begins["release"] == pytest.approx(STEP)


def test_slow_air_delays_the_lift_until_it_has_come(make_strategy):
    rate = 4e-5
    scene = MockScene(air_rate=rate)
    _, phases = run(scene, make_strategy())
    close, lift = (next(t for t, name in phases if name == wanted) for wanted in ("close", "lift"))
    assert lift - close == pytest.approx((4e-5 - 1e-6) / rate, abs=2 * STEP)


TOUCH = """
  - name: touch
    wrist: {frame: wrist_level, position: [0, 0, -0.08]}
    speed: 0.1
    until: {contact_force: {above: 5.0}}
    time_out: 1.0
"""


def with_touch(make_strategy, extra=""):
    return make_strategy(("  - name: close", TOUCH.lstrip("\n") + extra + "  - name: close"))


def test_contact_stops_the_wrist_at_the_force_asked_for(make_strategy):
    # approach ends at 0.1325 m; a table at 0.1 m with 1000 N/m pushes 5 N at 0.095 m
    scene = MockScene(touch_height=0.1)
    _, phases = run(scene, with_touch(make_strategy))
    assert "lift" in names(phases)
    lift = next(t for t, name in phases if name == "lift")
    stopped = [place[2] for t, place, _ in scene.wrist_commands if t < lift][-1]
    assert 0.095 - 0.1 * STEP <= stopped < 0.095


def test_a_time_out_ends_the_run_with_what_was_missed(make_strategy):
    scene = MockScene()
    result, phases = run(scene, with_touch(make_strategy))
    assert names(phases) == ["approach", "touch", "failed"]
    assert not result.completed and result.safe and result.outcome == "none"
    assert (
        result.reason
        == "phase touch: expected contact_force above 5 N within 1 s, got contact_force 0"
    )
    assert scene.time == pytest.approx(1.5)


def test_a_time_out_can_lead_to_the_next_phase(make_strategy):
    strategy = with_touch(make_strategy, "    on_time_out: next\n")
    result, _ = run(MockScene(), strategy)
    assert result.gripped


# ---------------------------------------------------------------- abort and errors
@pytest.mark.parametrize("moment", [0.0, 0.25, 0.7, 1.5, 3.0])
def test_an_abort_vents_at_the_next_control_step_and_commands_nothing_more(make_strategy, moment):
    scene, abort = MockScene(), threading.Event()
    scene.on_step = lambda: scene.time > moment and abort.set()
    result, phases = run(scene, make_strategy(), abort=abort)
    assert scene.vented == 1
    assert scene.time <= moment + STEP + 1e-9
    assert names(phases)[-1] == "aborted"
    assert not result.completed and result.safe
    assert f"aborted in phase {names(phases)[-2]}: vented" in result.reason
    assert all(t <= moment + 1e-9 for t, *_ in scene.wrist_commands)


def test_an_abort_before_the_start_moves_nothing(make_strategy):
    scene, abort = MockScene(), threading.Event()
    abort.set()
    result, phases = run(scene, make_strategy(), abort=abort)
    assert scene.wrist_commands == [] and scene.vented == 1
    assert names(phases) == ["aborted"]
    assert not result.completed


def test_an_abort_that_holds_keeps_the_air_that_is_in_the_channels(make_strategy):
    scene, abort = MockScene(air_rate=2e-5), threading.Event()
    scene.on_step = lambda: scene.time > 0.8 and abort.set()
    result, _ = run(scene, make_strategy(), abort=abort, abort_action="hold")
    assert scene.vented == 0
    assert "holds" in result.reason and result.safe and not result.completed
    assert scene.air_commands[-1][1] == pytest.approx(scene.air)
    assert scene.air[0] > 0


def test_an_abort_that_cannot_vent_says_so(make_strategy):
    class Stuck(MockScene):
        def vent(self):
            raise SceneError("the driver is gone")

    scene, abort = Stuck(), threading.Event()
    scene.on_step = abort.set
    result, _ = run(scene, make_strategy(), abort=abort)
    assert not result.safe
    assert result.reason == "aborted in phase approach: could not vent: the driver is gone"


@pytest.mark.parametrize("ends_by", ["scene", "time-out", "done"])
def test_an_abort_is_obeyed_although_the_run_ended_by_itself(make_strategy, ends_by):
    scene = MockScene(**({"break_at": 0.7} if ends_by == "scene" else {}))
    strategy = with_touch(make_strategy) if ends_by == "time-out" else make_strategy()
    phases, abort = [], threading.Event()

    def on_phase(name):  # the abort comes when the run has already ended
        phases.append(name)
        if name in ("failed", "done"):
            abort.set()

    result = Sequencer(scene, strategy, control_step=STEP, on_phase=on_phase, abort=abort).run()
    assert phases[-1] == ("done" if ends_by == "done" else "failed")
    assert scene.vented == 1
    assert result.cause == "aborted" and result.safe and not result.completed
    assert result.reason.endswith("; aborted: vented")


def test_an_abort_before_the_scene_could_be_seen_vents_all_the_same(make_strategy):
    class Dark(MockScene):
        def observe(self):
            abort.set()
            raise SceneError("no pose of the object")

    abort = threading.Event()
    scene = Dark()
    result, _ = run(scene, make_strategy(), abort=abort)
    assert scene.vented == 1
    assert result.reason == "no pose of the object; aborted: vented"


def test_a_scene_that_fails_ends_the_run_with_its_reason(make_strategy):
    result, phases = run(MockScene(break_at=0.7), make_strategy())
    assert names(phases)[-1] == "failed"
    assert result.reason == "phase close: the mock broke as asked"
    assert result.cause == SCENE_FAILED
    assert not result.completed


def test_a_scene_that_cannot_be_seen_at_the_start_is_left_as_it_is(make_strategy):
    class Dark(MockScene):
        def observe(self):
            raise SceneError("no pose of the object")

    scene = Dark()
    result, phases = run(scene, make_strategy())
    assert names(phases) == ["failed"]
    assert (result.outcome, result.reason) == ("none", "no pose of the object")
    assert not result.completed and scene.wrist_commands == [] and scene.air_commands == []


def test_an_object_carried_when_the_run_failed_is_lost(make_strategy):
    result, _ = run(MockScene(break_at=2.1), make_strategy())
    assert result.outcome == "lost"


def test_a_channel_the_hand_does_not_have_is_refused_before_anything_moves(make_strategy):
    scene = MockScene()
    with pytest.raises(ValueError, match=r"phase close: air_mass: .*\(a, b, c, d\), got e"):
        Sequencer(scene, make_strategy(("{a: 4.0e-5", "{e: 1.0e-5, a: 4.0e-5")))
    assert scene.air_commands == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"options": ["dance"]}, r"expected some of \['lower_and_release'\], got \['dance'\]"),
        ({"control_step": 0.0}, "control_step: expected a number above 0"),
        ({"abort_action": "drop"}, "abort_action: expected one of vent, hold, got 'drop'"),
    ],
)
def test_options_that_mean_nothing_are_refused(make_strategy, options, message):
    with pytest.raises(ValueError, match=message):
        Sequencer(MockScene(), make_strategy(), **options)


# ---------------------------------------------------------------- frames of waypoints
COMMANDED = Pose(np.array([0.3, 0.1, 0.2]), Rotation.from_euler("xyz", [0.3, 1.0, -0.4]).as_quat())
OFFSET, RPY = (0.02, -0.03, 0.05), (0.1, 0.2, 0.3)


def goal(frame, rpy=RPY, scene=None, object_rpy=None):
    scene = scene or MockScene()
    found = goal_pose(Waypoint(frame, OFFSET, rpy), scene.observe(), COMMANDED, object_rpy)
    return found.position, Rotation.from_quat(found.orientation)


def same(first, second):
    return (first.inv() * second).magnitude() == pytest.approx(0.0, abs=1e-7)


def test_environment_waypoints_are_poses_in_the_world():
    position, turn = goal("environment")
    assert position == pytest.approx(OFFSET)
    assert same(turn, Rotation.from_euler("xyz", RPY))


def test_wrist_waypoints_are_in_the_axes_of_the_commanded_wrist():
    position, turn = goal("wrist")
    frame = Rotation.from_quat(COMMANDED.orientation)
    assert position == pytest.approx(COMMANDED.position + frame.apply(OFFSET))
    assert same(turn, frame * Rotation.from_euler("xyz", RPY))


def test_level_waypoints_start_at_the_wrist_but_keep_the_axes_of_the_world():
    position, turn = goal("wrist_level", rpy=None)
    assert position == pytest.approx(COMMANDED.position + OFFSET)
    assert same(turn, Rotation.from_quat(COMMANDED.orientation))


def test_object_waypoints_turn_with_the_object_about_the_vertical_only():
    lying, yaw, roll = Rotation.from_euler("x", math.pi / 2), 0.5, 0.9
    turned = Rotation.from_euler("z", yaw) * lying * Rotation.from_euler("z", roll)
    scene = MockScene(object_orientation=turned.as_quat())
    position, turn = goal("object", scene=scene, object_rpy=(math.pi / 2, 0, 0))
    about_z = Rotation.from_euler("z", yaw)
    assert position == pytest.approx(scene.object_position + about_z.apply(OFFSET))
    assert same(turn, about_z * Rotation.from_euler("xyz", RPY))


def test_object_waypoints_without_a_known_orientation_keep_the_axes_of_the_world():
    scene = MockScene(object_orientation=Rotation.from_euler("z", 1.0).as_quat())
    position, turn = goal("object", scene=scene)
    assert position == pytest.approx(scene.object_position + OFFSET)
    assert same(turn, Rotation.from_euler("xyz", RPY))


def test_the_mock_holds_only_above_its_threshold():
    scene = MockScene()
    scene.command_air(np.full(4, GRIP))
    scene.step(STEP)
    assert not scene.grips


# ---------------------------------------------------------------- an object that is held out
def test_an_object_is_held_out_and_let_go_as_its_phases_begin(make_strategy):
    held = "  - name: hold_out\n    hold_object: {position: [0.05, 0, 0.1]}\n"
    let_go = "  - name: let_go\n    release_object: 0.3\n"
    strategy = make_strategy(
        ("  - name: close", held + "  - name: close"), ("  - name: lift", let_go + "  - name: lift")
    )
    assert strategy.holds_object_out and not make_strategy().holds_object_out
    scene = MockScene()
    result, phases = run(scene, strategy)
    begins = {name: time for time, name in phases}
    assert result.gripped
    assert scene.object_commands == [
        (begins["hold_out"], (0.05, 0.0, 0.1), (0.0, 0.0, 0.0, 1.0)),
        (begins["let_go"], 0.3),
    ]
    assert begins["lift"] - begins["let_go"] == pytest.approx(0.3, abs=1.1 * STEP)
