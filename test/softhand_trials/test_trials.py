import argparse
import json
import math
import sys
import warnings
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from grasp_strategies.in_process_scene import build_scene
from grasp_strategies.judging.judge import GraspResult
from grasp_strategies.strategy import load_strategy
from pneuflex_sim.simulation import SimulationConfig
from pneuflex_sim.world import solver_settings
from softhand_trials import trials
from softhand_trials.trials import (
    Placement,
    StartedScene,
    Trial,
    TrialSettings,
    add_settings,
    draw_placement,
    main,
    read_settings,
    run_batch,
    run_in_process,
    run_trial,
    summarise,
)

HELD = GraspResult("gripped", 0.12, 2e-4, 1.19, 6.0, "held")
MISSED = GraspResult("none", 0.0, math.nan, 0.0, 6.0, "nothing touched it")


def test_a_seed_gives_the_same_placement_every_time():
    assert draw_placement(7) == draw_placement(7)
    assert draw_placement(7) != draw_placement(8)


def test_placements_fill_their_ranges_and_keep_inside():
    draws = [draw_placement(seed) for seed in range(400)]
    offsets = np.array([offset for offset, _ in draws])
    scales = np.array([scale for _, scale in draws])
    assert np.abs(offsets).max() <= 0.010
    assert np.abs(scales - 1.0).max() <= 0.20
    # uniform on +-w: mean 0 and standard deviation w/sqrt(3)
    assert offsets.std(axis=0) == pytest.approx(0.010 / math.sqrt(3), rel=0.1)
    assert scales.std() == pytest.approx(0.20 / math.sqrt(3), rel=0.1)
    assert np.abs(offsets.mean(axis=0)).max() < 3 * 0.010 / math.sqrt(3 * 400)


def test_the_spread_can_be_switched_off():
    assert draw_placement(3, offset=0.0, mass_spread=0.0) == ((0.0, 0.0), 1.0)


def test_a_trial_in_a_used_world_is_that_of_a_new_one_bit_for_bit():
    settings = TrialSettings(step=0.01)
    trials.started_scene.cache_clear()
    alone = run_trial(5, settings)
    trials.started_scene.cache_clear()
    run_trial(2, settings)
    after_another = run_trial(5, settings)
    assert after_another.result == alone.result
    assert after_another.result.lift_height > 0.1


def test_a_placement_on_a_used_world_is_that_of_a_new_simulation_bit_for_bit():
    """Turn, mass and friction of all pairs are set on the world that there is."""
    jittered = Placement((0.004, -0.003), 1.04, yaw=0.03, friction_scale=0.87)
    strategy = load_strategy("surface_constrained")
    config = {"object_offset": jittered.offset, "object_mass_scale": jittered.mass_scale}
    config |= {"object_yaw": jittered.yaw, "friction_scale": jittered.friction_scale}
    new = build_scene(hand=strategy.hand, step=0.01, **config)
    alone = run_in_process(new, strategy, ())
    used = StartedScene(TrialSettings(step=0.01))
    others = [used.run(Placement(friction_scale=1.1)), used.run(Placement())]
    assert used.run(jittered) == alone
    assert np.array_equal(used.scene.simulation.bodies.q, new.simulation.bodies.q)
    assert np.array_equal(used.scene.simulation.object_pose()[1], new.simulation.object_pose()[1])
    assert alone not in others and alone.lift_height > 0.1


def test_a_held_object_has_its_contacts_told_and_a_lost_one_none():
    """A cylinder in the whole hand is force-closed; without air nothing is held."""
    found = StartedScene(TrialSettings(step=0.005)).run(Placement())
    contacts = found.contacts
    assert found.gripped and contacts is not None and contacts.force_closed
    assert contacts.parts == len(found.touching)
    assert contacts.parts <= contacts.links <= contacts.points
    assert 1e-5 < contacts.area < 1e-3  # patches of 2.8 mm at 1 N
    assert found.summary()["contacts_links"] == str(contacts.links)
    lost = StartedScene(TrialSettings(step=0.005, air_scale=0.0)).run(Placement())
    assert not lost.gripped and lost.contacts is None and "contacts_links" not in lost.summary()


def test_a_trial_after_one_that_diverged_is_as_before():
    used = StartedScene(TrialSettings(step=0.01))
    usual = used.run(Placement((0.002, 0.0)))
    used.scene.simulation.engine.world.diverged("for the test")
    assert used.run(Placement((0.002, 0.0))) == usual


def test_a_summary_is_json_that_counts_the_successes():
    batch = [Trial(0, (0.0, 0.001), 1.1, HELD, 3.0), Trial(1, (0.0, 0.0), 0.9, MISSED, 3.0)]
    summary = json.loads(json.dumps(summarise(batch, TrialSettings()), allow_nan=False))
    assert (summary["gripped"], summary["count"]) == (1, 2)
    assert [trial["slip"] for trial in summary["trials"]] == [2e-4, None]
    assert summary["trials"][0]["offset"] == [0.0, 0.001]


