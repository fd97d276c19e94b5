"""A finger pressed on a table under mass, pressure and volume control: nodes up, all in one bag."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING

from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher
from softhand_bringup.processes.suite import node_environment
from softhand_bringup.processes.waiting import Patience
from softhand_model.hand.hand import load_hand
from thesis.equilibrium_point.course import HAND, JOINTS, STATE, VALVES, WRENCH, Push
from thesis.frame import Progress

if TYPE_CHECKING:
    from thesis.equilibrium_point.ros.press_bench import PressBench

SCENE = "press"
MODES = ("mass", "pressure", "volume")
RECORDED = ("/clock", STATE, VALVES, JOINTS, WRENCH)
STEP = 0.002  # physics step [s]
AIR = 9e-6  # with which the finger is bent by about 78 degrees [kg above rest]
ABOVE, PRESSED = 0.065, 0.030  # height of the wrist: fingertip free, and pressed to the table [m]
RISE = 1.0  # in which the finger is filled [s]
SETTLE = 2.0  # after filling and after a change of controller [s]
PUSH = 1.0  # down to the table, and up again [s]
HOLD = 2.0  # pressed, and free again [s]
EMPTY = 2.5  # until the finger is empty and at rest [s]


@dataclass
class Session:
    """The finger over the table, with simulator, driver and recorder.

    Args:
        folder: gets bag/ and log/.
        seed: of the sensors' noise and the valves' jitter.
        progress: is told.
        modes: controllers, in the order in which they are shown.
        stopped: set when the user wants to end.
    """

    folder: Path
    seed: int
    progress: Progress
    modes: Sequence[str] = MODES
    stopped: Event = field(default_factory=Event)

    @property
    def bag(self) -> Path:
        """The bag of the session."""
        return self.folder / "bag"

    def run(self) -> list[Push]:
        """Push once under every controller.

        Raises:
            RunFailed: something did not start, was refused, or simulated time stands still.
            NodeDied: a process ended by itself.
            Interrupted: `stopped` was set.
        """
        options = suite.SuiteOptions(hand=HAND, scene=SCENE, seed=self.seed, step=STEP)
        log = self.folder / "log"
        with Launcher(log, node_environment(log)) as launcher:
            launcher.start(suite.recorder(self.bag, RECORDED))
            launcher.start(suite.simulator(options))
            launcher.start(suite.driver(options))
            return self._play(launcher)

    def _play(self, launcher: Launcher) -> list[Push]:
        # imported late: with --help nobody should wait for ROS
        from thesis.equilibrium_point.ros.press_bench import PressBench

        with PressBench(load_hand(HAND).channels[0], RECORDED) as bench:
            patience = Patience(launcher, bench, self.stopped)
            patience.wait_for_nodes()
            pushes: list[Push] = []
            for mode in self.modes:
                self.progress(f"push under {mode} control", len(pushes) / len(self.modes))
                pushes.append(self._push(bench, patience, mode))
            return pushes

    def _push(self, bench: PressBench, patience: Patience, mode: str) -> Push:
        """Fill the finger by mass, hand it over to the controller, push and let go."""
        bench.control("mass")
        bench.hold_at(ABOVE)
        patience.let_pass(SETTLE)
        patience.tare()
        bench.command([(RISE, AIR)])
        patience.let_pass(RISE + SETTLE)
        bench.control(mode)
        patience.let_pass(SETTLE)
        start = bench.simulated_time
        self._move(bench, patience, ABOVE, PRESSED)
        pressed = bench.simulated_time
        patience.let_pass(HOLD)
        released = bench.simulated_time
        self._move(bench, patience, PRESSED, ABOVE)
        free = bench.simulated_time
        patience.let_pass(HOLD)
        push = Push(mode, start, pressed, released, free, bench.simulated_time)
        bench.control("mass")
        bench.command([(0.0, 0.0)])
        patience.let_pass(EMPTY)
        return push

    def _move(self, bench: PressBench, patience: Patience, start: float, goal: float) -> None:
        """Let the wrist go from height to height [m] in a straight line, within PUSH."""
        begin = bench.simulated_time
        while (share := (bench.simulated_time - begin) / PUSH) < 1.0:
            bench.hold_at(start + share * (goal - start))
            patience.let_pass(0.01)
        bench.hold_at(goal)
