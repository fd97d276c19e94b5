"""Faults in the midst of a grasp: who says what, how the processes end, and what the outlets do.

`run` prints a table. Every fault gets nodes of its own.
"""

from __future__ import annotations

import resource
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import psutil
from rclpy.task import Future
from rosgraph_msgs.msg import Clock

from bench.robust.relay import Relay, relayed_driver
from bench.robust.rig import EMPTY, GRASP_LIMIT, Rig, RigError, started
from bench.row import at_least, at_most
from softhand_bringup.processes import suite
from softhand_bringup.processes.suite import SuiteOptions
from softhand_ros.topics import stamp_of_seconds

OPEN_LIMIT = 30.0  # of wall time in which the fingers must be empty [s]
WORD_LIMIT = 20.0  # of wall time for a word about it [s]
HELD_PERIOD = 3.0  # of wall time for which the air must stay where it is [s]
STOPPED = 1.0  # [s]
JUMP = 5.0  # of the clock [s]
JUMP_LASTS = 1.0  # [s]
NODES = ("hand_sim", "driver", "sequencer")
ENABLE = "pneumaticbox/enable"
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
VENTED, HELD, GOES_ON, GONE = "open", "shut", "as commanded", "gone with it"


@dataclass
class Finding:
    """What came of a fault: exit status of the node, word that was given, after which time [s],
    and what the outlets did, after which time [s].
    """

    fault: str
    exit_code: int | None = None
    word: str = ""
    told_after: float = float("nan")
    outlets: str = "neither open nor as it was"
    empty_after: float = float("nan")
    wanted: str = VENTED

    @property
    def silent(self) -> bool:
        """Whether nobody has said anything."""
        return not self.word

    @property
    def as_documented(self) -> bool:
        """Whether the outlets do what the table says."""
        return self.outlets == self.wanted

    def line(self) -> str:
        """A row of the table."""
        code = "-" if self.exit_code is None else str(self.exit_code)
        word = self.word if len(self.word) < 110 else self.word[:107] + "..."
        told, empty = (_seconds(t) for t in (self.told_after, self.empty_after))
        return f"| {self.fault} | {code} | {word} | {told} | {self.outlets} | {empty} |"


HEADER = """| fault | exit status | what is said | after [s] | outlets | empty after [s] |
|---|---|---|---|---|---|"""


def _seconds(value: float) -> str:
    return "-" if value != value else f"{value:.1f}"


@dataclass
class Case:
    """A fault: what to do to the nodes in mid-grasp, and what is wanted of the outlets."""

    fault: str
    cause: Callable[[Rig, Relay | None], Any]
    wanted: str = VENTED
    node: str = ""  # whose exit status is of interest
    relayed: bool = False  # whether the driver's sensors come by way of the bench
    recorded: bool = False


def run() -> list[dict[str, Any]]:
    """Rows: how many faults were silent, and after how many the outlets did something else."""
    findings = [examine(case) for case in cases()]
    print("\n".join([HEADER, *(finding.line() for finding in findings)]), flush=True)
    return [
        at_least("faults in mid-grasp", len(findings), "", len(findings)),
        at_most("of them silent", sum(f.silent for f in findings), "", 0),
        at_most(
            "of them with other outlets than documented",
            sum(not f.as_documented for f in findings),
            "",
            0,
        ),
    ]


def cases() -> list[Case]:
    """All faults."""
    found = []
    for node in NODES:
        for number in SIGNALS:
            wanted = GONE if node == "hand_sim" else VENTED
            found.append(Case(f"{node}: {number.name}", _sender(node, number), wanted, node))
        found.append(Case(f"{node}: SIGSTOP for 1 s", _stopper(node), GOES_ON, node))
    found += [Case(f"second {name}", _twin(name), GOES_ON, f"second_{name}") for name in NODES]
    found += [
        Case("clock set ahead by 5 s", _jumper(JUMP)),
        Case("clock set back by 5 s", _jumper(-JUMP), HELD),
        Case("pneumaticbox/enable false", lambda rig, _: rig.request(ENABLE, False), HELD),
        Case("grasp/abort", lambda rig, _: rig.request("grasp/abort")),
        Case("disk full: recorder", _fill_disk, GOES_ON, suite.RECORDER, recorded=True),
    ]
    for what in ("late", "frozen", "lost", "supply lost"):
        sensors = what if what == "supply lost" else f"sensors {what}"
        wanted = HELD if what == "late" else VENTED
        found.append(Case(sensors, _spoiler(what), wanted, relayed=True))
    return found


