"""The environment as Gymnasium and a learner see it."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import softhand_gym
from pneuflex_sim.engines import ENGINES
from softhand_gym.environment import WORKSPACE, WRIST_SPEED, WRIST_TURN_SPEED
from softhand_gym.replay import replay
from softhand_trials.trials import Placement, StartedScene, TrialSettings

STEP = 0.005  # [s]
STILL = [-1.0] * 4 + [0.0] * 6  # no air, no motion


@pytest.fixture(scope="module")
def env():
    made = softhand_gym.GraspEnv(step=STEP)
    yield made
    made.close()


def rollout(env, seed, actions):
    """All that an episode shows: observations, rewards, ends, infos."""
    seen = [(*env.reset(seed=seed),)]
    for action in actions:
        seen.append(env.step(action))
        if seen[-1][2] or seen[-1][3]:
            break
    return seen


def same(first, second):
    """Whether two nested results are equal, bit for bit."""
    if isinstance(first, dict):
        return first.keys() == second.keys() and all(same(first[k], second[k]) for k in first)
    if isinstance(first, list | tuple):
        return len(first) == len(second) and all(map(same, first, second))
    return np.array_equal(first, second)


def actions_towards_the_object(count, seed=0):
    """Air at random, the wrist goes down, so that hand, object and table touch."""
    numbers = np.zeros((count, 10), np.float32)
    numbers[:, :4] = np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 4))
    numbers[:, 6] = -0.5
    return numbers


@pytest.mark.parametrize("engine", ENGINES)
def test_the_checker_of_gymnasium_finds_nothing(engine):
    env = gymnasium.make(softhand_gym.ENVIRONMENT_ID, engine=engine, step=STEP)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
    env.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_seed_repeats_an_episode_bit_for_bit(engine):
    actions = actions_towards_the_object(40)
    used = softhand_gym.GraspEnv(engine=engine, step=STEP)
    first = rollout(used, 3, actions)
    assert any(seen[0]["touching"][:-1].any() for seen in first), "the hand touched nothing"
    rollout(used, 4, actions[::-1])
    fresh = softhand_gym.GraspEnv(engine=engine, step=STEP)
    assert same(rollout(used, 3, actions), first)
    assert same(rollout(fresh, 3, actions), first)
    assert not same(rollout(fresh, 4, actions), first)
    used.close(), fresh.close()


def test_the_shipped_strategy_grasps_as_in_process():
    env = softhand_gym.GraspEnv(step=STEP, action_time=0.01)
    episode = replay(env, "surface_constrained", seed=1)
    config = env.scene.simulation.config
    placement = Placement(config.object_offset, config.object_mass_scale)
    in_process = StartedScene(TrialSettings(step=STEP)).run(placement)
    assert in_process.gripped and episode.info["is_success"]
    assert episode.info["lift_height"] == pytest.approx(in_process.lift_height, abs=1e-3)
    assert episode.reward == pytest.approx(2.0)
    again = rollout(env, 1, episode.actions)
    assert sum(seen[1] for seen in again[1:]) == episode.reward
    assert again[-1][2] and not again[-1][3] and len(again) == len(episode.actions) + 1
    env.close()


def test_processes_do_what_one_environment_does(env):
    actions = actions_towards_the_object(5)
    envs = gymnasium.make_vec(softhand_gym.ENVIRONMENT_ID, num_envs=2, step=STEP)
    try:
        envs.reset(seed=7)
        for action in actions:
            seen, rewards, *_ = envs.step(np.stack([action, action]))
    finally:
        envs.close()
    for number in range(2):
        last = rollout(env, 7 + number, actions)[-1]
        assert same({name: value[number] for name, value in seen.items()}, last[0])
        assert rewards[number] == last[1]


def test_air_of_one_is_the_pressure_limit_of_a_free_hand(env):
    env.reset(seed=0)
    for _ in range(300):
        seen, *_ = env.step([1.0, *STILL[1:]])
        if env.seen.time > 12.0:
            break
    assert seen["air_mass"][0] == pytest.approx(1.0, abs=0.02)
    assert seen["pressure"] == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=0.03)


def test_the_wrist_moves_and_turns_as_fast_as_asked(env):
    env.reset(seed=0)
    start = env.target
    for _ in range(10):
        env.step([*STILL[:4], -1.0, 0.5, 0.0, 0.0, 0.0, -1.0])
    duration = 10 * env.action_time
    moved = env.target.position - start.position
    assert moved == pytest.approx([-WRIST_SPEED * duration, 0.5 * WRIST_SPEED * duration, 0.0])
    x = start.place(np.array([0.0, 1.0, 0.0])) - start.position  # the wrist's y axis is level
    turned = env.target.place(np.array([0.0, 1.0, 0.0])) - env.target.position
    angle = np.arctan2(np.cross(x, turned)[2], x @ turned)
    assert angle == pytest.approx(-WRIST_TURN_SPEED * duration)
    for _ in range(30):
        env.step([*STILL[:4], -9.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert env.target.position[0] == WORKSPACE[0, 0]


def test_the_end_of_time_truncates():
    env = softhand_gym.GraspEnv(step=STEP, time_limit=0.2)
    env.reset(seed=0)
    ends = [env.step(STILL)[2:4] for _ in range(4)]
    assert ends == [(False, False)] * 3 + [(False, True)]
    env.close()


def test_pressures_can_be_commanded():
    env = softhand_gym.GraspEnv(step=STEP, air="pressure", hand="single_finger")
    env.reset(seed=0)
    for _ in range(80):
        seen, *_ = env.step([0.0] + [0.0] * 6)
    one_pulse = 10e3 / env.air.full_pressure[0]  # docs/use/run-strategies.md
    assert seen["pressure"][0] == pytest.approx(0.5, abs=one_pulse)
    env.close()


def test_a_picture_shows_hand_and_object():
    pytest.importorskip("pybullet")
    env = softhand_gym.GraspEnv(step=STEP, render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    assert picture.shape == (480, 640, 3) and len(np.unique(picture.reshape(-1, 3), axis=0)) > 50
    env.close()


@pytest.mark.parametrize("action", [np.zeros(9), np.full(10, np.nan), np.zeros((1, 10))])
def test_refuses_an_action_that_is_none(env, action):
    env.reset(seed=0)
    with pytest.raises(ValueError, match="action: expected 10 finite numbers, got"):
        env.step(action)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"air": "volume"}, "air: expected one of air_mass, pressure, got 'volume'"),
        ({"action_time": 0.0123}, "action_time: expected a multiple of 0.01 s"),
        ({"time_limit": 0.0}, "time_limit: expected a time above 0"),
        ({"object": "bal"}, "bal"),
        ({"engine": "havok"}, "engine: expected one of pybullet, mujoco"),
        ({"render_mode": "human"}, "render_mode: expected None or rgb_array"),
    ],
)
def test_refuses_settings_that_do_not_fit(settings, message):
    with pytest.raises(ValueError, match=message):
        softhand_gym.GraspEnv(**settings)


def test_a_reset_takes_a_given_place(env):
    seen, _ = env.reset(seed=0, options={"offset": (0.02, -0.03)})
    assert seen["object_position"][:2] == pytest.approx([0.02, -0.03], abs=1e-6)
    with pytest.raises(ValueError, match="options: expected some of offset, mass_scale"):
        env.reset(options={"ofset": (0.0, 0.0)})
