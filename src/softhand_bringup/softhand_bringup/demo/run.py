"""One run of the demo: start everything, grasp, stop everything, judge, draw.

One run of the demo: start everything, grasp, stop everything, draw.
"""

from __future__ import annotations

import json
import math
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING

from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher, wait_until
from softhand_bringup.processes.suite import node_environment
from softhand_bringup.processes.waiting import START_LIMIT, Interrupted

if TYPE_CHECKING:
    from softhand_bringup.ros.demo_link import GraspClient

REPORTED_PACKAGES = (
    "softhand_model",
    "pneuflex_sim",
    "pneumaticbox_driver",
    "grasp_strategies",
    "softhand_bringup",
    "ros-jazzy-rclpy",
    "pybullet",
    "numpy",
    "scipy",
    "numba",
)


@dataclass(frozen=True)
class Verdict:
    """Outcome of one grasp in SI units.

    Args:
        gripped: lifted by 100 mm and held for 1 s with nothing but the hand touching the object.
        reason: the sequencer's sentence.
        lift_height: of the object above its start [m].
        slip: motion of the object in the hand while it was held [m]; None if it never was.
        duration: of the grasp in simulated time [s].
        real_time_factor: simulated over wall time during the grasp.
        seed: of the run.
    """

    gripped: bool
    reason: str
    lift_height: float
    slip: float | None
    duration: float
    real_time_factor: float
    seed: int

    def line(self, folder: Path) -> str:
        """The one line at the end of the demo."""
        word = "gripped" if self.gripped else f"not gripped ({self.reason})"
        slip = "never held" if self.slip is None else f"slip {1e3 * self.slip:.2f} mm in the hold"
        return (
            f"{word}: lifted {1e3 * self.lift_height:.0f} mm, {slip}, "
            f"real-time factor {self.real_time_factor:.2f}; "
            f"bag {folder}/bag, pictures {folder}/grasp.png and {folder}/frames.png"
        )

    def write(self, path: Path) -> None:
        """Write `result.json`, with the versions that took part."""
        path.write_text(json.dumps({**asdict(self), "versions": versions()}, indent=2) + "\n")


def verdict_from(
    values: Mapping[str, str], success: bool, reason: str, real_time_factor: float, seed: int
) -> Verdict:
    """Verdict from the key-value pairs of `grasp/result` and the answer of the service.

    Args:
        values: `outcome` (gripped, lost or none), `lift_height` [m], `slip` [m] (nan if
            it was never held), `duration` [s].
        success, reason: the service's answer.

    Raises:
        ValueError: a value is missing or no number.
    """
    numbers = {}
    for key in ("lift_height", "slip", "duration"):
        try:
            numbers[key] = float(values[key])
        except (KeyError, ValueError):
            got = values.get(key, "nothing")
            raise ValueError(f"grasp/result: {key}: expected a number, got {got}") from None
    return Verdict(
        gripped=success and values.get("outcome") == "gripped",
        reason=values.get("reason", "") or reason,
        lift_height=numbers["lift_height"],
        slip=None if math.isnan(numbers["slip"]) else numbers["slip"],
        duration=numbers["duration"],
        real_time_factor=real_time_factor,
        seed=seed,
    )


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that decide a result; `absent` if not installed."""
    found = {"python": platform.python_version()}
    for name in REPORTED_PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "absent"
    return found


SERVICE = "grasp/surface_constrained"
RECORDER_LIMIT = 20.0  # [s]
GRASP_LIMIT = 300.0  # [s] of wall time
DRAW_LIMIT = 120.0  # [s]
IDLE = "idle"


class DemoFailed(RuntimeError):
    """The demo could not come to a verdict; the message says why."""


@dataclass
class Demo:
    """One run in a folder of its own.

    Args:
        options: what is simulated.
        folder: gets bag/, log/, the pictures and result.json.
        say: prints one line.
        stopped: set when the user wants to end.
        record: whether a bag is written (and pictures are drawn from it).
    """

    options: suite.SuiteOptions
    folder: Path
    say: Callable[[str], None]
    stopped: Event = field(default_factory=Event)
    record: bool = True

    def run(self) -> Verdict:
        """Grasp once; writes result.json.

        Raises:
            DemoFailed: something did not start, or the grasp did not end.
            NodeDied: a process ended by itself.
            Interrupted: `stopped` was set.
        """
        environment = node_environment(self.folder / "log")
        with Launcher(self.folder / "log", environment) as launcher:
            if self.record:
                self._start_recorder(launcher)
            for command in suite.three_nodes(self.options):
                launcher.start(command)
            verdict = self._grasp(launcher)
        verdict.write(self.folder / "result.json")
        return verdict

    def draw(self) -> None:
        """Draw grasp.png and frames.png from the bag.

        Raises:
            DemoFailed: the bag lacks a topic that is drawn, or drawing took too long.
            Interrupted: `stopped` was set.
        """
        log = self.folder / "log"
        with Launcher(log, node_environment(log)) as launcher:
            process = launcher.start(suite.figures(self.options, self.folder / "bag", self.folder))
            wait_until(lambda: process.exit_code is not None or self.stopped.is_set(), DRAW_LIMIT)
            if self.stopped.is_set():
                raise Interrupted
            if process.exit_code != 0:
                raise DemoFailed(f"no pictures: {process.last_words()} (log: {process.log})")

    def _start_recorder(self, launcher: Launcher) -> None:
        bag = self.folder / "bag"
        launcher.start(suite.recorder(bag))

        def is_writing() -> bool:
            launcher.check()
            return (bag / "bag_0.mcap").exists()

        if not wait_until(is_writing, RECORDER_LIMIT):
            raise DemoFailed(f"the recorder did not begin to write {bag}")

    def _grasp(self, launcher: Launcher) -> Verdict:
        # imported late: with --help or a folder that cannot be written, nobody should wait for ROS
        from softhand_bringup.ros.demo_link import GraspClient

        with GraspClient(SERVICE, self._tell_phase) as client:
            self._wait_for_suite(client, launcher)
            client.call()
            simulated, wall = client.simulated_time, time.monotonic()
            while (answer := client.answer()) is None:
                self._check(launcher)
                if time.monotonic() - wall > GRASP_LIMIT:
                    raise DemoFailed(f"{SERVICE} gave no answer within {GRASP_LIMIT:.0f} s")
            factor = (client.simulated_time - simulated) / (time.monotonic() - wall)
            if not client.result:
                raise DemoFailed(f"{SERVICE} ended without a grasp/result: {answer.message}")
            return verdict_from(
                client.result, answer.success, answer.message, factor, self.options.seed
            )

    def _wait_for_suite(self, client: GraspClient, launcher: Launcher) -> None:
        end = time.monotonic() + START_LIMIT
        while missing := client.missing(self.record):
            self._check(launcher)
            if time.monotonic() > end:
                raise DemoFailed(f"not there after {START_LIMIT:.0f} s: {', '.join(missing)}")

    def _check(self, launcher: Launcher) -> None:
        launcher.check()
        if self.stopped.is_set():
            raise Interrupted

    def _tell_phase(self, simulated_time: float, name: str) -> None:
        if name != IDLE:  # latched: what the sequencer said before it was called
            self.say(f"{simulated_time:7.2f} s  {name}")
