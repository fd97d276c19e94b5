"""One session at the simulated bench: nodes up, protocols played, everything in one bag."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING

from softhand_bringup import suite
from softhand_bringup.environment import node_environment
from softhand_bringup.lab_story.measuring import Measurement, Plan, air_course
from softhand_bringup.launcher import Launcher, ParameterValue
from softhand_model.actuator import Actuator
from softhand_model.hands import load_hand

if TYPE_CHECKING:
    from softhand_bringup.lab_story.node import Commander

HAND = "single_finger"
FINGER = "finger"  # chain and actuator of that hand
STATE, ANGLES, RESIDUAL = "/pneumaticbox/state", "/hand/tip_angles", "/model/residual"
RECORDED = ("/clock", STATE, ANGLES, RESIDUAL)
STEP = 0.005  # physics step [s]: the finger settles within 50 ms, and the bench runs fast
START_LIMIT = 90.0  # [s] of wall time; the first start compiles
RECORDER_LIMIT = 20.0  # [s]
STALL_LIMIT = 30.0  # wall time without a tick of the simulated clock [s]
WARM_UP = 1.0  # simulated time in which the driver averages its sensors [s]
BEFORE = 0.5  # simulated time at rest with which a run begins [s]
TARES, TARE_PERIOD = 10, 0.2  # how often taring is tried, simulated time between two [s]
# when the monitor takes the finger to be settled: later than by default, for it is to be exact
SETTLING: dict[str, ParameterValue] = {"settle_time": 0.2, "settle_band": 500.0}


class StoryFailed(RuntimeError):
    """The story cannot go on; the message says why."""


class Interrupted(Exception):
    """Somebody pressed Ctrl-C."""


@dataclass(frozen=True)
class Played:
    """A run as it was played: name, protocol, start and end in simulated time [s]."""

    name: str
    protocol: str
    start: float
    end: float


def finger() -> Actuator:
    """The actuator on the bench."""
    return load_hand(HAND).chain(FINGER).actuators[FINGER]


@dataclass
class Session:
    """A finger with a model in the simulator, watched by a monitor with another.

    Args:
        folder: gets bag/ and log/.
        plan: what is played.
        truth: model file of the simulator.
        model: model file, or shipped name, of the monitor.
        seed: of the sensors' noise and the valves' jitter.
        say: prints one line.
        stopped: set when the user wants to end.
    """

    folder: Path
    plan: Plan
    truth: Path
    model: str
    seed: int
    say: Callable[[str], None]
    stopped: Event = field(default_factory=Event)

    @property
    def bag(self) -> Path:
        """The bag of the session."""
        return self.folder / "bag"

    def run(self) -> list[Played]:
        """Play the plan; the runs in their order.

        Raises:
            StoryFailed: something did not start, or simulated time stands still.
            NodeDied: a process ended by itself.
            Interrupted: `stopped` was set.
        """
        options = suite.SuiteOptions(
            hand=HAND, scene="stand", model=str(self.truth), seed=self.seed, step=STEP
        )
        log = self.folder / "log"
        with Launcher(log, node_environment(log)) as launcher:
            launcher.start(suite.recorder(self.bag, RECORDED))
            launcher.start(suite.simulator(options))
            launcher.start(suite.driver(options))
            launcher.start(suite.monitor(replace(options, model=self.model), SETTLING))
            return self._play(launcher)

    def _play(self, launcher: Launcher) -> list[Played]:
        # imported late: with --help nobody should wait for ROS
        from softhand_bringup.lab_story.node import Commander

        channel = load_hand(HAND).channels[0]
        with Commander(channel, RECORDED) as commander:
            self._wait_for_nodes(commander, launcher)
            self._let_pass(commander, launcher, WARM_UP)
            played = []
            for repeat in range(1, self.plan.repeats + 1):
                for measurement in self.plan.measurements:
                    run = self._run(commander, launcher, measurement, repeat)
                    told = commander.told.get(f"monitor: {FINGER}", "no word from the monitor")
                    self.say(f"{run.start:6.1f} s  {run.name:<16} monitor: {told}")
                    played.append(run)
            return played

    def _run(
        self, commander: Commander, launcher: Launcher, measurement: Measurement, repeat: int
    ) -> Played:
        """Rest with open outlets, so that memory fades at ambient pressure, and play one run."""
        commander.vent()
        self._let_pass(commander, launcher, self.plan.rest)
        commander.reset()
        start = commander.simulated_time
        self._let_pass(commander, launcher, BEFORE)
        self._tare(commander, launcher)
        commander.command(air_course(finger(), measurement))
        self._let_pass(commander, launcher, measurement.duration)
        name = f"{measurement.protocol}_{repeat}"
        return Played(name, measurement.protocol, start, commander.simulated_time)

    def _tare(self, commander: Commander, launcher: Launcher) -> None:
        """Zero the estimate of the air mass, which drifts while the outlets are open."""
        for _ in range(TARES):
            if commander.tare():
                return
            self._let_pass(commander, launcher, TARE_PERIOD)
        raise StoryFailed("the driver cannot be tared: the pressure does not stand still at rest")

    def _wait_for_nodes(self, commander: Commander, launcher: Launcher) -> None:
        end = time.monotonic() + START_LIMIT
        while missing := commander.missing():
            self._check(launcher)
            if time.monotonic() > end:
                raise StoryFailed(f"not there after {START_LIMIT:.0f} s: {', '.join(missing)}")

    def _let_pass(self, commander: Commander, launcher: Launcher, duration: float) -> None:
        """Let so much simulated time [s] pass."""
        end, wall, before = commander.simulated_time + duration, time.monotonic(), -1.0
        while commander.simulated_time < end:
            self._check(launcher)
            if commander.simulated_time != before:
                before, wall = commander.simulated_time, time.monotonic()
            if commander.simulators() > 1:
                raise StoryFailed(
                    "another simulator runs in this ROS domain: end it, or set ROS_DOMAIN_ID"
                )
            if time.monotonic() - wall > STALL_LIMIT:
                raise StoryFailed(f"simulated time has stood still for {STALL_LIMIT:.0f} s")
            commander.spin(0.02)

    def _check(self, launcher: Launcher) -> None:
        launcher.check()
        if self.stopped.is_set():
            raise Interrupted
