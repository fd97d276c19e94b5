"""A finger pressed on a table under mass, pressure and volume control: starts the nodes, records a
bag.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING

from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher
from softhand_bringup.processes.suite import node_environment
from softhand_bringup.processes.waiting import Waits
from softhand_model.hand.hand import load_hand
from thesis.equilibrium_point.recording import HAND, JOINTS, STATE, VALVES, WRENCH, Push
from thesis.frame import Progress

if TYPE_CHECKING:
    from thesis.equilibrium_point.ros.press_rig import PressRig

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
            DomainTaken: other nodes run in the ROS domain.
            Interrupted: `stopped` was set.
        """
        # imported late: with --help nobody should wait for ROS
        from softhand_bringup.ros.run_domain import run_domain, run_enclave
        from thesis.equilibrium_point.ros.press_rig import PressRig

        log, channel = self.folder / "log", load_hand(HAND).channels[0]
        with (
            run_domain(lambda line: self.progress(line, 0.0)) as domain,
            Launcher(log, node_environment(log, domain)) as launcher,
        ):
            enclave = run_enclave(domain)
            options = suite.SuiteOptions(
                hand=HAND, scene=SCENE, seed=self.seed, step=STEP, enclave=enclave, state_rate=0.0
            )
            launcher.start(suite.recorder(self.bag, RECORDED))
            for command in suite.hand_with_box(options, command_timeout=0.0):
                launcher.start(command)
            with PressRig(channel, RECORDED, domain, enclave) as rig:
                return self._play(rig, Waits(launcher, rig, self.stopped))

    def _play(self, rig: PressRig, patience: Waits) -> list[Push]:
        from softhand_bringup.ros.run_domain import refuse_strangers

        patience.wait_for_nodes()
        refuse_strangers(rig)
        pushes: list[Push] = []
        for mode in self.modes:
            self.progress(f"push under {mode} control", len(pushes) / len(self.modes))
            pushes.append(self._push(rig, patience, mode))
        return pushes

    def _push(self, rig: PressRig, patience: Waits, mode: str) -> Push:
        """Fill the finger by mass, hand it over to the controller, push and let go."""
        rig.control("mass")
        rig.hold_at(ABOVE)
        patience.let_pass(SETTLE)
        patience.tare()
        rig.command([(RISE, AIR)])
        patience.let_pass(RISE + SETTLE)
        rig.control(mode)
        patience.let_pass(SETTLE)
        start = rig.simulated_time
        self._move(rig, patience, ABOVE, PRESSED)
        pressed = rig.simulated_time
        patience.let_pass(HOLD)
        released = rig.simulated_time
        self._move(rig, patience, PRESSED, ABOVE)
        free = rig.simulated_time
        patience.let_pass(HOLD)
        push = Push(mode, start, pressed, released, free, rig.simulated_time)
        rig.control("mass")
        rig.command([(0.0, 0.0)])
        patience.let_pass(EMPTY)
        return push

    def _move(self, rig: PressRig, patience: Waits, start: float, goal: float) -> None:
        """Move the wrist linearly from one height to another [m] within PUSH."""
        begin = rig.simulated_time
        while (share := (rig.simulated_time - begin) / PUSH) < 1.0:
            rig.hold_at(start + share * (goal - start))
            patience.let_pass(0.01)
        rig.hold_at(goal)
