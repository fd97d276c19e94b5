"""The simulator node `hand_sim`: one thread steps the world and serves ROS."""

from __future__ import annotations

import array
import math
import sys
import threading
import time

import numpy as np
import pybullet
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Pose, PoseArray, PoseStamped, WrenchStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from pneuflex_sim.ros.clock import Pace, shared_clock
from pneuflex_sim.ros.interface import HELP
from pneuflex_sim.ros.markers import SeenScene
from pneuflex_sim.ros.parameters import PARAMETERS, configuration
from pneuflex_sim.ros.transforms import Transforms
from pneuflex_sim.simulation import Simulation
from pneuflex_sim.urdf import joint_names, joint_positions, write_urdf
from pneuflex_sim.world import Diverged
from softhand_model.numerics.compiled import compilation_told
from softhand_model.pneumatics.valves import CommandWatch
from softhand_ros.diagnostics import REPORT_PERIOD, Diagnostics, Preparation, Report, cut
from softhand_ros.executor import RoundRobin
from softhand_ros.parameters import declare
from softhand_ros.run_node import run_node
from softhand_ros.services import offer_switch, offer_trigger
from softhand_ros.topics import (
    RELIABLE,
    Inbox,
    clock_conflict,
    full_name,
    heard,
    latched,
    nanoseconds,
    stamp_of_seconds,
)

LOCKSTEP_WAIT = 0.05  # wall time to wait for the valves that answer a sample [s]
MUCH_WAITING = 0.5  # wall time between two reports that was waited in vain [s]
SERVE_SLICE = 0.001  # wall time for which others are served after a sample [s]
SERVE_PERIOD = 0.01  # wall time between looks at services while the simulation is paused [s]
STANDING_PERIOD = 0.1  # wall time between ticks of a clock that stands [s]
SENSOR_PERIOD = 0.002  # shortest time between sensor samples [s]
SLOW_PERIOD = 0.02  # joint states, contacts, fingertips [s]
FAST_PERIOD = 0.01  # clock, wrist, object [s]


def _fill_pose(pose: Pose, position: np.ndarray, orientation: np.ndarray) -> Pose:
    place, turn = pose.position, pose.orientation
    place.x, place.y, place.z = position.tolist()
    turn.x, turn.y, turn.z, turn.w = orientation.tolist()
    return pose