def fake_trial(seed, settings):
    return Trial(seed, (0.0, 0.0), 1.0, HELD if seed % 2 else MISSED, 1.0)


def test_a_batch_gives_trials_in_the_order_of_their_seeds(monkeypatch):
    monkeypatch.setattr(trials, "run_trial", fake_trial)
    assert [trial.seed for trial in run_batch([4, 2, 9])] == [4, 2, 9]


def test_the_command_writes_json_and_shows_each_trial(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(trials, "run_trial", fake_trial)
    out = tmp_path / "batch" / "trials.json"
    assert main(["--seeds", "3", "--first-seed", "5", "--out", str(out)]) == 0
    written = json.loads(out.read_text())
    assert [trial["seed"] for trial in written["trials"]] == [5, 6, 7]
    assert written["gripped"] == 2
    shown = capsys.readouterr()
    assert "[3/3] seed 7: gripped" in shown.err and "gripped 2 of 3" in shown.err
    assert shown.out == ""


def test_the_command_prints_nothing_but_json_to_standard_output(monkeypatch, capsys):
    monkeypatch.setattr(trials, "run_trial", fake_trial)
    assert main(["--seeds", "1"]) == 0
    assert json.loads(capsys.readouterr().out)["count"] == 1


def test_the_command_does_not_overwrite_unless_forced(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(trials, "run_trial", fake_trial)
    out = tmp_path / "trials.json"
    out.write_text("mine")
    assert main(["--seeds", "1", "--out", str(out)]) == 2
    assert out.read_text() == "mine"
    assert str(out) in capsys.readouterr().err
    assert main(["--seeds", "1", "--out", str(out), "--force"]) == 0
    assert json.loads(out.read_text())["count"] == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--seeds", "0"], "seeds and jobs: expected 1 or more"),
        (["--strategy", "pinch"], "surface_constrained"),
        (["--object", "elephant"], "cylinder"),
        (["--scene", "moon"], "table"),
        (["--step", "1"], "step"),
        (["--wall-inclination", "60"], "wall_inclination: expected a scene with a wall, got table"),
        (["--friction", "missing.yaml"], "missing.yaml"),
    ],
)
def test_the_command_says_in_one_line_what_it_cannot_use(capsys, options, message):
    assert main(["--seeds", "1", *options]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert error.startswith("softhand trials: ") and message in error


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        ("--offset", "-1", "expected 0 to 1 m, got -1"),
        ("--offset", "nan", "expected 0 to 1 m, got nan"),
        ("--mass-spread", "2", "expected 0 or more and less than 1, got 2"),
        ("--mass-spread", "-0.1", "expected 0 or more and less than 1, got -0.1"),
    ],
)
def test_a_spread_that_cannot_be_is_refused_with_its_option(capsys, option, value, expected):
    with pytest.raises(SystemExit) as ended:
        main(["--seeds", "1", option, value])
    assert ended.value.code == 2
    assert f"argument {option}: {expected}" in capsys.readouterr().err


APPROACH = """
format: softhand-strategy/1
name: approach_only
description: go over the object and wait
hand: rbo_hand_2
phases:
  - name: approach
    wrist: {frame: object, position: [0, 0, 0.3]}
    duration: 0.1
  - name: hold
    duration: 0.1
"""


def test_a_real_trial_runs_and_repeats_bit_for_bit(write_strategy):
    settings = TrialSettings(strategy=str(write_strategy(text=APPROACH)), step=0.002)
    first, second = run_trial(1, settings), run_trial(1, settings)
    assert first.result.completed and first.result.outcome == "none"
    assert first.result.duration == pytest.approx(0.2)
    assert first.record() | {"real_time_factor": 0} == second.record() | {"real_time_factor": 0}


def test_a_trial_that_asks_for_more_than_the_limits_allow_says_so(write_strategy):
    greedy = APPROACH.replace("rbo_hand_2", "single_finger")
    greedy = greedy.replace("name: hold", "name: hold\n    air_mass: {a: 0.05}\n    air_ramp: 5.0")
    settings = TrialSettings(strategy=str(write_strategy(text=greedy)), step=0.005)
    assert run_trial(1, settings).result.reason.endswith(
        "; relieved at the pressure limit: channel a"
    )
    modest = TrialSettings(strategy=str(write_strategy(text=APPROACH)), step=0.004)
    assert "limit" not in run_trial(1, modest).result.reason


STEEL = """
format: pneuflex-object/1
shape: box
size: [0.05, 0.05, 0.05]
mass: 0.1
material: steel
rpy: [0, 0, 0]
"""
PAIRS = """
format: pneuflex-friction/1
pairs:
  steel: {rubber: 0.45, wood: 0.2}
"""


