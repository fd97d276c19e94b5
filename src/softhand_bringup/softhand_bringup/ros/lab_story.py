"""The lab story over ROS: sessions at the simulated bench, each in one bag, and the command.

Exit status: 0 told to its end; 1 failed; 2 nothing could be started; 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Event

from softhand_bringup.lab_story.measuring import (
    ANGLES,
    FINGER,
    HAND,
    RESIDUAL,
    STATE,
    Measurement,
    Plan,
    Played,
    air_course,
    finger,
)
from softhand_bringup.lab_story.story import HIDDEN, Story
from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher, ParameterValue
from softhand_bringup.processes.run_folder import Say, run_command
from softhand_bringup.processes.suite import node_environment
from softhand_bringup.processes.waiting import Patience
from softhand_bringup.ros.bench_link import BenchLink
from softhand_model.hand.hand import load_hand

RECORDED = ("/clock", STATE, ANGLES, RESIDUAL)
STEP = 0.005  # physics step [s]: the finger settles within 50 ms, and the bench runs fast
WARM_UP = 1.0  # simulated time in which the driver averages its sensors [s]
BEFORE = 0.5  # simulated time at rest with which a run begins [s]
# when the monitor takes the finger to be settled: later than by default, for it is to be exact
SETTLING: dict[str, ParameterValue] = {"settle_time": 0.2, "settle_band": 500.0}


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
        allow_effect_files: whether the Python files that the models name are run.
    """

    folder: Path
    plan: Plan
    truth: Path
    model: str
    seed: int
    say: Callable[[str], None]
    stopped: Event = field(default_factory=Event)
    allow_effect_files: bool = False

    @property
    def bag(self) -> Path:
        """The bag of the session."""
        return self.folder / "bag"

    def run(self) -> list[Played]:
        """Play the plan; the runs in their order.

        Raises:
            RunFailed: something did not start, or simulated time stands still.
            NodeDied: a process ended by itself.
            Interrupted: `stopped` was set.
        """
        options = suite.SuiteOptions(
            hand=HAND,
            scene="stand",
            model=str(self.truth),
            allow_effect_files=self.allow_effect_files,
            seed=self.seed,
            step=STEP,
        )
        log = self.folder / "log"
        with Launcher(log, node_environment(log)) as launcher:
            launcher.start(suite.recorder(self.bag, RECORDED))
            launcher.start(suite.simulator(options))
            launcher.start(suite.driver(options))
            launcher.start(suite.monitor(replace(options, model=self.model), SETTLING))
            return self._play(launcher)

    def _play(self, launcher: Launcher) -> list[Played]:
        channel = load_hand(HAND).channels[0]
        with BenchLink("lab_story", channel, RECORDED) as bench:
            patience = Patience(launcher, bench, self.stopped)
            patience.wait_for_nodes()
            patience.let_pass(WARM_UP)
            played = []
            for repeat in range(1, self.plan.repeats + 1):
                for measurement in self.plan.measurements:
                    run = self._run(bench, patience, measurement, repeat)
                    told = bench.told.get(f"monitor: {FINGER}", "no word from the monitor")
                    self.say(f"{run.start:6.1f} s  {run.name:<16} monitor: {told}")
                    played.append(run)
            return played

    def _run(
        self, bench: BenchLink, patience: Patience, measurement: Measurement, repeat: int
    ) -> Played:
        """Rest with open outlets, so that memory fades at ambient pressure, and play one run."""
        bench.vent()
        patience.let_pass(self.plan.rest)
        bench.reset()
        start = bench.simulated_time
        patience.let_pass(BEFORE)
        patience.tare()
        bench.command(air_course(finger(), measurement))
        patience.let_pass(measurement.duration)
        name = f"{measurement.protocol}_{repeat}"
        return Played(name, measurement.protocol, start, bench.simulated_time)


def main(arguments: list[str] | None = None) -> int:
    """Tell the story; see the module for the exit status."""
    parsed = _parse(arguments)

    def play(folder: Path, say: Say, stopped: Event) -> bool:
        def bench(into: Path, plan: Plan, truth: Path, model: str) -> list[Played]:
            return Session(into, plan, truth, model, parsed.seed, say, stopped).run()

        Story(bench, folder, parsed.hide, say, stopped).run()
        return True

    return run_command("lab-story", parsed.out, play)


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="softhand lab-story",
        description="A finger whose simulator hides an effect: measured over ROS, diagnosed from "
        "the bags, the effect added, and watched live by the monitor.",
    )
    parser.add_argument("--hide", choices=HIDDEN, default="viscoelasticity")
    parser.add_argument("--seed", type=int, default=0, help="of sensor noise and valve jitter")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of all runs")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