class HandSim(Node):
    """Publishes what the hand does and senses; obeys valves and wrist targets."""

    def __init__(self) -> None:
        super().__init__("hand_sim")
        value = declare(self, PARAMETERS)
        self.diagnostics = Diagnostics(self, "hand_sim", "pneuflex_sim")
        with Preparation(self, self.diagnostics, "simulation") as tell, compilation_told(tell):
            self.simulation = Simulation(configuration(value))
            self._compile()
        self.lockstep, self.paused, self.single_steps = value["lockstep"], False, 0
        self.watch = CommandWatch(len(self.simulation.channels))
        self.driver_seen = False
        self.answered_stamp, self.missed_answers, self.told_missed = -1, 0, 0
        self.refused: list[str] = []
        self.refusals, self.diverged = 0, ""
        self.pace = Pace(value["real_time_factor"])
        self.clock = shared_clock(self, value["publish_clock"])
        self.substeps = math.ceil(SENSOR_PERIOD / self.simulation.step_size - 1e-9)
        self._create_topics()
        self._create_services()
        self._prepare_messages()
        self.seen = SeenScene(self, self.simulation, RELIABLE)
        self.transforms = Transforms(self, self.simulation)
        self.marker_period = 1.0 / value["marker_rate"]
        self._executor = RoundRobin(self)
        layout = self.simulation.bodies.layout
        self.description.publish(String(data=write_urdf(layout)))
        self.get_logger().info(
            f"{self.simulation.hand.name}: {len(layout.mass)} joints, "
            f"step {1e3 * self.simulation.step_size:g} ms"
        )

    def _compile(self) -> None:
        """Take one step and go back: it compiles what is not cached yet.

        Done later, between two samples, the seconds this takes look like a dead simulator, and the
        driver vents.
        """
        self.simulation.step(np.zeros(len(self.simulation.channels)))
        self.simulation.read_sensors()
        self.simulation.reset()

    def _create_topics(self) -> None:
        make = self.create_publisher
        self.sensors = make(JointState, "pneumaticbox/sensors", RELIABLE)
        self.joints = make(JointState, "hand/joint_states", RELIABLE)
        self.description = make(String, "robot_description", latched(1))
        self.fingertips = make(PoseArray, "hand/fingertips", RELIABLE)
        self.tip_angles = make(JointState, "hand/tip_angles", RELIABLE)
        self.wrench = make(WrenchStamped, "wrist/wrench", RELIABLE)
        self.wrist_pose = make(PoseStamped, "wrist/pose", RELIABLE)
        self.object_pose = make(PoseStamped, "scene/object_pose", RELIABLE)
        self._valves = Inbox(self, JointState, "pneumaticbox/valves", RELIABLE)
        self.create_subscription(PoseStamped, "wrist/target_pose", self._on_target, RELIABLE)

    def _create_services(self) -> None:
        offer_trigger(self, "sim/reset", self._reset)
        offer_trigger(self, "sim/step", self._step)
        offer_switch(self, "sim/pause", self._pause)

    def _prepare_messages(self) -> None:
        """Messages that are sent hundreds of times a second are made once."""
        self.wrist_frame = full_name(self, "wrist")
        self._sensor_message = JointState(name=[*self.simulation.channels, "supply"])
        self._joint_message = JointState(name=joint_names(self.simulation.bodies.layout))
        self._joint_message.header.frame_id = self.wrist_frame
        self._wrist_message, self._object_message = PoseStamped(), PoseStamped()
        self._wrist_message.header.frame_id = self._object_message.header.frame_id = "world"
        self._wrench_message = WrenchStamped()
        self._wrench_message.header.frame_id = "world"

    # ---------------------------------------------------------------- what comes in
    def _refuse(self, reason: str) -> None:
        """A message that cannot be used is refused whole, named in the log and in /diagnostics."""
        self.refused = [cut(reason)]
        self.refusals += 1
        self.get_logger().warning(f"refused {self.refused[0]}", throttle_duration_sec=1.0)

    def _take_valves(self, timeout: float = 0.0) -> None:
        """Obey the valves that have come; wait up to `timeout` [s] for the first."""
        message = self._valves.take(timeout)
        while message is not None:
            self._obey_valves(message)
            message = self._valves.take()

    def _obey_valves(self, message: JointState) -> None:
        try:
            if tuple(message.name) != self.simulation.channels:
                raise ValueError(
                    f"name: expected {list(self.simulation.channels)}, got {list(message.name)}"
                )
            self.watch.receive(self.simulation.time, message.position)
        except ValueError as error:
            self._refuse(f"pneumaticbox/valves: {error}")
            return
        self.driver_seen = True
        self.answered_stamp = nanoseconds(message.header.stamp)

    def _on_target(self, message: PoseStamped) -> None:
        p, o = message.pose.position, message.pose.orientation
        if message.header.frame_id not in ("", "world"):
            self._refuse(
                f"wrist/target_pose: header.frame_id: expected world, got {message.header.frame_id}"
            )
            return
        try:
            self.simulation.command_wrist(np.array([p.x, p.y, p.z]), np.array([o.x, o.y, o.z, o.w]))
        except ValueError as error:
            self._refuse(f"wrist/target_pose: {error}")

    def _reset(self) -> str:
        now = self.simulation.time
        self.simulation.reset()
        self.diverged = ""
        self._set_time(now if self.clock.follows else 0.0)
        return f"the simulation is back at its start, time {self.simulation.time:g}"

    def _set_time(self, now: float) -> None:
        """Have the simulation go on at another time [s]."""
        self.simulation.start += now - self.simulation.time
        self.watch.reset(now)
        self.answered_stamp = -1
        self.pace.restart(now)

    def _step(self) -> str:
        if self.diverged:
            raise ValueError(f"{self.diverged}: call sim/reset first")
        if not self.paused:
            raise ValueError("pause the simulation first (sim/pause)")
        self.single_steps += 1
        return "one sample further"

    def _pause(self, on: bool) -> str:
        if self.clock.follows:
            raise ValueError("it follows /clock: pause the simulation that publishes it")
        self.paused = on
        self.pace.restart(self.simulation.time)
        return "paused" if on else "running"

    # ---------------------------------------------------------------- what goes out
    def _publish_sensors(self) -> int:
        """Publish one sensor sample; returns its stamp [ns]."""
        message = self._sensor_message
        message.header.stamp = stamp_of_seconds(self.simulation.time)
        message.effort = array.array("d", self.simulation.read_sensors().tolist())
        self.sensors.publish(message)
        return nanoseconds(message.header.stamp)

    def publish_clock(self) -> None:
        """Tell the simulated time; while paused it goes on to be told, standing still."""
        self.clock.tell(self.simulation.time)

    def _publish_fast(self, stamp: Time) -> None:
        simulation = self.simulation
        if heard(self.wrist_pose):
            self._wrist_message.header.stamp = stamp
            _fill_pose(self._wrist_message.pose, *simulation.wrist_pose())
            self.wrist_pose.publish(self._wrist_message)
        if heard(self.wrench):
            self._publish_wrench(stamp)
        if simulation.object is not None and heard(self.object_pose):
            self._object_message.header.stamp = stamp
            _fill_pose(self._object_message.pose, *simulation.object_pose())
            self.object_pose.publish(self._object_message)

    def _publish_wrench(self, stamp: Time) -> None:
        self._wrench_message.header.stamp = stamp
        force, torque = self.simulation.wrist_wrench()
        wrench = self._wrench_message.wrench
        wrench.force.x, wrench.force.y, wrench.force.z = force.tolist()
        wrench.torque.x, wrench.torque.y, wrench.torque.z = torque.tolist()
        self.wrench.publish(self._wrench_message)

    def _publish_slow(self, stamp: Time) -> None:
        if heard(self.joints):
            message, q = self._joint_message, self.simulation.bodies.q
            message.header.stamp = stamp
            message.position = array.array("d", joint_positions(q).tolist())
            self.joints.publish(message)
        if heard(self.tip_angles):
            angles = self.simulation.read_tip_angles()
            tips = JointState(name=list(angles), position=array.array("d", angles.values()))
            tips.header.stamp = stamp
            self.tip_angles.publish(tips)
        if heard(self.fingertips):
            tip_poses = self.simulation.fingertips().values()
            poses = PoseArray(poses=[_fill_pose(Pose(), *tip) for tip in tip_poses])
            poses.header.stamp, poses.header.frame_id = stamp, self.wrist_frame
            self.fingertips.publish(poses)
        self.seen.publish_contacts(stamp)

    def _warnings(self) -> list[str]:
        """What a user should know now; refused messages are named once."""
        warnings, self.refused = [*self.refused, self.clock.warning(), clock_conflict(self)], []
        if self.watch.silent(self.simulation.time):
            warnings.append("no pneumaticbox/valves: outlets are open")
        missed, self.told_missed = self.missed_answers - self.told_missed, self.missed_answers
        if missed * LOCKSTEP_WAIT > MUCH_WAITING:
            warnings.append(f"the driver answers late: {missed} samples waited for it in vain")
        if self.count_publishers("pneumaticbox/sensors") > 1:
            text = "a second simulator publishes pneumaticbox/sensors on this domain"
            self.get_logger().warning(text + ": stop one, or give each its ROS_DOMAIN_ID")
            warnings.append(text)
        if self.simulation.stops.told:
            warnings.append(self.simulation.stops.told)
        return warnings

    def publish_diagnostics(self) -> None:
        """Once a second of wall time: state of the simulation and warnings."""
        values = {
            "simulated time [s]": f"{self.simulation.time:.3f}",
            "real-time factor": f"{self.pace.factor():.3f}",
            "answers missed in lockstep": str(self.missed_answers),
            "refused messages": str(self.refusals),
            "hand": self.simulation.hand.name,
        }
        state = "paused" if self.paused else "running"
        errors = [f"{self.diverged}: it stands until sim/reset"] if self.diverged else []
        self._executor.serve_rest()
        report = Report("simulation", state, self._warnings(), values, errors)
        self.diagnostics.publish([report], stamp_of_seconds(self.simulation.time))

    def close(self) -> None:
        """End the simulation."""
        self.simulation.close()
        self._executor.close()
        self.destroy_node()

    # ---------------------------------------------------------------- one sample
    def advance(self) -> None:
        """Publish a sample, simulate to the next one while the driver thinks, take its answer."""
        simulation = self.simulation
        before = simulation.time
        sample = self._publish_sensors()
        stale = self.watch.silent(before)
        valves = self.watch.valves(before)
        for _ in range(self.substeps):
            simulation.step(valves)
        self._wait_for_answer(sample, stale)
        self._executor.serve(SERVE_SLICE)
        stamp = stamp_of_seconds(simulation.time)
        if _crossed(before, simulation.time, FAST_PERIOD):
            self.publish_clock()
            self._publish_fast(stamp)
            self.transforms.publish(stamp)
        if _crossed(before, simulation.time, SLOW_PERIOD):
            self._publish_slow(stamp)
        if _crossed(before, simulation.time, self.marker_period):
            self.seen.publish_markers(stamp)

    def _wait_for_answer(self, sample: int, stale: bool) -> None:
        """In lockstep, up to 50 ms for the valves of this sample; else what has come."""
        self._take_valves()
        if not self.lockstep or stale:
            return
        deadline = time.monotonic() + LOCKSTEP_WAIT
        while self.answered_stamp < sample:
            left = deadline - time.monotonic()
            if left <= 0 or not self.driver_seen:
                self.missed_answers += int(left <= 0)
                return
            self._take_valves(left)

    def halt(self, reason: str) -> None:
        """Stand still with a simulation that has diverged; without clock and samples its driver
        vents.
        """
        self.diverged = reason
        self.get_logger().error(f"{reason}: it stands until sim/reset")
        self.publish_diagnostics()

    def stand(self) -> None:
        """Serve what comes while the simulation stands; paused, it goes on telling its time."""
        if not self.diverged:
            self.publish_clock()
        end = time.monotonic() + STANDING_PERIOD
        while self.stands and time.monotonic() < end:
            self.clock.wait(SERVE_PERIOD)
            self._take_valves()
            self._executor.serve(SERVE_SLICE)
        if change := self.clock.jump(self.simulation.time):
            self._set_time(self.simulation.time + change)

    @property
    def stands(self) -> bool:
        """Whether the simulation has diverged, waits for the clock that it follows, or is paused
        and no single step is wanted.
        """
        if self.diverged or not self.clock.allows(self.simulation.time):
            return True
        return self.paused and not self.single_steps


def _crossed(before: float, after: float, period: float) -> bool:
    """True when a multiple of `period` lies in (before, after]."""
    return int(after / period + 1e-6) > int(before / period + 1e-6)


def run(node: HandSim, stop: threading.Event) -> None:
    """Step and serve until `stop`."""
    told = 0.0
    while not stop.is_set():
        if node.stands:
            node.stand()
        else:
            node.single_steps = max(0, node.single_steps - 1)
            try:
                node.advance()
            except Diverged as reason:
                node.halt(str(reason))
            node.pace.wait(node.simulation.time)
        if time.monotonic() - told >= REPORT_PERIOD:
            node.publish_diagnostics()
            told = time.monotonic()


def main(args: list[str] | None = None) -> int:
    """Run the node; `run_node` tells the exit status."""
    return run_node(
        "hand_sim",
        HandSim,
        run,
        usage=HELP,
        args=args,
        failures=(RuntimeError, pybullet.error),  # no display, or the window was closed
    )


if __name__ == "__main__":
    sys.exit(main())
