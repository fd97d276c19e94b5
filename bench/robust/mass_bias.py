"""Bias of the estimated air masses over many vents, releases and grasps, against the plant.

    python -m bench.robust.mass_bias --minutes 30

The driver without ROS runs on two plants in process: on the simulator, where a hand grasps an
object, releases it against the table and is vented now and then, and on the simulated box with
the hand's actuators, sound and with sensors worse than their class. The plant knows how much air
there is; the judge holds the driver's estimate against it whenever the hand rests.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.row import at_least, at_most, stated
from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.scene import Observation, SceneError
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import load_strategy
from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.world import solver_settings
from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.observer.zeroing import Zeroing
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.chain.volumes import FreeActuators
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.pneumatics import Pneumatics, load_pneumatics
from softhand_trials.trials import draw_placement

Array = NDArray[np.float64]

HAND, STRATEGY = "rbo_hand_2", "surface_constrained"
MG = 1e-6
LARGEST_BIAS = 1.0  # [mg]
PERIOD = 2e-3  # of the samples [s]
REST = 3.0  # after which a released hand is at rest [s]
VENT_EVERY = 3  # grasps
SHARE_OF_SIMULATOR = 0.5  # of the simulated time; the rest is the simulated box's
# A poor sensor: twice its class at ambient pressure, which the zero band still holds, three times
# its noise; while the hand works its offset wanders about as by 10 K.
POOR_OFFSET, POOR_NOISE, WANDER, WANDER_PERIOD = 1750.0, 3.0, 400.0, 120.0  # [Pa], [-], [Pa], [s]


def hand_box(hand: HandDescription) -> PneumaticBox:
    """The driver's box for a hand, all channels in mode mass."""
    n = len(hand.channels)
    settings = BoxSettings(
        tuple(hand.channels),
        tuple(np.asarray(hand.rest_volumes()).tolist()),
        tuple(np.asarray(hand.max_pressures()).tolist()),
        ("mass",) * n,
        volume_model="hand",
        hand=hand.name,
    )
    return PneumaticBox(settings, load_calibration(None, n))


def let_run_away(box: PneumaticBox) -> None:
    """Make a box as it must not be: what is empty when its outlet opens is never zeroed again."""
    zeroing = box.zeroing

    class RunsAway(Zeroing):
        def look(self, dt: float, pressures_abs: Array, valves: NDArray[np.int8]) -> None:
            if self.ready and (valves < 0).all():
                return
            super().look(dt, pressures_abs, valves)

    zeroing.__class__ = RunsAway


@dataclass
class Judge:
    """Collects what the estimates were off, over kinds of rest [kg], and the lowest of them."""

    biases: dict[str, list[Array]] = field(default_factory=dict)
    lowest: float = math.inf

    def look(self, kind: str, estimate: Array, truth: Array) -> None:
        """Hold estimates (n,) against the truth (n,) [kg] at a rest of some kind."""
        self.biases.setdefault(kind, []).append(estimate - truth)

    def follow(self, estimate: Array) -> None:
        """Take the estimates (n,) [kg] of any instant."""
        self.lowest = min(self.lowest, float(estimate.min()))

    def worst(self, kind: str) -> float:
        """Largest bias at the rests of a kind, of any channel [mg]; NaN without one."""
        return max((float(np.abs(b).max()) for b in self.biases[kind]), default=math.nan) / MG


