"""The lab story over ROS: sessions on the simulated rig, each in one bag, and the command.

Exit status: 0 all steps done; 1 failed; 2 nothing could be started; 130 interrupted.
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
    RESIDUAL,
    RIG_HAND,
    STATE_NAME,
    Measurement,
    Plan,
    PlayedRun,
    air_mass_setpoints,
    finger,
)
from softhand_bringup.lab_story.story import HIDDEN_EFFECTS, HiddenEffectRun
from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher, ParameterValue
from softhand_bringup.processes.run_folder import Say, run_command
from softhand_bringup.processes.suite import node_environment
from softhand_bringup.processes.waiting import Waits
from softhand_bringup.ros.rig_link import RigLink
from softhand_bringup.ros.run_domain import refuse_strangers, run_domain, run_enclave
from softhand_model.hand.hand import load_hand

RECORDED_TOPICS = ("/clock", STATE_NAME, ANGLES, RESIDUAL)
RIG_PACE = 4.0  # simulated over wall time: a monitor that waits for a core still gets all samples
RIG_STEP = 0.005  # physics step [s]: the finger settles within 50 ms, and the rig runs fast
WARM_UP = 1.0  # simulated time in which the driver averages its sensors [s]
REST_BEFORE_RUN = 0.5  # simulated time at rest at the start of a run [s]
# when the monitor regards the finger as settled: later than by default, for a small residual
MONITOR_SETTLING: dict[str, ParameterValue] = {"settle_time": 0.2, "settle_band": 500.0}


@dataclass
class Session:
    """A session with a simulated finger and a monitor that may have another model.

    Args:
        folder: folder for bag/ and log/.
        plan: plan of the measurements.
        truth: model file of the simulator.
        model: model file, or shipped name, of the monitor.
        seed: seed of the sensors' noise and of the scatter of the valves' delays.
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

    def run(self) -> list[PlayedRun]:
        """Carry out the plan; returns the runs in their order.

        Raises:
            RunFailed: a node did not start, or simulated time does not advance.
            NodeDied: a process ended by itself.
            DomainTaken: other nodes run in the ROS domain.
            Interrupted: `stopped` was set.
        """
        with run_domain(self.say) as domain:
            return self._run_in(domain)

    def _run_in(self, domain: int) -> list[PlayedRun]:
        enclave = run_enclave(domain)
        options = suite.SuiteOptions(
            hand=RIG_HAND,
            scene="stand",
            model=str(self.truth),
            allow_effect_files=self.allow_effect_files,
            seed=self.seed,
            step=RIG_STEP,
            enclave=enclave,
            state_rate=0.0,
            real_time_factor=RIG_PACE,
        )
        log = self.folder / "log"
        with Launcher(log, node_environment(log, domain)) as launcher:
            launcher.start(suite.recorder(self.bag, RECORDED_TOPICS))
            for command in suite.hand_with_box(options, command_timeout=0.0):
                launcher.start(command)
            launcher.start(suite.monitor(replace(options, model=self.model), MONITOR_SETTLING))
            channel = load_hand(RIG_HAND).channels[0]
            with RigLink("lab_story", channel, RECORDED_TOPICS, domain, enclave) as rig:
                return self._play(rig, Waits(launcher, rig, self.stopped))

    def _play(self, rig: RigLink, waits: Waits) -> list[PlayedRun]:
        waits.wait_for_nodes()
        refuse_strangers(rig)
        waits.let_pass(WARM_UP)
        played = []
        for repeat in range(1, self.plan.repeats + 1):
            for measurement in self.plan.measurements:
                run = self._run(rig, waits, measurement, repeat)
                status = rig.statuses.get(f"monitor: {FINGER}", "no status from the monitor")
                self.say(f"{run.start:6.1f} s  {run.name:<16} monitor: {status}")
                played.append(run)
        # on a busy machine the monitor is behind the simulation
        end = played[-1].end
        waits.wait_until(
            lambda: rig.monitored_time >= end, f"the monitor's residuals up to {end:.1f} s"
        )
        return played

    def _run(self, rig: RigLink, waits: Waits, measurement: Measurement, repeat: int) -> PlayedRun:
        """Rest with open outlets, so that effects with memory relax, then carry out one run."""
        rig.vent()
        waits.let_pass(self.plan.rest)
        rig.reset()
        start = rig.simulated_time
        waits.let_pass(REST_BEFORE_RUN)
        waits.tare()
        rig.command(air_mass_setpoints(finger(), measurement))
        waits.let_pass(measurement.duration)
        name = f"{measurement.protocol}_{repeat}"
        return PlayedRun(name, measurement.protocol, start, rig.simulated_time)


def main(arguments: list[str] | None = None) -> int:
    """Run the lab story; see the module for the exit status."""
    parsed = _parse(arguments)

    def play(folder: Path, say: Say, stopped: Event) -> bool:
        def rig(into: Path, plan: Plan, truth: Path, model: str) -> list[PlayedRun]:
            return Session(into, plan, truth, model, parsed.seed, say, stopped).run()

        HiddenEffectRun(rig, folder, parsed.hide, say, stopped).run()
        return True

    return run_command("lab-story", parsed.out, play)


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="softhand lab-story",
        description="A finger whose simulator hides an effect: measured over ROS, diagnosed from "
        "the bags, the effect added, and watched live by the monitor.",
    )
    parser.add_argument("--hide", choices=HIDDEN_EFFECTS, default="viscoelasticity")
    parser.add_argument("--seed", type=int, default=0, help="draws sensor noise and valve jitter")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of all runs")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
