"""Friction of the simulator: as strong in all directions, a patch that resists twisting, no run
that diverges where fingertips jam between table and object, and what it costs.

Criteria and seeds were chosen before friction was changed. PyBullet's own pyramid of two directions
is the negative control.
"""

from __future__ import annotations

import math
import statistics
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import Any
from unittest import mock

import numpy as np

from bench.row import at_least, at_most, stated
from bench.sim import random_trials
from bench.sim.timing import timed_steps
from pneuflex_sim.bullet import pybullet
from pneuflex_sim.engines import pybullet_engine
from pneuflex_sim.hand import layout
from pneuflex_sim.hand.collision import SKIN_PATCH
from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.world import World
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_trials.trials import TrialSettings, run_trial, started_scene

BOX, STEP = "tape_dispenser", 0.002  # [s]
DIRECTIONS = (0.0, 22.5, 45.0)  # [deg] of the push against the engine's axes
EVEN, UNEVEN = 3.0, 30.0  # [%]: largest difference between directions; least of the pyramid
TRY = 0.3  # [s] of pushing with one force
MOVED = 1e-4  # [m] in that time
TWIST = 5.0  # [%]: largest error of the moment of a patch
BALL_MASS, BALL_RADIUS = 0.05, 0.02  # [kg], [m]
JAMMED = {0.005: 60, 0.002: 16, 0.001: 8}  # trials by step [s]
JAM_SEED, JAM_HEIGHTS = 1000, (0.10, 0.15)  # [m] of the wrist: fingertips press on the table
SLOWER = 10.0  # [%] of a step's time more than with the pyramid
LIGHT = (
    0.25  # of the links' added inertia: so fingertips diverge, with the pyramid and with the cone
)
TURNS = 8  # with the pyramid and as shipped, in turn


class Pyramid(World):
    """A world with PyBullet's own friction."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        pybullet.setPhysicsEngineParameter(enableConeFriction=0, physicsClientId=self.client)


@contextmanager
def pyramid() -> Iterator[None]:
    """Simulations made within the block have PyBullet's pyramid."""
    with mock.patch.object(pybullet_engine, "World", Pyramid):
        yield


def threshold(moves: Callable[[float], bool], high: float) -> float:
    """Smallest of the loads up to `high` that moves, within 0.2 % of `high`, by halving."""
    low, ends = 0.0, 0.002 * high
    while high - low > ends:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if moves(middle) else (middle, high)
    return 0.5 * (low + high)


def sliding_force(degrees: float) -> float:
    """Force over weight [-] at which a box on the table slides, pushed level at an angle."""
    world = Simulation(SimulationConfig(object=BOX, step=STEP, segments=2))
    heading = np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees)), 0.0])

    def moves(share: float) -> bool:
        world.reset()
        _run(world, np.zeros(3), 0.1)
        start = world.object_pose()[0]
        _run(world, share * STANDARD_GRAVITY * world.object_mass * heading, TRY)
        return float(np.linalg.norm((world.object_pose()[0] - start)[:2])) > MOVED

    try:
        return threshold(moves, 1.0)
    finally:
        world.close()


def _run(world: Simulation, force: np.ndarray, duration: float) -> None:
    for _ in range(round(duration / world.step_size)):
        world.push_object(force)
        world.step()


def unevenness() -> tuple[list[float], float]:
    """Sliding force over weight [-] by direction, and the largest difference [%] between them."""
    forces = [sliding_force(degrees) for degrees in DIRECTIONS]
    return forces, 100.0 * (max(forces) / min(forces) - 1.0)


def sliding_rows() -> list[dict[str, Any]]:
    """Sliding in three directions, and with the pyramid."""
    forces, uneven = unevenness()
    with pyramid():
        _, control = unevenness()
    expected = load_friction().pair("polyolefin", "wood")
    names = [f"box slides, pushed at {degrees:g} deg" for degrees in DIRECTIONS]
    return [
        *(
            stated(f"{name}: force over mu m g", force / expected, "")
            for name, force in zip(names, forces, strict=True)
        ),
        at_most("box slides: largest difference of directions", uneven, "%", EVEN),
        at_least("control, pyramid: largest difference of directions", control, "%", UNEVEN),
    ]


def twisting_moment(world: Simulation) -> float:
    """Moment over normal force [m] at which a ball turns on another one, with the surfaces that a
    link of a finger and an object have in a simulation.
    """
    engine = world.engine
    if not isinstance(engine, pybullet_engine.PybulletEngine):
        raise TypeError(f"engine: expected pybullet, got {type(engine).__name__}")
    found = [
        pybullet.getDynamicsInfo(*surface, physicsClientId=engine.world.client)
        for surface in ((engine.bodies.ids[0], 2), (engine.object_id, -1))
    ]
    other = World(STEP)
    try:
        return _twist_that_turns(other, found)
    finally:
        other.close()


