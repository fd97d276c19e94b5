"""The suite's nodes as processes in a ROS domain of their own, and the bench's node beside them."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.client import Client
from rclpy.task import Future
from ros_domain import held_domain
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher, NodeCommand, NodeProcess
from softhand_bringup.processes.suite import SuiteOptions, node_environment
from softhand_ros.client_link import ClientLink
from softhand_ros.topics import latched

AMBIENT = 101_325.0  # [Pa]
EMPTY = 5e3  # gauge pressure that the offset of a sensor may have [Pa]
START_LIMIT = 90.0  # for the first state of the driver and the services [s]
GRASP_LIMIT = 120.0  # wall time of a grasp [s]
TICK = 0.3  # wall time in which a running simulator's clock ticks [s]
SETTLE = 1.0  # simulated time after a reset in which the driver averages its sensors [s]
GRASP = "grasp/surface_constrained"


class RigError(RuntimeError):
    """The nodes did not come so far that something could be measured."""


@dataclass(frozen=True)
class Usage:
    """What a process holds: memory of its own [MB], open files, threads."""

    memory: float
    files: int
    threads: int


class Rig(ClientLink):
    """The bench's node: hears what the nodes say, calls them, looks at their processes.

    Args:
        launcher: of the nodes.
        domain: of ROS.
        folder: of their logs.
    """

    def __init__(self, launcher: Launcher, domain: int, folder: Path) -> None:
        super().__init__("bench", domain)
        self.launcher, self.folder, self.domain = launcher, folder, domain
        self.nodes: dict[str, NodeProcess] = {}
        self.told: dict[str, tuple[int, str]] = {}  # level and sentence by the status's name
        self.pressures = np.zeros(0)  # gauge, as the plant's sensors tell [Pa]
        self.valves: list[float] = []
        self.phase = ""
        self._clients: dict[str, Client] = {}
        self.subscribe_clock()
        self.listen(DiagnosticArray, "/diagnostics", self._diagnosed, 50)
        self.listen(JointState, "pneumaticbox/sensors", self._sensed)
        self.listen(JointState, "pneumaticbox/valves", self._switched)
        self.node.create_subscription(String, "grasp/phase", self._phase_began, latched(10))

    def _diagnosed(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.told[status.name] = status.level[0], status.message

    def _sensed(self, message: JointState) -> None:
        self.pressures = np.array(message.effort[:-1]) - AMBIENT

    def _switched(self, message: JointState) -> None:
        self.valves = list(message.position)

    def _phase_began(self, message: String) -> None:
        self.phase = message.data

    # what runs

    def start(self, commands: Sequence[NodeCommand]) -> None:
        """Start nodes."""
        for command in commands:
            self.nodes[command.name] = self.launcher.start(command)

    def await_suite(self) -> None:
        """Until driver and sequencer answer.

        Raises:
            RigError: they did not.
        """
        self.need(lambda: self.simulated_time > 0.5, START_LIMIT, "half a second of simulated time")
        self.need(lambda: len(self.pressures), START_LIMIT, "a sample of the sensors")
        for service in (GRASP, "pneumaticbox/reset", "sim/reset"):
            self.need(self.client(Trigger, service).service_is_ready, START_LIMIT, service)

    def need(self, condition: Callable[[], Any], limit: float, what: str) -> None:
        """Wait for a condition; RigError when it does not come true within `limit` [s]."""
        if not self.wait(condition, limit):
            ended = {n: p.last_words() for n, p in self.nodes.items() if p.exit_code is not None}
            raise RigError(f"not within {limit:g} s: {what}; ended: {ended}; told: {self.told}")

    def pass_time(self, duration: float, limit: float = 60.0) -> None:
        """Let so much simulated time [s] pass."""
        end = self.simulated_time + duration
        self.need(lambda: self.simulated_time >= end, limit, f"{duration} s of simulated time")

    def alive(self) -> list[str]:
        """Names of the nodes that run."""
        return [name for name, process in self.nodes.items() if process.exit_code is None]

    # services

    def client(self, kind: Any, service: str) -> Client:
        """The client of a service; one each, as every new one has to be discovered."""
        if service not in self._clients:
            self._clients[service] = super().client(kind, service)
        return self._clients[service]

    def request(self, service: str, data: bool | None = None) -> Future:
        """Call a Trigger, or with `data` a SetBool, and do not wait for the answer."""
        kind = Trigger if data is None else SetBool
        client = self.client(kind, service)
        self.need(client.service_is_ready, 10.0, f"the service {service}")
        return client.call_async(kind.Request() if data is None else kind.Request(data=data))

    def call(self, service: str, data: bool | None = None, limit: float = 10.0) -> Any:
        """Answer of a service; RigError when there is none."""
        future = self.request(service, data)
        self.need(future.done, limit, f"an answer of {service}")
        return future.result()

    def begin_anew(self) -> None:
        """End what runs, leave every safe state, and put the scene back to its start."""
        self.call("sim/pause", False)
        self.call("grasp/abort", limit=30.0)
        self.call("sim/reset")
        self.spin(TICK)  # until the clock is that of the reset
        self.pass_time(SETTLE)
        self.call("pneumaticbox/reset")
        self.call("pneumaticbox/enable", True)
        self.need(lambda: self._well, 10.0, "a driver that is in operation")
        self.spin(1.5)  # until the sequencer has heard so, too

    @property
    def _well(self) -> bool:
        return self.told.get("pneumaticbox: safety", (9, ""))[0] == 0

    def grasp(self) -> Any:
        """Answer of a whole grasp; RigError when there is none."""
        return self.call(GRASP, limit=GRASP_LIMIT)

    def begin_grasp(self, pressure: float = 15e3) -> Future:
        """Begin a grasp and return its future in the midst of it: at a gauge pressure [Pa]."""
        future = self.request(GRASP)
        self.need(
            lambda: future.done() or max(self.pressures) > pressure, 60.0, "a hand that closes"
        )
        if future.done():
            raise RigError(f"the grasp ended: {future.result().message}")
        return future

    # processes

    def usage(self) -> dict[str, Usage]:
        """What every process that runs holds."""
        return {name: usage_of(self.nodes[name].pid) for name in self.alive()}

    def tell_ended(self) -> None:
        """Print how the nodes ended that do not run any more."""
        for name, process in self.nodes.items():
            if process.exit_code is not None:
                last = "\n    ".join(process.output().splitlines()[-12:])
                print(f"  {name} ended with {process.exit_code}:\n    {last}", flush=True)

    def longest_line(self) -> int:
        """Length of the longest line that a node has printed [characters]; its begin is printed."""
        lines = (line for process in self.nodes.values() for line in process.output().splitlines())
        longest = max(lines, key=len, default="")
        print(f"  longest line: {longest[:160]}", flush=True)
        return len(longest)


def usage_of(pid: int) -> Usage:
    """What a process holds."""
    process = psutil.Process(pid)
    with process.oneshot():
        memory = process.memory_full_info().uss / 1e6
        return Usage(memory, process.num_fds(), process.num_threads())


def growth(before: Mapping[str, Usage], after: Mapping[str, Usage], what: str) -> float:
    """Largest growth of a field of `Usage` among the processes that are in both, as a share of
    before [%]; infinite when none is left.
    """
    shares = [getattr(after[name], what) / getattr(before[name], what) for name in after]
    return 100.0 * (max(shares, default=math.inf) - 1.0)


def rest_of(rig: Rig, limit: float) -> bool:
    """Whether all channels are empty within so much wall time [s]."""
    return rig.wait(lambda: max(rig.pressures) < EMPTY, limit)


@contextmanager
def launched(commands: Sequence[NodeCommand]) -> Iterator[Rig]:
    """Nodes in a domain of their own, and the bench's node; all has ended afterwards."""
    with tempfile.TemporaryDirectory() as name, held_domain() as domain:
        folder = Path(name)
        environment = node_environment(folder, domain)
        # the bench's node has the same discovery
        os.environ.update({k: v for k, v in environment.items() if k.startswith(("ROS", "FAST"))})
        with Launcher(folder, environment) as launcher, Rig(launcher, domain, folder) as rig:
            rig.start(commands)
            yield rig


@contextmanager
def started(
    options: SuiteOptions | None = None,
    further: Sequence[NodeCommand] = (),
    replaced: Mapping[str, NodeCommand] | None = None,
) -> Iterator[Rig]:
    """Simulator, driver and sequencer, which answer; all has ended afterwards.

    Args:
        options: what is simulated; as fast as it goes where None.
        further: other nodes, as the monitor.
        replaced: commands that are started in place of the usual ones, by name.
    """
    usual = suite.three_nodes(options or SuiteOptions())
    commands = [(replaced or {}).get(command.name, command) for command in usual]
    with launched([*commands, *further]) as rig:
        rig.await_suite()
        yield rig