def examine(case: Case) -> Finding:
    """Let a fault happen in the midst of a grasp, and watch."""
    print(f"  {case.fault} ...", flush=True)
    finding = Finding(case.fault, wanted=case.wanted)
    try:
        with _bench_of(case) as (rig, relay):
            if case.recorded:
                rig.need(lambda: (rig.folder / "bag").exists(), 20.0, "a bag")
            grasp = rig.begin_grasp()
            rig.told.clear()
            begin = time.monotonic()
            case.cause(rig, relay)
            _watch(case, finding, rig, grasp, begin)
    except RigError as error:
        finding.word, finding.outlets = "", str(error)[:200]
    print(f"    {finding.line()}", flush=True)
    return finding


@contextmanager
def _bench_of(case: Case) -> Iterator[tuple[Rig, Relay | None]]:
    options = SuiteOptions(real_time_factor=1.0)
    replaced = {"driver": relayed_driver(options)} if case.relayed else {}
    with started(options, replaced=replaced) as rig:
        if case.recorded:
            rig.start([suite.recorder(rig.folder / "bag")])
        yield rig, Relay(rig) if case.relayed else None


def _watch(case: Case, finding: Finding, rig: Rig, grasp: Future, begin: float) -> None:
    """Wait for a word, for the outlets and for the end of the process."""
    rig.wait(lambda: _word(case, rig, grasp), WORD_LIMIT)
    finding.word = _word(case, rig, grasp)
    if finding.word:
        finding.told_after = time.monotonic() - begin
    if case.wanted == VENTED:
        if rig.wait(lambda: max(rig.pressures) < EMPTY, OPEN_LIMIT):
            finding.outlets, finding.empty_after = VENTED, time.monotonic() - begin
    elif case.wanted == HELD:
        rig.spin(HELD_PERIOD)
        finding.outlets = HELD if max(rig.pressures) > EMPTY else VENTED
    elif case.wanted == GONE:
        finding.outlets = GONE if rig.nodes[case.node].wait(5.0) is not None else HELD
    elif rig.wait(grasp.done, GRASP_LIMIT):
        finding.outlets = GOES_ON if grasp.result().success else grasp.result().message
        finding.word = finding.word or "nothing; the grasp goes on"
    if case.node:
        finding.exit_code = rig.nodes[case.node].wait(0.0 if case.wanted == GOES_ON else 5.0)


def _word(case: Case, rig: Rig, grasp: Future) -> str:
    """What anybody says of a fault: the driver, the grasp, another node, a node that ends."""
    process = rig.nodes.get(case.node)
    if process and case.wanted == GOES_ON and "SIG" not in case.fault:
        return process.last_words() if process.exit_code is not None else ""
    for part in ("safety", "sensors"):
        level, sentence = rig.told.get(f"pneumaticbox: {part}", (0, ""))
        if level > 0:
            return f"driver: {sentence}"
    if grasp.done() and not grasp.result().success:
        return f"grasp: {grasp.result().message}"
    simulation = rig.told.get("hand_sim: simulation", (0, ""))
    return f"hand_sim: {simulation[1]}" if simulation[0] > 0 else ""


# what is done to the nodes


def _sender(node: str, number: signal.Signals) -> Callable[[Rig, Relay | None], None]:
    return lambda rig, relay: rig.nodes[node].send(number)


def _stopper(node: str) -> Callable[[Rig, Relay | None], None]:
    def stop(rig: Rig, relay: Relay | None) -> None:
        rig.nodes[node].send(signal.SIGSTOP)
        rig.spin(STOPPED)
        rig.nodes[node].send(signal.SIGCONT)

    return stop


def _twin(node: str) -> Callable[[Rig, Relay | None], None]:
    def start(rig: Rig, relay: Relay | None) -> None:
        commands = {command.name: command for command in suite.three_nodes(SuiteOptions())}
        rig.start([replace(commands[node], name=f"second_{node}")])

    return start


def _jumper(jump: float) -> Callable[[Rig, Relay | None], None]:
    def publish(rig: Rig, relay: Relay | None) -> None:
        clock = rig.node.create_publisher(Clock, "/clock", 10)
        start, begin = rig.simulated_time + jump, time.monotonic()
        while (passed := time.monotonic() - begin) < JUMP_LASTS:
            clock.publish(Clock(clock=stamp_of_seconds(max(0.0, start + passed))))
            rig.spin(0.02)
        rig.node.destroy_publisher(clock)

    return publish


def _fill_disk(rig: Rig, relay: Relay | None) -> None:
    """Let the recorder write no further, as on a disk that is full."""
    size = sum(file.stat().st_size for file in (rig.folder / "bag").iterdir())
    process = psutil.Process(rig.nodes[suite.RECORDER].pid)
    process.rlimit(resource.RLIMIT_FSIZE, (size, size))


def _spoiler(what: str) -> Callable[[Rig, Relay | None], None]:
    def spoil(rig: Rig, relay: Relay | None) -> None:
        if relay is not None:
            relay.fault = what

    return spoil