def test_materials_and_a_wall_of_ones_own_reach_the_trials(write_strategy, tmp_path, capsys):
    block, pairs = tmp_path / "block.yaml", tmp_path / "pairs.yaml"
    block.write_text(STEEL)
    pairs.write_text(PAIRS)
    choice = ["--strategy", str(write_strategy(text=APPROACH)), "--object", str(block)]
    choice += ["--seeds", "1", "--step", "0.005", "--scene", "wall", "--wall-inclination", "70"]
    assert main(choice) == 2
    assert "steel" in capsys.readouterr().err
    choice += ["--friction", str(pairs)]
    assert main(choice) == 0
    settings = json.loads(capsys.readouterr().out)["settings"] | {"options": ()}
    simulation = trials.started_scene(TrialSettings(**settings)).scene.simulation
    assert simulation.friction.pair("steel", "rubber") == 0.45
    assert simulation.scene.wall.inclination == 70.0


def test_the_command_line_may_let_a_cylinder_stand():
    parser = argparse.ArgumentParser()
    add_settings(parser)
    assert read_settings(parser.parse_args([])).object_rpy is None
    settings = read_settings(parser.parse_args(["--object-rpy", "0", "0", "0.5"]))
    assert settings.object_rpy == (0.0, 0.0, 0.5)
    scene = trials.started_scene(replace(settings, segments=1)).scene
    assert scene.observe().object_position[2] == pytest.approx(0.175 / 2)


def test_rbo_hand_1_lifts_the_cylinder_with_no_joint_asked_beyond_its_stop():
    settings = TrialSettings(strategy="rbo_hand_1_from_above", step=0.005)
    trials.started_scene.cache_clear()
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)  # of pressures that bend a joint to its stop
        results = [trial.result for trial in run_batch(range(3), settings)]
    assert [result.outcome for result in results] == ["gripped"] * 3
    assert all(result.lift_height > 0.1 and result.slip < 2e-3 for result in results)


def test_a_gripper_of_ones_own_grasps_by_the_command(tmp_path):
    """Hand, actuators and strategy are YAML files of the examples; nothing of them is shipped."""
    strategy = Path(__file__).parents[2] / "examples/three_finger_gripper/grasp.yaml"
    out = tmp_path / "trials.json"
    choice = ("--strategy", str(strategy), "--object", "ball", "--step", "0.005")
    assert main([*choice, "--seeds", "3", "--first-seed", "1", "--out", str(out)]) == 0
    trials = json.loads(out.read_text())["trials"]
    assert [trial["outcome"] for trial in trials] == ["gripped"] * 3
    assert all(trial["lift_height"] > 0.1 and trial["slip"] < 5e-3 for trial in trials)


def test_every_setting_of_the_simulation_reaches_it():
    settings = TrialSettings(
        object="ball",
        scene="wall",
        model="model.yaml",
        step=0.004,
        segments=7,
        solver="fast",
        friction="friction.yaml",
        wall_inclination=60.0,
        allow_effect_files=True,
        hand="single_finger",
        object_rpy=(0.1, 0.2, 0.3),
        modulus_scale=1.2,
        finger_contact=True,
        rubber_friction_scale=0.8,
        engine="mujoco",
    )
    config, usual = settings.simulation("rbo_hand_2"), SimulationConfig()
    shared = {field.name for field in fields(TrialSettings)} & set(vars(config)) - {"solver"}
    for name in shared:
        assert getattr(config, name) == getattr(settings, name) != getattr(usual, name), name
    assert config.solver == solver_settings("fast") != usual.solver
    assert TrialSettings().simulation("rbo_hand_1").hand == "rbo_hand_1"


def test_two_engines_run_the_same_seeds_and_those_that_differ_are_named(
    monkeypatch, tmp_path, capsys
):
    ran = []

    def play(seed, settings):
        ran.append((settings.engine, seed))
        held = settings.engine == "pybullet" or seed != 6
        return Trial(seed, (0.0, 0.0), 1.0, HELD if held else MISSED, 1.0)

    monkeypatch.setattr(trials, "run_trial", play)
    out = tmp_path / "both.json"
    words = ["--seeds", "3", "--first-seed", "5", "--out", str(out)]
    assert main([*words, "--engines", "pybullet,mujoco"]) == 0
    assert ran == [(engine, seed) for engine in ("pybullet", "mujoco") for seed in (5, 6, 7)]
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "[1/3] pybullet seed 5: gripped, held"
    words = "cylinder: gripped pybullet 3, mujoco 2 of 3; same verdict 2 of 3; differ: seed 6 "
    assert told[-1] == words + "(pybullet)"
    written = json.loads(out.read_text())
    assert written["engines"]["mujoco"]["gripped"] == 2
    assert written["agreement"]["differing"] == {"seed 6": ["pybullet"]}


@pytest.mark.parametrize("name", ["pybullet", "mujoco"])
def test_an_engine_that_is_not_installed_is_refused_before_the_first_trial(
    monkeypatch, capsys, name
):
    monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr(trials, "run_trial", lambda *_: pytest.fail("it ran"))
    assert main(["--engines", "pybullet,mujoco"]) == 2
    assert f"{name}: expected it to be installed, got none" in capsys.readouterr().err


def test_engines_that_are_the_same_cannot_be_compared(capsys):
    assert main(["--engines", "mujoco,mujoco"]) == 2
    assert (
        "engines: expected one or more different names, got mujoco, mujoco"
        in capsys.readouterr().err
    )