class BoxedScene(InProcessScene):
    """The scene of a strategy with the driver's box in between, as over ROS.

    Args:
        simulation: with plant and hand.
        judge: follows the estimates.
    """

    def __init__(self, simulation: Simulation, judge: Judge) -> None:
        super().__init__(simulation)
        self.box = hand_box(simulation.hand)
        self._judge = judge
        self._valves = self.box.valves
        self._rest = simulation.plant.rest_mass(simulation.air.rest_volumes)

    @property
    def truth(self) -> Array:
        """Air that the plant has in the channels above rest (n,) [kg]."""
        return np.asarray(self.simulation.plant.mass - self._rest)

    def command_air(self, masses: Array) -> None:
        """Command air masses (n,) [kg]."""
        point = TrajectoryPoint(0.0, positions=masses.tolist())
        self.box.command(self.channels, [point], 0.0, self.box.time)

    def vent(self) -> None:
        """Open every outlet until reset."""
        self.box.vent()

    def step(self, duration: float) -> None:
        """Simulate `duration` [s]; raises SceneError when the simulation diverges."""
        simulation = self.simulation
        for _ in range(max(1, round(duration / simulation.step_size))):
            try:
                simulation.step(self._valves)
            except RuntimeError as error:
                raise SceneError(str(error)) from error
            self._valves = self.box.on_sample(simulation.time, simulation.read_sensors())
            self._judge.follow(self.box.observer.mass)

    def observe(self) -> Observation:
        """Return the state now, air by the driver's estimate."""
        seen = super().observe()
        return replace(seen, air_mass=self.box.observer.mass.copy(), pressure=self.box.pressures)

    def judge(self, kind: str) -> None:
        """A rest of this kind is reached."""
        self._judge.look(kind, self.box.observer.mass, self.truth)


def grasps(minutes: float, judge: Judge, seed: int = 0) -> int:
    """Grasp and release until `minutes` have passed in the simulator; returns how many grasps.

    Each has an object of its own place and mass; every third time the hand is vented afterwards,
    for a while that is drawn from the seed.
    """
    strategy, count, passed = load_strategy(STRATEGY), 0, 0.0
    drawn = np.random.default_rng(seed)
    while passed < 60.0 * minutes:
        offset, mass_scale = draw_placement(seed + count)
        scene = BoxedScene(
            Simulation(
                SimulationConfig(
                    hand=strategy.hand,
                    step=PERIOD,
                    seed=seed + count,
                    object_offset=offset,
                    object_mass_scale=mass_scale,
                    solver=solver_settings("default"),
                )
            ),
            judge,
        )
        scene.step(1.0)
        Sequencer(
            scene, strategy, options=strategy.options, on_phase=_judge_hold(scene, judge)
        ).run()
        scene.step(REST)
        scene.judge("released")
        if count % VENT_EVERY == 0:
            _vent(scene, float(drawn.uniform(3.0, 15.0)))
        passed += scene.time
        count += 1
        scene.close()
    return count


def _judge_hold(scene: BoxedScene, judge: Judge) -> Callable[[str], None]:
    """At the beginning of the phase `lower` the hand has held the object for a while."""
    return lambda phase: scene.judge("holding") if phase == "lower" else None


def _vent(scene: BoxedScene, duration: float) -> None:
    scene.vent()
    scene.step(2.0)
    scene.judge("vented")
    scene.step(duration)
    scene.judge("vented")
    scene.box.reset()
    scene.step(1.0)
    scene.judge("reset")


