"""A small policy learns by trial and error to grasp the cylinder: ten minutes on two cores.

    python examples/learn_a_grasp.py              # writes policy and curve to out/learned_grasp
    python examples/learn_a_grasp.py --shuffled   # the same with returns dealt out to wrong tries

The policy goes to a place, fills the channels, and goes to another place, at given times; what it
learns are ten numbers: both places of the wrist, relative to where the object was first seen, and
the air of each channel. The hand stays turned as it is at the start. CMA-ES (Hansen, The CMA
evolution strategy: a tutorial, 2016) changes the numbers by the returns of whole episodes. It
learns with large steps of the physics in MuJoCo, the fastest setting in which the shipped strategy
grips as it does at 2 ms.
"""

import argparse
import json
import multiprocessing
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from cmaes import CMA
from matplotlib.figure import Figure

from softhand_gym import GraspEnv
from softhand_gym.environment import WRIST_SPEED

LEARNED = Path(__file__).with_name("learned_grasp.json")
QUICK = {"engine": "mujoco", "step": 0.01, "action_time": 0.1}  # settings to learn with
CLOSE, LIFT = 1.5, 4.5  # when air and when the second place are commanded [s]
STARTS = np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.25]])  # of both places, above the object [m]
REACH = 0.08  # by which a number of 1 moves a place [m]
AIR, AIR_REACH = -0.5, 0.3  # air in numbers of actions: at the start, and what 1 changes [-]
GAIN = 2.0  # velocity of the wrist over its distance from its place [1/s]
NUMBERS = 10  # of the policy, for a hand of four channels
TRIES = 40  # a generation
GENERATIONS = 25
LEARNING_TIME = 7.0  # of an episode [s]
FIRST_SEED, LAST_SEED = 10_000, 2**31  # of episodes to learn from


class GoCloseLift:
    """The policy of numbers (6 + channels,): both places, then air, each 0 at the start."""

    def __init__(self, numbers):
        numbers = np.asarray(numbers, float)
        self._places = STARTS + REACH * numbers[:6].reshape(2, 3)
        self._air = np.clip(AIR + AIR_REACH * numbers[6:], -1.0, 1.0)

    def begin(self, seen):
        """Take in the first observation."""
        self._object = seen["object_position"].astype(float)

    def act(self, seen, now):
        """Action after an observation at a time [s]."""
        away = self._object + self._places[int(now >= LIFT)] - seen["wrist_position"]
        air = self._air if now >= CLOSE else np.full_like(self._air, -1.0)
        velocity = np.clip(GAIN / WRIST_SPEED * away, -1.0, 1.0)
        return np.concatenate([air, velocity, np.zeros(3)])


class Random:
    """Actions at random, uniform."""

    def __init__(self, space, seed):
        self._space = space
        self._space.seed(seed)

    def begin(self, seen):
        """Nothing."""

    def act(self, seen, now):
        """Any action."""
        return self._space.sample()


def episode(env, policy, seed):
    """Return [-] of an episode, and info of its end."""
    seen, info = env.reset(seed=seed)
    policy.begin(seen)
    total, over = 0.0, False
    while not over:
        seen, reward, terminated, truncated, info = env.step(policy.act(seen, info["time"]))
        total, over = total + reward, terminated or truncated
    return total, info


class Training(NamedTuple):
    """Learned numbers, and by generation (n,): mean return, share of grasps, seconds so far that
    processors spent on episodes.
    """

    numbers: list
    returns: list
    gripped: list
    seconds: list


def train(seed, generations=GENERATIONS, shuffled=False, workers=2, tries=TRIES):
    """Learn in processes; the mean of the last generation's distribution is the policy."""
    learner = CMA(np.zeros(NUMBERS), 1.0, seed=seed, population_size=tries)
    generator = np.random.default_rng(seed)
    curve, spent = [], 0.0
    spawned = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, spawned, _open) as pool:
        for generation in range(generations):
            tried = [learner.ask() for _ in range(tries)]
            seeds = generator.integers(FIRST_SEED, LAST_SEED, tries).tolist()
            returns, gripped, seconds = np.transpose(list(pool.map(_try, tried, seeds)))
            judged = generator.permutation(returns) if shuffled else returns
            learner.tell([(one, -judge) for one, judge in zip(tried, judged, strict=True)])
            spent += seconds.sum()
            curve.append((returns.mean(), gripped.mean(), spent))
            words = f"return {returns.mean():.2f}, gripped {gripped.mean():.2f}, {spent:.0f} s"
            print(f"generation {generation}: {words}", flush=True)
    return Training(learner.mean.tolist(), *np.transpose(curve).tolist())


def _open():
    """The environment of this process."""
    global _env
    warnings.simplefilter("ignore")  # joints at their stops, which tries reach
    _env = GraspEnv(**QUICK, time_limit=LEARNING_TIME)


def _try(numbers, seed):
    begin = time.process_time()
    total, info = episode(_env, GoCloseLift(numbers), seed)
    return total, info["is_success"], time.process_time() - begin


def draw(trainings, path):
    """Curves of trainings by name."""
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axes = figure.subplots(1, 2, sharex=True)
    for name, training in trainings.items():
        axes[0].plot(training.seconds, training.returns, label=name)
        axes[1].plot(training.seconds, np.multiply(100.0, training.gripped), label=name)
    for one, label, top in zip(axes, ("mean return [-]", "grasps [%]"), (2.05, 102), strict=True):
        one.set(xlabel="processor time [s]", ylabel=label, ylim=(0, top))
        one.grid(alpha=0.3)
    axes[0].legend(frameon=False)
    figure.savefig(path, dpi=120)


def load(name="learned"):
    """Training of the name `learned` or `shuffled`, as it was kept in learned_grasp.json."""
    return Training(**json.loads(LEARNED.read_text())[name])


def test_a_training_repeats_with_its_seed_in_any_number_of_processes():
    first = train(3, generations=2, tries=2, workers=1)
    again = train(3, generations=2, tries=2, workers=2)
    assert first.numbers == again.numbers and first.returns == again.returns


def test_the_learned_policy_grasps_and_that_of_shuffled_returns_does_not():
    env = GraspEnv(**QUICK)
    for name, grasps in (("learned", True), ("shuffled", False)):
        _, info = episode(env, GoCloseLift(load(name).numbers), seed=0)
        assert info["is_success"] == grasps
    env.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--shuffled", action="store_true", help="the negative control")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--generations", type=int, default=GENERATIONS)
    parser.add_argument("--out", type=Path, default=Path("out/learned_grasp"))
    chosen = parser.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    training = train(chosen.seed, chosen.generations, chosen.shuffled, chosen.workers)
    name = "shuffled" if chosen.shuffled else "learned"
    file = chosen.out / "trainings.json"
    kept = json.loads(file.read_text()) if file.is_file() else {}
    kept[name] = training._asdict()
    file.write_text(json.dumps(kept) + "\n")
    draw({name: Training(**one) for name, one in kept.items()}, chosen.out / "curve.png")
    print(f"written to {file} and curve.png beside it")


if __name__ == "__main__":
    main()