def _twist_that_turns(world: World, surfaces: list[tuple[Any, ...]]) -> float:
    client = {"physicsClientId": world.client}
    pybullet.setGravity(0.0, 0.0, -STANDARD_GRAVITY, **client)
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=BALL_RADIUS, **client)
    bodies = [
        pybullet.createMultiBody(mass, shape, basePosition=(0.0, 0.0, height), **client)
        for mass, height in ((0.0, 0.0), (BALL_MASS, 2.0 * BALL_RADIUS))
    ]
    for body, found in zip(bodies, surfaces, strict=True):
        soft = {} if found[9] <= 0 else {"contactStiffness": found[9], "contactDamping": found[8]}
        pybullet.changeDynamics(
            body,
            -1,
            lateralFriction=found[1],
            rollingFriction=found[6],
            spinningFriction=found[7],
            angularDamping=0.0,
            **soft,
            **client,
        )
    start = pybullet.saveState(**client)

    def moves(moment: float) -> bool:
        pybullet.restoreState(start, **client)
        for count in range(200):
            if count >= 100:
                pybullet.applyExternalTorque(
                    bodies[1], -1, (0.0, 0.0, moment), pybullet.WORLD_FRAME, **client
                )
            pybullet.stepSimulation(**client)
        return abs(pybullet.getBaseVelocity(bodies[1], **client)[1][2]) > 0.05

    return threshold(moves, BALL_MASS * STANDARD_GRAVITY * 1e-2) / (BALL_MASS * STANDARD_GRAVITY)


def twist_rows() -> list[dict[str, Any]]:
    """The moment of a patch against 3 pi/16 mu N a, that of Hertz's pressure on a circle of radius
    a (a uniform pressure on it would give 2/3 mu N a).
    """
    world = Simulation(SimulationConfig(hand="single_finger", object="ball", scene="held"))
    try:
        found = twisting_moment(world)
    finally:
        world.close()
    mu = load_friction().pair("pvc", "rubber")
    expected = 3.0 * math.pi / 16.0 * mu * SKIN_PATCH
    error = 100.0 * abs(found / expected - 1.0)
    return [
        stated("twist of an object on a finger: moment over normal force", 1e3 * found, "mm"),
        at_most("twist of an object on a finger: off 3 pi/16 mu a", error, "%", TWIST),
    ]


def jammed(seed: int, step: float) -> str:
    """A random trial with the hand pressed down on table and object; empty, or why it failed."""
    draw = np.random.default_rng(seed)
    config = SimulationConfig(
        object=str(draw.choice(random_trials.OBJECTS)),
        step=step,
        segments=int(draw.choice((5, 10))),
        object_offset=tuple(draw.uniform(-0.02, 0.02, 2).tolist()),
        friction_scale=float(draw.uniform(0.7, 1.5)),
    )
    world = Simulation(config)
    try:
        commands = random_trials.RandomCommands(world, draw, JAM_HEIGHTS)
        while world.time < random_trials.DURATION:
            commands.give()
            world.step()
            height = world.object_pose()[0][2]
            if not -0.03 < height < random_trials.FAR:
                return f"seed {seed}: the object is at a height of {height:.2f} m"
    except RuntimeError as error:
        return f"seed {seed}: {error}"
    finally:
        world.close()
    return ""


def jam_rows(small: bool) -> list[dict[str, Any]]:
    """Trials with jammed fingertips that failed, by step."""
    found = []
    for step, count in JAMMED.items():
        count = max(1, count // 10) if small else count
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of joints at their stops: meant here
            seeds = range(JAM_SEED, JAM_SEED + count)
            failures = [text for seed in seeds if (text := jammed(seed, step))]
        for text in failures:
            print(f"  {1e3 * step:g} ms: {text}", flush=True)
        name = f"fingertips jammed between table and object, {1e3 * step:g} ms"
        found.append(at_most(f"{name}: failed", len(failures), f"of {count}", 0))
    return [*found, *light_rows(small)]


def light_rows(small: bool) -> list[dict[str, Any]]:
    """Jammed fingertips on links with less added inertia, as a control: what makes them diverge is
    not the cone.
    """
    seeds = range(JAM_SEED, JAM_SEED + (8 if small else 20))
    name, rows = "control, a quarter of the added inertia, 5 ms", []
    with (
        mock.patch.object(layout, "ADDED_INERTIA", LIGHT * layout.ADDED_INERTIA),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore", RuntimeWarning)
        for friction, world in (("cone", nullcontext), ("pyramid", pyramid)):
            with world():
                failed = sum(bool(jammed(seed, 0.005)) for seed in seeds)
            rows.append(at_least(f"{name}, {friction}: failed", failed, f"of {len(seeds)}", 1))
    return rows


def time_rows(small: bool) -> list[dict[str, Any]]:
    """CPU time of a step in a grasp over that with the pyramid, measured in turn."""
    settings = TrialSettings(step=0.005)
    ratios = []
    for turn in range(1 if small else TURNS):
        with pyramid():
            before = _step_time(settings, 2 * turn)
        ratios.append(_step_time(settings, 2 * turn) / before)
    slower = 100.0 * (statistics.median(ratios) - 1.0)
    return [at_most("time of a step in a grasp, more than with the pyramid", slower, "%", SLOWER)]


def _step_time(settings: TrialSettings, seed: int) -> float:
    started_scene.cache_clear()
    with timed_steps() as times:
        run_trial(seed, settings)
    return statistics.fmean(times.whole)


def rows(small: bool) -> list[dict[str, Any]]:
    """All rows of friction."""
    return [*sliding_rows(), *twist_rows(), *jam_rows(small), *time_rows(small)]
