"""The same grasp over ROS again and again: is it the same run, on an idle and on a busy machine,
with the driver in the simulator's process and in one of its own?

Runs are compared with the first one by simulated time since the first command: poses of the object,
states of the driver, and the commands with the stamps at which they take effect. Alone, with the
runs in three lines:

    python -m bench.robust.same_run --runs 3 --busy 2
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from bench.robust.rig import GRASP, GRASP_LIMIT, START_LIMIT, launched
from bench.row import at_most
from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Guard
from softhand_bringup.processes.suite import SuiteOptions
from softhand_ros.topics import nanoseconds, subscribe_by_hand, take
from softhand_trials.trials import draw_placement

RUNS, BUSY = 3, 2
SAME = 0.1  # largest distance between the object's places in two runs [mm]
WHOLE = QoSProfile(depth=5000)  # a run waits here until it is over: hearing it costs no time
MILLISECOND = 1_000_000  # [ns]
KINDS = {
    "scene/object_pose": PoseStamped,
    "wrist/target_pose": PoseStamped,
    "pneumaticbox/command": JointTrajectory,
    "pneumaticbox/state": JointState,
}


@dataclass(frozen=True)
class Run:
    """One grasp: the object's places (n, 3) [m] at times [ns]; commands as time, topic, text; the
    driver's states as text by time.
    """

    answer: str
    times: NDArray[np.int64]
    places: NDArray[np.float64]
    commands: tuple[tuple[int, str, str], ...]
    states: Mapping[int, str]

    @property
    def begin(self) -> int:
        """When the first command takes effect [ns]."""
        return min(time for time, *_ in self.commands if time)

    def distance(self, other: Run) -> float:
        """Largest distance of the object in both runs at one time since the first command [m]."""
        _, own, others = np.intersect1d(
            self.times - self.begin, other.times - other.begin, return_indices=True
        )
        return float(np.linalg.norm(self.places[own] - other.places[others], axis=1).max())

    def commands_alike(self, other: Run) -> float:
        """Of the commands that were heard of both runs, by topic and time since the first one, the
        share with the same content, bit for bit [%].
        """
        own, others = (
            {(time - run.begin, topic): text for time, topic, text in run.commands if time}
            for run in (self, other)
        )
        return _alike(own, others)

    def states_alike(self, other: Run) -> float:
        """Of the driver's states that were heard of both runs, by time since the first command, the
        share with the same content, bit for bit [%].
        """
        own, others = (
            {time - run.begin: text for time, text in run.states.items()} for run in (self, other)
        )
        return _alike(own, others)


def _alike(own: Mapping[Any, str], others: Mapping[Any, str]) -> float:
    """Of the keys of both, the share with the same content [%]; 0 without a common key."""
    common = own.keys() & others.keys()
    return 100.0 * sum(own[key] == others[key] for key in common) / max(len(common), 1)


def run_once(options: SuiteOptions) -> Run:
    """One grasp by new nodes."""
    with launched(suite.suite_nodes(options)) as rig:
        heard = {t: subscribe_by_hand(rig.node, kind, t, WHOLE) for t, kind in KINDS.items()}
        client = rig.client(Trigger, GRASP)
        rig.need(client.service_is_ready, START_LIMIT, GRASP)
        call = client.call_async(Trigger.Request())
        rig.need(call.done, GRASP_LIMIT, "an answer")
        rig.spin(0.5)  # until the last messages are there
        poses, targets, air, states = (list(_all(heard[topic])) for topic in KINDS)
        return _run(call.result().message, poses, [*targets, *air], states)


def _all(subscription: Any) -> Iterator[Any]:
    while (message := take(subscription)) is not None:
        yield message


def _run(answer: str, poses: Sequence[Any], commands: Sequence[Any], states: Sequence[Any]) -> Run:
    places = [message.pose.position for message in poses]
    return Run(
        answer,
        np.array([nanoseconds(message.header.stamp) for message in poses]),
        np.array([(place.x, place.y, place.z) for place in places]),
        tuple((nanoseconds(m.header.stamp), type(m).__name__, _content(m)) for m in commands),
        {nanoseconds(m.header.stamp): str((m.position, m.velocity, m.effort)) for m in states},
    )


def _content(command: Any) -> str:
    return str(command.points if isinstance(command, JointTrajectory) else command.pose)


@contextmanager
def busy(loops: int) -> Iterator[None]:
    """So many processes that do nothing but keep a core busy."""
    endless = [sys.executable, "-c", "while True: pass"]
    guard = Guard()
    processes = [subprocess.Popen(endless, preexec_fn=guard.enrol) for _ in range(loops)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()
        guard.close()


def runs(count: int, loops: int, options: SuiteOptions) -> list[Run]:
    """The same grasp several times, beside busy loops."""
    with busy(loops):
        done = []
        for number in range(count):
            done.append(run_once(options))
            run, first = done[-1], done[0]
            print(
                f"  {loops} loops, run {number}: {run.answer}; begins at {1e-9 * run.begin:.3f} s, "
                f"object {1e3 * run.distance(first):.4g} mm from the first, commands alike "
                f"{run.commands_alike(first):.1f} %",
                flush=True,
            )
        return done


def run(count: int = RUNS, loops: int = BUSY, seed: int = 0) -> list[dict[str, Any]]:
    """Rows on runs of one seed, all against the first: driver in the simulator's process or beside
    it, on an idle and on a busy machine.
    """
    offset, mass_scale = draw_placement(seed)
    options = SuiteOptions(
        object_offset=offset, object_mass_scale=mass_scale, seed=seed, await_commander=True
    )
    idle = runs(count, 0, options)
    loaded = runs(count, loops, options)
    (beside,) = runs(1, 0, replace(options, driver=suite.TOPIC))
    first, others = idle[0], [*idle[1:], *loaded]
    both = 1e3 * beside.distance(first)
    apart = 1e3 * max(other.distance(first) for other in others)
    late = max(abs(other.begin - first.begin) for other in others) / MILLISECOND
    unlike = 100.0 - min(other.commands_alike(first) for other in others)
    return [
        at_most("same seed over ROS: object apart, worst run", apart, "mm", SAME),
        at_most("same seed over ROS: first command apart", late, "ms", 0.0),
        at_most("same seed over ROS: commands that differ", unlike, "%", 0.0),
        at_most("same seed, driver in a process of its own: object apart", both, "mm", 0.0),
        at_most(
            "same seed, driver in a process of its own: its states that differ",
            100.0 - beside.states_alike(first),
            "%",
            0.0,
        ),
    ]


def main() -> None:
    """Print the runs and the rows."""
    parser = argparse.ArgumentParser(prog="bench.robust.same_run", description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--busy", type=int, default=BUSY, help="loops beside the loaded runs")
    parser.add_argument("--seed", type=int, default=0)
    parsed = parser.parse_args()
    for row in run(parsed.runs, parsed.busy, parsed.seed):
        print(f"{row['name']}: {row['value']:.6g} {row['unit']} (target {row['target']})")


if __name__ == "__main__":
    main()
