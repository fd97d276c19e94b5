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

from grasp_strategies.strategy import Strategy, load_strategy
from grasp_strategies.strategy.fitting import USUAL_OBJECT, choose_strategy, misfit
from grasp_strategies.strategy.tried_with import TriedWith
from pneuflex_sim.engines import ENGINES
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.scenes import load_scene
from softhand_bringup.grasp_verdict import Verdict, verdict_from
from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher, wait_until
from softhand_bringup.processes.run_folder import Say, run_command
from softhand_bringup.processes.suite import SuiteOptions, node_environment
from softhand_bringup.processes.waiting import SUITE_START_LIMIT, Interrupted, Progress, RunFailed
from softhand_bringup.ros.run_domain import refuse_strangers, run_domain, run_enclave
from softhand_common.documents.output_file import UnwritableFile
from softhand_model.model_file import ALLOW_EFFECT_FILES, ALLOW_HELP
from softhand_ros.client_link import ClientLink
from softhand_trials.trials import draw_placement

SERVICE = "grasp/surface_constrained"
GRASP_LIMIT = 300.0  # simulated time [s]
DRAW_LIMIT = 600.0  # wall time, far more than drawing needs [s]
IDLE = "idle"
# topics that must be recorded before the grasp begins, for a complete bag
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
        options: options of the simulation.
        folder: folder for bag/, log/, the pictures and result.json.
        say: prints one line.
        stopped: set when the user wants to end.
        record: whether a bag is written (and pictures are drawn from it).
        service: service of the sequencer that grasps.
    """

    options: SuiteOptions
    folder: Path
    say: Callable[[str], None]
    stopped: Event = field(default_factory=Event)
    record: bool = True
    service: str = SERVICE

    def run(self) -> Verdict:
        """Grasp once and write result.json; returns the verdict.

        Raises:
            RunFailed: a node did not start, or the grasp did not end.
            NodeDied: a process ended by itself.
            DomainTaken: other nodes run in the ROS domain.
            Interrupted: `stopped` was set.
            UnwritableFile: result.json cannot be written; the verdict has been printed.
        """
        log = self.folder / "log"
        with run_domain(self.say) as domain, Launcher(log, node_environment(log, domain)) as run:
            if self.record:
                self._start_recorder(run)
            enclave = run_enclave(domain)
            options = replace(self.options, await_commander=True, enclave=enclave)
            if self.record:
                options = replace(options, state_rate=0.0)
            for command in suite.suite_nodes(options):
                run.start(command)
            with GraspClient(self.service, self._tell_phase, domain, enclave) as client:
                verdict = self._grasp(client, run)
        try:
            verdict.write(self.folder / "result.json")
        except UnwritableFile:
            self.say(verdict.line(self.folder))
            raise
        return verdict

    def draw(self) -> None:
        """Draw grasp.png and frames.png from the bag.

        Raises:
            RunFailed: the bag lacks a required topic, or drawing took too long.
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

        if not wait_until(is_writing, SUITE_START_LIMIT):
            raise RunFailed(f"the recorder did not begin to write {bag}")

    def _grasp(self, client: GraspClient, launcher: Launcher) -> Verdict:
        self._wait_for_suite(client, launcher)
        client.call()
        progress = Progress()
        simulated, wall = client.simulated_time, time.monotonic()
        while (answer := client.answer()) is None:
            self._check(launcher)
            progress.check(client.simulated_time)
            if client.simulated_time - simulated > GRASP_LIMIT:
                raise RunFailed(f"{self.service}: no answer in {GRASP_LIMIT:.0f} simulated seconds")
        factor = (client.simulated_time - simulated) / (time.monotonic() - wall)
        if not client.result:
            raise RunFailed(f"{self.service} ended without a grasp/result: {answer.message}")
        return verdict_from(
            client.result, answer.success, answer.message, factor, self.options.seed
        )

    def _wait_for_suite(self, client: GraspClient, launcher: Launcher) -> None:
        end = time.monotonic() + SUITE_START_LIMIT
        while missing := client.missing(self.record):
            self._check(launcher)
            if time.monotonic() > end:
                raise RunFailed(f"not there after {SUITE_START_LIMIT:.0f} s: {', '.join(missing)}")
        refuse_strangers(client)

    def _check(self, launcher: Launcher) -> None:
        launcher.check()
        if self.stopped.is_set():
            raise Interrupted

    def _tell_phase(self, simulated_time: float, name: str) -> None:
        if name != IDLE:  # the latched message from before the grasp
            self.say(f"{simulated_time:7.2f} s  {name}")


