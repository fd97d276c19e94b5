"""The environment: a hand on a compliant wrist over a table with an object."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.judging.judge import OUTCOME_GRIPPED
from grasp_strategies.pose import Pose
from grasp_strategies.scene import Array
from grasp_strategies.sequencer import CONTROL_STEP
from grasp_strategies.strategy import Success
from pneuflex_sim.engines import default_engine
from pneuflex_sim.scene.scenes import SceneDescription
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.numerics.rotations import compose
from softhand_gym.hold import HoldWatch
from softhand_gym.randomisation import Randomisation, drawn
from softhand_gym.signals import MASS_COMMAND, AirScale, Sight, turn_of
from softhand_model.model_file import Model, load_model
from softhand_model.usual_step import USUAL_STEP
from softhand_trials.trials import Placement

WRIST_SPEED, WRIST_TURN_SPEED = 0.5, 2.0  # of an action of 1 along or about one axis [m/s, rad/s]
WORKSPACE = np.array([[-0.5, -0.5, -0.1], [0.5, 0.5, 0.7]])  # corners, of commanded poses [m]


class GraspEnv(gymnasium.Env[dict[str, Any], Any]):
    """An episode lasts until an object has been held, is lost, or `time_limit` is over.

    Action: Box (channels + 6,), each number -1 to 1.

    * Channels, in the order of the hand: air to reach, from none at -1 to full at 1. "Full" is the
      pressure limit of the channel [Pa], or the air [kg] with which the free hand has that
      pressure. Chokes and tubes limit how fast; a channel above its limit is relieved.
    * Velocity of the wrist's target along the world's x, y, z, in units of 0.5 m/s, then its spin
      about them, in units of 2 rad/s. Targets stay in a box of 1.0 x 1.0 x 0.8 m.

    Observation: Dict of Boxes, the same as over ROS; `gymnasium.wrappers.FlattenObservation` makes
    one of them.

    * `pressure`, `air_mass` (channels,), in units of full [-], gauge and above the fill at rest.
    * `wrist_position`, `object_position` (3,) [m], `wrist_orientation`, `object_orientation` (4,),
      quaternions (x, y, z, w), in the world.
    * `wrist_force` (3,) [N], of the hand on the wrist, in world axes.
    * `touching` (bodies,), 1 for those that press on the object: those of `touching_names`.

    Reward: by how much the share of the lift plus the share of the hold has grown since the last
    action. The sum of an episode is 2 for a grasp that is held through, near 1 for an object that
    is carried at the end, 0 for one that lies on the table.

    Info: `outcome` (`gripped`, `lost`, `none`), `is_success`, `reason`, `time`, `hold_time` [s],
    `lift_height` [m].

    Args:
        object, hand, scene: names or files.
        model: name or file of the model; parameters for which it has standard errors are drawn in
            each episode, unless `randomisation` says otherwise. Each such episode builds a new
            simulation.
        engine: `pybullet` or `mujoco`; None: PyBullet where it is installed.
        step: physics step [s].
        action_time: how long an action lasts [s].
        time_limit: simulated time after which an episode is truncated [s].
        air: quantity that is commanded to the channels, `air_mass` or `pressure`.
        success: criteria by which an object counts as held.
        randomisation: what is drawn in each episode; `reset(seed=...)` repeats all of it, bit for
            bit.
        render_mode: None or `rgb_array`, which needs PyBullet.

    Raises:
        ValueError: names that do not exist, or times that do not fit each other.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}  # noqa: RUF012

    def __init__(
        self,
        object: str = "cylinder",
        hand: str = "rbo_hand_2",
        scene: str = "table",
        model: str | Path | None = None,
        engine: str | None = None,
        step: float = USUAL_STEP,
        action_time: float = 0.05,
        time_limit: float = 15.0,
        air: str = MASS_COMMAND,
        success: Success | None = None,
        randomisation: Randomisation | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode: expected None or rgb_array, got {render_mode!r}")
        if not time_limit > 0.0:
            raise ValueError(f"time_limit: expected a time above 0 [s], got {time_limit!r}")
        self.metadata = self.metadata | {"render_fps": round(1.0 / action_time)}
        self._model = load_model(model)
        self._config = SimulationConfig(
            hand=hand,
            object=object,
            scene=scene,
            model=self._model,
            step=step,
            engine=engine or default_engine(),
        )
        self.action_time, self.time_limit, self.render_mode = action_time, time_limit, render_mode
        self._object = object
        self._pieces = _pieces(action_time, step)
        self._renderer: Any = None
        self.success = success or Success()
        self.randomisation = randomisation or Randomisation()
        self._build(self._model)
        self.air = AirScale(air, self.scene.simulation.hand)
        self._sight = Sight(self.air, self.scene.hand_bodies, _parts(self.scene.simulation.scene))
        self.touching_names = self._sight.touching_names
        self.observation_space = self._sight.space
        self._numbers = len(self.scene.channels) + 6
        self.action_space = spaces.Box(-1.0, 1.0, (self._numbers,), np.float32)

    def _build(self, model: Model) -> None:
        """A new simulation, and the snapshot of its start."""
        self.scene = InProcessScene(Simulation(replace(self._config, model=model)))
        self._start = self.scene.save()

    # ---------------------------------------------------------------- episodes
    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Array], dict[str, Any]]:
        """Begin an episode. `options` are fields of `Placement` that are not drawn: `offset` [m],
        `mass_scale` [-], `yaw` [rad], `friction_scale` [-]; raises ValueError for others.
        """
        super().reset(seed=seed)
        placement = self._placed(self.randomisation.placement(self.np_random), options or {})
        if self.randomisation.draws(self._model):
            self.scene.close()
            self._build(drawn(self._model, self.np_random))
        elif self.scene.simulation.engine.broken:
            self.scene.close()
            self._build(self._model)
        self.scene.restart(self._start, **vars(placement))
        self.seen = self.scene.observe()
        self.target = self.seen.wrist
        self._watch = HoldWatch(self.success, self.scene.hand_bodies, self.seen)
        return self._sight.look(self.seen), self._info()

    @staticmethod
    def _placed(placement: Placement, options: dict[str, Any]) -> Placement:
        unknown = sorted(set(options) - set(vars(placement)))
        if unknown:
            raise ValueError(
                f"options: expected some of {', '.join(vars(placement))}, got {', '.join(unknown)}"
            )
        return replace(placement, **options)

    def step(self, action: Array) -> tuple[dict[str, Array], float, bool, bool, dict[str, Any]]:
        """Let an action act for `action_time` [s]; numbers outside of -1 to 1 are clipped. A
        simulation that diverges ends the episode without a grasp.

        Raises ValueError for an action of another shape, and for numbers that are not finite.
        """
        given = np.asarray(action, float)
        if given.shape != (self._numbers,) or not np.isfinite(given).all():
            raise ValueError(f"action: expected {self._numbers} finite numbers, got {action}")
        before, given = self._watch.merit, np.clip(given, -1.0, 1.0)
        self.air.command(self.scene, given[:-6])
        velocity, spin = WRIST_SPEED * given[-6:-3], WRIST_TURN_SPEED * given[-3:]
        try:
            for _ in range(self._pieces):
                self._move(velocity, spin, self.action_time / self._pieces)
                if self._watch.over:
                    break
        except RuntimeError as error:  # of the simulation: it diverged
            info = self._info() | {"reason": str(error)}
            return self._sight.look(self.seen), -before, True, False, info
        reward = self._watch.merit - before
        late = self.scene.time > self.time_limit - 1e-9
        info = self._info()
        return self._sight.look(self.seen), reward, self._watch.over, late, info

    def _move(self, velocity: Array, spin: Array, duration: float) -> None:
        """Move the target for a duration [s] at a velocity [m/s] and a spin [rad/s]; let it act."""
        place = np.clip(self.target.position + duration * velocity, *WORKSPACE)
        turn = compose(turn_of(duration * spin), self.target.orientation)
        self.target = Pose(place, turn)
        self.scene.command_wrist(place, turn)
        self.scene.step(duration)
        self.seen = self.scene.observe()
        self._watch.watch(self.seen)

    def _info(self) -> dict[str, Any]:
        watch = self._watch
        return {
            "outcome": watch.outcome,
            "is_success": watch.outcome == OUTCOME_GRIPPED,
            "reason": watch.reason,
            "time": self.seen.time,
            "hold_time": watch.hold_time,
            "lift_height": watch.lift_height,
        }

    def render(self) -> Any:
        """A picture (480, 640, 3), height and width first, of the present state in the mode
        `rgb_array`; else None.
        """
        if self.render_mode is None:
            return None
        from pneuflex_sim.pictures.render import HandState, Renderer  # needs PyBullet

        simulation, seen = self.scene.simulation, self.seen
        if self._renderer is None:
            config = self._config
            self._renderer = Renderer(
                simulation.hand, self._object, simulation.scene, config.segments
            )
        poses = (seen.wrist_position, seen.wrist_orientation)
        objects = (seen.object_position, seen.object_orientation)
        return self._renderer.frame(HandState(simulation.bodies.q, *poses, *objects))

    def close(self) -> None:
        """Free the simulation."""
        self.scene.close()


def _pieces(action_time: float, step: float) -> int:
    """Into how many parts an action is cut: the judge looks as often as that of strategies."""
    pieces = max(1, int(action_time / max(CONTROL_STEP, step) + 1e-9))
    steps = action_time / (pieces * step)
    if not action_time > 0.0 or abs(steps - round(steps)) > 1e-6:
        raise ValueError(
            f"action_time: expected a multiple of {max(CONTROL_STEP, step):g} s, or a shorter time "
            f"that is a multiple of the physics step, {step:g} s; got {action_time!r}"
        )
    return pieces


def _parts(scene: SceneDescription) -> tuple[str, ...]:
    """What of the surroundings an object can touch."""
    return tuple(name for name in ("table", "wall") if getattr(scene, name) is not None)
