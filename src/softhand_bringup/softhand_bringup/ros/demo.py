"""The demo over ROS: start everything, grasp, lift and hold an object, stop everything, draw.

Exit status: 0 gripped; 1 not gripped or failed; 2 nothing could be started; 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Event

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

from grasp_strategies.dexterity.patterns import FILE as PATTERNS
from grasp_strategies.dexterity.replay import load_replay, simulator_settings
from grasp_strategies.strategy import Strategy, load_strategy
from grasp_strategies.strategy.fitting import USUAL_OBJECT, choose_strategy, misfit
from grasp_strategies.strategy.tried_with import TriedWith
from grasp_strategies.trials import draw_placement
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.scenes import load_scene
from softhand_bringup.grasp_verdict import Verdict, verdict_from
from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher, wait_until
from softhand_bringup.processes.run_folder import Say, run_command
from softhand_bringup.processes.suite import SuiteOptions, node_environment
from softhand_bringup.processes.waiting import START_LIMIT, Interrupted, RunFailed
from softhand_model.model_file import ALLOW_EFFECT_FILES, ALLOW_HELP
from softhand_ros.client_link import ClientLink

SERVICE, REPLAY = "grasp/surface_constrained", "grasp/feix"
RECORDER_LIMIT = 20.0  # [s]
GRASP_LIMIT = 300.0  # [s] of wall time
DRAW_LIMIT = 120.0  # [s]
IDLE = "idle"
# Before these are recorded, a grasp would leave a bag with holes.
AWAITED_TOPICS = (
    "/clock",
    "/pneumaticbox/sensors",
    "/pneumaticbox/valves",
    "/pneumaticbox/state",
    "/hand/joint_states",
    "/scene/object_pose",
    "/wrist/pose",
    "/grasp/phase",
    "/grasp/result",
)
AWAITED_COMMANDS = ("/pneumaticbox/command", "/wrist/target_pose")


@dataclass
class Demo:
    """One run in a folder of its own.

    Args:
        options: what is simulated.
        folder: gets bag/, log/, the pictures and result.json.
        say: prints one line.
        stopped: set when the user wants to end.
        record: whether a bag is written (and pictures are drawn from it).
        service: that grasps.
    """

    options: SuiteOptions
    folder: Path
    say: Callable[[str], None]
    stopped: Event = field(default_factory=Event)
    record: bool = True
    service: str = SERVICE

    def run(self) -> Verdict:
        """Grasp once; writes result.json.

        Raises:
            RunFailed: something did not start, or the grasp did not end.
            NodeDied: a process ended by itself.
            Interrupted: `stopped` was set.
        """
        environment = node_environment(self.folder / "log")
        with Launcher(self.folder / "log", environment) as launcher:
            if self.record:
                self._start_recorder(launcher)
            for command in suite.three_nodes(replace(self.options, await_commander=True)):
                launcher.start(command)
            verdict = self._grasp(launcher)
        verdict.write(self.folder / "result.json")
        return verdict

    def draw(self) -> None:
        """Draw grasp.png and frames.png from the bag.

        Raises:
            RunFailed: the bag lacks a topic that is drawn, or drawing took too long.
            Interrupted: `stopped` was set.
        """
        log = self.folder / "log"
        with Launcher(log, node_environment(log)) as launcher:
            process = launcher.start(suite.figures(self.options, self.folder / "bag", self.folder))
            wait_until(lambda: process.exit_code is not None or self.stopped.is_set(), DRAW_LIMIT)
            if self.stopped.is_set():
                raise Interrupted
            if process.exit_code != 0:
                raise RunFailed(f"no pictures: {process.last_words()} (log: {process.log})")

    def _start_recorder(self, launcher: Launcher) -> None:
        bag = self.folder / "bag"
        launcher.start(suite.recorder(bag))

        def is_writing() -> bool:
            launcher.check()
            return (bag / "bag_0.mcap").exists()

        if not wait_until(is_writing, RECORDER_LIMIT):
            raise RunFailed(f"the recorder did not begin to write {bag}")

    def _grasp(self, launcher: Launcher) -> Verdict:
        with GraspClient(self.service, self._tell_phase) as client:
            self._wait_for_suite(client, launcher)
            client.call()
            simulated, wall = client.simulated_time, time.monotonic()
            while (answer := client.answer()) is None:
                self._check(launcher)
                if time.monotonic() - wall > GRASP_LIMIT:
                    raise RunFailed(f"{self.service} gave no answer within {GRASP_LIMIT:.0f} s")
            factor = (client.simulated_time - simulated) / (time.monotonic() - wall)
            if not client.result:
                raise RunFailed(f"{self.service} ended without a grasp/result: {answer.message}")
            return verdict_from(
                client.result, answer.success, answer.message, factor, self.options.seed
            )

    def _wait_for_suite(self, client: GraspClient, launcher: Launcher) -> None:
        end = time.monotonic() + START_LIMIT
        while missing := client.missing(self.record):
            self._check(launcher)
            if time.monotonic() > end:
                raise RunFailed(f"not there after {START_LIMIT:.0f} s: {', '.join(missing)}")

    def _check(self, launcher: Launcher) -> None:
        launcher.check()
        if self.stopped.is_set():
            raise Interrupted

    def _tell_phase(self, simulated_time: float, name: str) -> None:
        if name != IDLE:  # latched: what the sequencer said before it was called
            self.say(f"{simulated_time:7.2f} s  {name}")


class GraspClient(ClientLink):
    """Calls a grasp service and follows it. A context manager; use it from one thread.

    Args:
        service: name of the grasp service.
        on_phase: called with (simulated time [s], name) when a phase begins.
    """

    def __init__(self, service: str, on_phase: Callable[[float, str], None]) -> None:
        super().__init__("demo")
        self._grasp = self.node.create_client(Trigger, service)
        self._future: Future = Future()
        self._on_phase = on_phase
        self.result: dict[str, str] = {}
        self.hear_clock()
        self.listen(String, "grasp/phase", self._phase_began)
        self.listen(DiagnosticArray, "grasp/result", self._result_came)

    def missing(self, recorded: bool) -> list[str]:
        """What is not there yet before a grasp can be called, in words.

        Args:
            recorded: whether a recorder must have subscribed to all topics too.
        """
        self.spin(0.1)
        missing = [t for t in AWAITED_TOPICS if not self.node.count_publishers(t)]
        missing += [t for t in AWAITED_COMMANDS if not self.node.count_subscribers(t)]
        if not self.has_ticked:
            missing.append("a tick of /clock")
        if not self._grasp.service_is_ready():
            missing.append(f"service {self._grasp.srv_name}")
        if recorded:
            topics = AWAITED_TOPICS + AWAITED_COMMANDS
            unheard = [t for t in topics if not self.is_heard_by(t, suite.RECORDER)]
            missing += [f"recording of {topic}" for topic in unheard]
        return missing

    def call(self) -> None:
        """Call the service."""
        self.result = {}
        self._future = self._grasp.call_async(Trigger.Request())

    def answer(self) -> Trigger.Response | None:
        """The service's answer, or None after a tenth of a second without one."""
        done = self._future.done()
        self.spin(0.1)  # also after the answer: the result may come behind it
        return self._future.result() if done else None

    def _phase_began(self, message: String) -> None:
        self._on_phase(self.simulated_time, message.data)

    def _result_came(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.result.update({pair.key: pair.value for pair in status.values})


def main(arguments: list[str] | None = None) -> int:
    """Run the demo; see the module for the exit status."""
    parsed = _parse(arguments)
    try:
        strategy = _strategy(parsed)
        options = _options(parsed, strategy)
    except ValueError as error:
        print(f"demo: {error}", flush=True)
        return 2

    def play(folder: Path, say: Say, stopped: Event) -> bool:
        """Run the demo into a folder; whether it gripped."""
        if warning := misfit(strategy, options.object):
            say(f"warning: {warning}")
        say(f"{options.hand} grasps the {options.object} by {strategy.name}, seed {options.seed}")
        say(f"recording to {folder}/bag")
        service = SERVICE if parsed.grasp_type is None else REPLAY
        return _run(Demo(options, folder, say, stopped, service=service))

    return run_command("demo", parsed.out, play)


def _run(demo: Demo) -> bool:
    verdict = demo.run()
    demo.say("drawing the pictures")
    try:
        demo.draw()
    finally:  # the verdict stands, whatever becomes of the pictures
        demo.say(verdict.line(demo.folder))
    return verdict.gripped


def _strategy(parsed: argparse.Namespace) -> Strategy:
    """The strategy that was asked for, or one that fits the object; of a grasp type, its replay."""
    if parsed.grasp_type is not None:
        return load_replay(parsed.grasp_type, parsed.grasp_patterns)
    if parsed.object is not None:
        load_object(parsed.object)  # says which there are
    parsed.strategy = parsed.strategy or choose_strategy(parsed.object, parsed.hand)
    return load_strategy(parsed.strategy)


def _options(parsed: argparse.Namespace, strategy: Strategy) -> SuiteOptions:
    """What was asked for; the rest is as the strategy was tried."""
    if parsed.grasp_type is not None:
        return _replay_options(parsed)
    offset, mass_scale = draw_placement(parsed.seed)
    tried = strategy.tried_with
    thing = parsed.object or next(iter(strategy.objects), USUAL_OBJECT)
    scene, inclination = parsed.scene or tried.scene, parsed.wall_inclination
    if inclination is not None:
        load_scene(scene).inclined(inclination)  # says what is wrong with it
    elif scene == tried.scene:
        inclination = tried.wall_inclination
    place = object_place(tried, thing)
    return SuiteOptions(
        hand=parsed.hand or strategy.hand,
        strategy=parsed.strategy,
        object=thing,
        scene=scene,
        model=parsed.model or tried.model,
        segments=tried.segments,
        allow_effect_files=parsed.allow_effect_files,
        friction=parsed.friction,
        wall_inclination=inclination,
        object_offset=(place[0] + offset[0], place[1] + offset[1]),
        object_upright=thing in tried.upright,
        object_mass_scale=mass_scale,
        seed=parsed.seed,
        # somebody who looks wants to see it happen as on a bench; else as fast as it goes
        real_time_factor=1.0 if parsed.gui else 0.0,
        gui=parsed.gui,
    )


def _replay_options(parsed: argparse.Namespace) -> SuiteOptions:
    """What the stored grasp of a type needs; where the object is held, it is as it was stored."""
    return SuiteOptions(
        **simulator_settings(parsed.grasp_type, parsed.grasp_patterns),
        grasp_type=parsed.grasp_type,
        grasp_patterns=str(parsed.grasp_patterns),
        seed=parsed.seed,
        real_time_factor=1.0 if parsed.gui else 0.0,
        gui=parsed.gui,
    )


def object_place(tried: TriedWith, name: str) -> tuple[float, float]:
    """Where an object (x, y) [m] lies for a strategy, before it is moved at random.

    >>> x, y = object_place(TriedWith(place=None), "ball")
    >>> round(x, 4), round(y, 4)
    (0.0325, -0.0325)
    """
    if tried.place is not None:
        return tried.place
    thing = load_object(name)
    if name in tried.upright:
        thing = replace(thing, rpy=(0.0, 0.0, 0.0))
    return thing.corner_place


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="softhand demo", description="Grasp, lift and hold an object with three ROS 2 nodes."
    )
    parser.add_argument("--seed", type=int, default=0, help="moves the object and changes its mass")
    parser.add_argument("--gui", action="store_true", help="open PyBullet's window")
    parser.add_argument("--hand", help="name, or path of a YAML file (that of the strategy)")
    parser.add_argument(
        "--strategy", help="name, or path of a YAML file (one that fits the object)"
    )
    parser.add_argument(
        "--object", help="name, or path of a YAML file (one that fits the strategy)"
    )
    parser.add_argument(
        "--grasp-type", type=int, help="of the Feix taxonomy: its stored grasp, with its object"
    )
    parser.add_argument(
        "--grasp-patterns", type=Path, default=PATTERNS, help="file of stored grasps"
    )
    parser.add_argument("--scene", help="name, or path of a YAML file (that of the strategy)")
    parser.add_argument("--model", help="model file of the physics (that of the strategy)")
    parser.add_argument(ALLOW_EFFECT_FILES, action="store_true", help=ALLOW_HELP)
    parser.add_argument("--friction", default="", help="file with pairs of materials of your own")
    parser.add_argument("--wall-inclination", type=float, help="of the scene's wall [deg]")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of all runs")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