class GraspClient(ClientLink):
    """Calls a grasp service and follows its phases. A context manager, for a single thread.

    Args:
        service: name of the grasp service.
        on_phase: called with (simulated time [s], name) when a phase begins.
        domain, enclave: ROS domain and enclave of the nodes.
    """

    def __init__(
        self, service: str, on_phase: Callable[[float, str], None], domain: int, enclave: str
    ) -> None:
        super().__init__("demo", domain, enclave=enclave)
        self._grasp = self.client(Trigger, service)
        self._future: Future = Future()
        self._on_phase = on_phase
        self.result: dict[str, str] = {}
        self.subscribe_clock()
        self.listen(String, "grasp/phase", self._phase_began)
        self.listen(DiagnosticArray, "grasp/result", self._result_came)

    def missing(self, recorded: bool) -> list[str]:
        """What is still missing before a grasp can be called, in words.

        Args:
            recorded: whether the recorder must have subscribed to all topics.
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
            unheard = [t for t in topics if not self.is_subscribed(suite.RECORDER, t)]
            missing += [f"recording of {topic}" for topic in unheard]
        return missing

    def call(self) -> None:
        """Call the grasp service without waiting for its answer."""
        self.result = {}
        self._future = self._grasp.call_async(Trigger.Request())

    def answer(self) -> Trigger.Response | None:
        """Answer of the service, or None after 0.1 s without one."""
        done = self._future.done()
        self.spin(0.1)  # also after the answer: grasp/result may arrive later
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
        """Run the demo in a folder; returns whether the object was gripped."""
        if warning := misfit(strategy, options.object):
            say(f"warning: {warning}")
        say(f"{options.hand} grasps the {options.object} by {strategy.name}, seed {options.seed}")
        say(f"recording to {folder}/bag")
        return _run(Demo(options, folder, say, stopped))

    return run_command("demo", parsed.out, play)


def _run(demo: Demo) -> bool:
    verdict = demo.run()
    demo.say("drawing the pictures")
    try:
        demo.draw()
    finally:  # the verdict is printed also when the pictures fail
        demo.say(verdict.line(demo.folder))
    return verdict.gripped


def _strategy(parsed: argparse.Namespace) -> Strategy:
    """The chosen strategy, or one that fits the object."""
    if parsed.object is not None:
        load_object(parsed.object)  # raises for an unknown object
    parsed.strategy = parsed.strategy or choose_strategy(parsed.object, parsed.hand)
    return load_strategy(parsed.strategy)


def _options(parsed: argparse.Namespace, strategy: Strategy) -> SuiteOptions:
    """The chosen options; all others are those with which the strategy was tried."""
    offset, mass_scale = draw_placement(parsed.seed)
    if strategy.holds_object_out:  # without random placement
        offset, mass_scale = (0.0, 0.0), 1.0
    tried = strategy.tried_with
    thing = parsed.object or next(iter(strategy.objects), USUAL_OBJECT)
    scene, inclination = parsed.scene or tried.scene, parsed.wall_inclination
    if inclination is not None:
        load_scene(scene).inclined(inclination)  # raises for an impossible inclination
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
        step=tried.step,
        finger_contact=tried.finger_contact,
        engine=parsed.engine,
        allow_effect_files=parsed.allow_effect_files,
        friction=parsed.friction,
        wall_inclination=inclination,
        object_offset=(place[0] + offset[0], place[1] + offset[1]),
        object_upright=thing in tried.upright,
        object_mass_scale=mass_scale,
        seed=parsed.seed,
        # in real time for somebody who watches, otherwise as fast as possible
        real_time_factor=1.0 if parsed.gui else 0.0,
        gui=parsed.gui,
        driver=parsed.driver,
    )


def object_place(tried: TriedWith, name: str) -> tuple[float, float]:
    """Place (x, y) [m] of an object for a strategy, before the random offset.

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
    parser.add_argument("--seed", type=int, default=0, help="draws offset and mass of the object")
    parser.add_argument(
        "--driver",
        choices=suite.DRIVERS,
        default=suite.COMPOSED,
        help="in the simulator's process, or a process of its own on topics (composed)",
    )
    parser.add_argument("--gui", action="store_true", help="open PyBullet's window")
    parser.add_argument(
        "--engine", choices=ENGINES, default="", help="physics engine (PyBullet where installed)"
    )
    parser.add_argument("--hand", help="name, or path of a YAML file (that of the strategy)")
    parser.add_argument(
        "--strategy", help="name, or path of a YAML file (one that fits the object)"
    )
    parser.add_argument(
        "--object", help="name, or path of a YAML file (one that fits the strategy)"
    )
    parser.add_argument("--scene", help="name, or path of a YAML file (that of the strategy)")
    parser.add_argument("--model", help="model file of the physics (that of the strategy)")
    parser.add_argument(ALLOW_EFFECT_FILES, action="store_true", help=ALLOW_HELP)
    parser.add_argument("--friction", default="", help="file with friction of your own materials")
    parser.add_argument("--wall-inclination", type=float, help="inclination of the wall [deg]")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder of all runs")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