class BenchCycles:
    """Fill, empty, vent and reset on the simulated box.

    Args:
        judge: of the estimates.
        poor: whether the sensors are worse than their class.
        sound: False for a box whose estimates run away.
        seed: of noise, targets and durations.
    """

    def __init__(self, judge: Judge, poor: bool = False, sound: bool = True, seed: int = 0) -> None:
        hand = load_hand(HAND)
        self.box, self._judge, self._poor = hand_box(hand), judge, poor
        self.bench = EmbeddedRig(hand.channels, FreeActuators(hand), _constants(poor), seed)
        if not sound:
            let_run_away(self.box)
        self._drawn = np.random.default_rng(seed)
        n = len(hand.channels)
        self._offsets = np.append(POOR_OFFSET * self._drawn.uniform(-1, 1, n), 0.0) * poor
        self._phases = np.append(self._drawn.uniform(0, 2 * np.pi, n), 0.0)
        self.run(1.5)

    def run(self, duration: float) -> None:
        """Let time [s] pass."""
        box, bench, wander = self.box, self.bench, WANDER * self._poor
        scale = np.append(np.ones(len(bench.mass)), 0.0)
        for _ in range(round(duration / PERIOD)):
            angle = 2 * np.pi * bench.time / WANDER_PERIOD + self._phases
            off = self._offsets + wander * scale * np.sin(angle)
            bench.command(box.on_sample(bench.time, bench.advance(PERIOD) + off))
            self._judge.follow(box.observer.mass)

    def cycle(self) -> None:
        """Fill, hold, empty, vent, reset, and fill again."""
        drawn, channels = self._drawn, self.box.settings.channels
        for kind, masses in (("holding", drawn.uniform(10, 22, len(channels))), ("released", None)):
            wanted = [0.0] * len(channels) if masses is None else (MG * masses).tolist()
            point = TrajectoryPoint(0.0, positions=wanted)
            self.box.command(channels, [point], 0.0, self.box.time)
            self.run(3.0)
            self.judge(kind)
            if masses is not None and drawn.uniform() < 0.5:
                break
        self.box.vent()
        for _ in range(2):
            self.run(float(drawn.uniform(1.5, 10.0)))
            self.judge("vented")
        self.box.reset()
        self.run(0.5)
        self.judge("reset")

    def judge(self, kind: str) -> None:
        """A rest of this kind is reached."""
        self._judge.look(kind, self.box.observer.mass, self.bench.mass)


def _constants(poor: bool) -> Pneumatics:
    constants = load_pneumatics()
    if not poor:
        return constants
    sensor = constants.channel_sensor
    return replace(constants, channel_sensor=replace(sensor, noise=POOR_NOISE * sensor.noise))


def cycles(minutes: float, judge: Judge, **options: Any) -> None:
    """Run `BenchCycles` of some options for so many simulated minutes."""
    run = BenchCycles(judge, **options)
    while run.bench.time < 60.0 * minutes:
        run.cycle()


def run(minutes: float = 30.0, seed: int = 0) -> list[dict[str, Any]]:
    """Rows of simulator, bench, bench with poor sensors, and of a box that runs away.

    Args:
        minutes: simulated, in all.
        seed: of objects' places, targets, durations and noise.
    """
    on_bench = minutes * (1 - SHARE_OF_SIMULATOR) / 2
    judges = {name: Judge() for name in ("simulator", "bench", "poor sensors", "control")}
    count = grasps(minutes * SHARE_OF_SIMULATOR, judges["simulator"], seed)
    cycles(on_bench, judges["bench"], seed=seed)
    cycles(on_bench, judges["poor sensors"], poor=True, seed=seed)
    cycles(min(2.0, minutes), judges["control"], sound=False, seed=seed)
    rows = [stated("grasps of the mass bias", count, "")]
    for name in ("simulator", "bench", "poor sensors"):
        rows += _rows(name, judges[name])
    runaway = judges["control"].worst("vented")
    return [
        *rows,
        at_least("bias of a box that lets it run away (control)", runaway, "mg", LARGEST_BIAS),
    ]


def _rows(name: str, judge: Judge) -> list[dict[str, Any]]:
    rows = [
        at_most(f"mass bias, {name}, {kind}", judge.worst(kind), "mg", LARGEST_BIAS)
        for kind in judge.biases
    ]
    lowest = judge.lowest / MG
    return [*rows, at_least(f"lowest mass, {name}", lowest, "mg", -LARGEST_BIAS)]


def main(arguments: list[str] | None = None) -> int:
    """Print the rows; exit status 1 if one misses its target."""
    parser = argparse.ArgumentParser(prog="bench.robust.mass_bias", description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0, help="simulated (default: 30)")
    rows = run(parser.parse_args(arguments).minutes)
    for row in rows:
        print(f"{row['name']:52} {row['value']:9.2f} {row['unit']:3} {row['target'] or ''}")
    return 1 if any(row["met"] is False for row in rows) else 0


if __name__ == "__main__":
    raise SystemExit(main())
