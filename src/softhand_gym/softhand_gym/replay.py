"""A strategy as the agent: its phases, run through an environment's actions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, cast

import gymnasium
import numpy as np

from grasp_strategies.pose import Pose, inverse
from grasp_strategies.scene import Array, Observation, SceneError
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import Strategy, load_strategy
from softhand_common.numerics.rotations import compose
from softhand_gym.environment import WRIST_SPEED, WRIST_TURN_SPEED, GraspEnv
from softhand_gym.signals import MASS_COMMAND, PRESSURE_COMMAND, rotation_of


@dataclass
class Episode:
    """The result of an episode: sum of the rewards [-], info of the last step, and the actions
    taken.
    """

    reward: float = 0.0
    info: dict[str, Any] = field(default_factory=dict)
    actions: list[Array] = field(default_factory=list)


def replay(env: gymnasium.Env, strategy: Strategy | str, seed: int | None = None) -> Episode:
    """Run a strategy, given itself or by its name or file, in an environment, which may be wrapped,
    from a reset to the end of the strategy or of the episode.

    Where an action lasts as long as a control step of strategies (`action_time=0.01`), the hand
    moves as in `softhand trials`, except for the rounding of actions.

    Raises:
        ValueError: there is no such strategy, or it commands pressures where the environment takes
            air masses, or the other way round.
    """
    scene = _ActingScene(env, seed)
    found = strategy if isinstance(strategy, Strategy) else load_strategy(strategy)
    Sequencer(scene, found, control_step=scene.grasp.action_time).run()
    return scene.episode


class _ActingScene:
    """The interface of scenes on an environment: a step of it is an action."""

    def __init__(self, env: gymnasium.Env, seed: int | None) -> None:
        self.grasp, self._env = cast(GraspEnv, env.unwrapped), env
        _, info = env.reset(seed=seed)
        self.episode, self._over = Episode(info=info), False
        self._target = self.grasp.target
        self._air = np.zeros(len(self.channels))

    @property
    def channels(self) -> tuple[str, ...]:
        return self.grasp.scene.channels

    @property
    def hand_bodies(self) -> frozenset[str]:
        return self.grasp.scene.hand_bodies

    @property
    def time(self) -> float:
        return self.grasp.seen.time

    def command_wrist(self, position: Array, orientation: Array) -> None:
        self._target = Pose(position, orientation)

    def command_air(self, masses: Array) -> None:
        self._command(MASS_COMMAND, masses)

    def command_pressure(self, pressures: Array) -> None:
        """Command gauge pressures (channels,) [Pa]."""
        self._command(PRESSURE_COMMAND, pressures)

    def _command(self, quantity: str, values: Array) -> None:
        if quantity != self.grasp.air.quantity:
            raise ValueError(
                f"strategy: expected commands of {self.grasp.air.quantity}, got {quantity}; "
                f"make the environment with air={quantity!r}"
            )
        self._air = np.where(np.isnan(values), self._air, values)

    def hold_object(self, position: Array, orientation: Array) -> None:
        raise SceneError(
            "strategy: expected one without `hold_object`, which the environment does not support"
        )

    def release_object(self, duration: float) -> None:
        raise SceneError(
            "strategy: expected one without `hold_object`, which the environment does not support"
        )

    def vent(self) -> None:
        self._air = np.zeros_like(self._air)

    def step(self, duration: float) -> None:
        if self._over:
            raise SceneError("the episode is over")
        action = self._action()
        _, reward, terminated, truncated, self.episode.info = self._env.step(action)
        self.episode.reward += float(reward)
        self.episode.actions.append(action)
        self._over = terminated or truncated

    def _action(self) -> Array:
        """The action that takes the wrist's target where it is commanded, as far as it can."""
        now, goal, time = self.grasp.target, self._target, self.grasp.action_time
        turn = rotation_of(compose(goal.orientation, inverse(now.orientation)))
        numbers = [
            *self.grasp.air.numbers(self._air),
            *(goal.position - now.position) / (WRIST_SPEED * time),
            *turn / (WRIST_TURN_SPEED * time),
        ]
        return np.clip(numbers, -1.0, 1.0, dtype=np.float32)

    def observe(self) -> Observation:
        return self.grasp.seen
