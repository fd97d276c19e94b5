"""The simulator node `hand_sim`: one thread steps the world and serves ROS."""

from __future__ import annotations

import array
import math
import sys
import threading
import time
from collections.abc import Callable

import numpy as np
from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from pneuflex_sim.bullet import failures
from pneuflex_sim.ros.clock import Pace, shared_clock
from pneuflex_sim.ros.command_topics import CommandTopics
from pneuflex_sim.ros.driver_link import SENSORS, VALVES, DriverLink, Obey, TopicLink
from pneuflex_sim.ros.interface import HELP
from pneuflex_sim.ros.lockstep import COMMANDS_WAIT, Commanders
from pneuflex_sim.ros.markers import SceneMarkers
from pneuflex_sim.ros.parameters import CHANGING_RATES, PARAMETERS, configuration
from pneuflex_sim.ros.state_topics import StateTopics
from pneuflex_sim.ros.transforms import Transforms
from pneuflex_sim.simulation import Simulation
from pneuflex_sim.urdf import write_urdf
from pneuflex_sim.world import Diverged
from softhand_common.numerics.compiled import compilation_announced
from softhand_model.pneumatics.valves import CommandWatch
from softhand_ros.diagnostics import REPORT_PERIOD, Diagnostics, Preparation, Report, cut
from softhand_ros.executor import RoundRobin
from softhand_ros.parameters import Table, declare
from softhand_ros.run_node import run_node
from softhand_ros.services import offer_switch, offer_trigger
from softhand_ros.single import ALLOW_SECOND, Single
from softhand_ros.topics import RELIABLE, clock_conflict, latched, stamp_of_seconds

SERVE_SLICE = 0.001  # wall time for messages and services after a sample [s]
SERVE_PERIOD = 0.01  # wall time between checks of services while the simulation stands [s]
STANDSTILL_CLOCK_PERIOD = 0.1  # wall time between ticks while the simulation stands [s]
SENSOR_PERIOD = 0.002  # shortest time between sensor samples [s]
CONTACTS_PERIOD = 0.02  # [s]
FAST_PERIOD = 0.01  # clock, wrist, object [s]


LinkTo = Callable[[Node, Obey, Callable[[], bool]], DriverLink]


class HandSim(Node):
    """Publishes the state of the hand; applies commands to valves, wrist and object.

    Args:
        link_to: makes the `DriverLink` to the driver.
        neighbours: parameters of other nodes in this process.
    """

    def __init__(self, link_to: LinkTo = TopicLink, neighbours: Table = ()) -> None:
        super().__init__("hand_sim")
        self._single = Single(self, "simulator", SENSORS)
        value = declare(self, PARAMETERS, neighbours)
        self.stop = threading.Event()  # the node is to end
        self.diagnostics = Diagnostics(self, "hand_sim", "pneuflex_sim")
        with Preparation(self, self.diagnostics, "simulation") as tell, compilation_announced(tell):
            self.simulation = Simulation(configuration(value))
            self._compile()
        self._single.claim(value[ALLOW_SECOND.name])
        self.lockstep, self.paused, self.single_steps = value["lockstep"], False, 0
        self.watch = CommandWatch(len(self.simulation.channels))
        self.refused: list[str] = []
        self.refusals, self.diverged = 0, ""
        self.pace = Pace(value["real_time_factor"])
        self.clock = shared_clock(self, value["publish_clock"])
        self.ticked = self.simulation.time  # of the last tick of /clock [s]
        self.substeps = math.ceil(SENSOR_PERIOD / self.simulation.step_size - 1e-9)
        self.commanders = Commanders(self, value["await_commander"])
        self.command_topics = CommandTopics(self, self.simulation, self._refuse)
        self.description = self.create_publisher(String, "robot_description", latched(1))
        self.driver = link_to(self, self._obey_valves, lambda: self.stop.is_set())
        self._create_services()
        self._sensor_message = JointState(name=[*self.simulation.channels, "supply"])
        self.state_topics = StateTopics(self, self.simulation)
        self.markers = SceneMarkers(self, self.simulation, RELIABLE)
        self.transforms = Transforms(self, self.simulation)
        self.marker_period = 1.0 / value["marker_rate"]
        self.rates = {name: value[name] for name in CHANGING_RATES}
        self.add_on_set_parameters_callback(self._set_rates)
        self._executor = RoundRobin(self)
        layout = self.simulation.bodies.layout
        self.description.publish(String(data=write_urdf(layout)))
        self.get_logger().info(
            f"ready: {self.simulation.hand.name}, {len(layout.mass)} joints, "
            f"step {1e3 * self.simulation.step_size:g} ms"
        )

    def _compile(self) -> None:
        """Take one step and reset, so that kernels that are not cached are compiled now.

        Compiling between two samples would take seconds, in which the driver would vent for want of
        samples.
        """
        self.simulation.step(np.zeros(len(self.simulation.channels)))
        self.simulation.read_sensors()
        self.simulation.reset()

    def _create_services(self) -> None:
        offer_trigger(self, "sim/reset", self._reset)
        offer_trigger(self, "sim/step", self._step)
        offer_switch(self, "sim/pause", self._pause)

    def _set_rates(self, changes: list[Parameter]) -> SetParametersResult:
        self.rates |= {
            change.name: change.value for change in changes if change.name in CHANGING_RATES
        }
        return SetParametersResult(successful=True)

    # ---------------------------------------------------------------- what comes in
    def _refuse(self, reason: str) -> None:
        """Report a message that cannot be used in the log and in /diagnostics; it is ignored as a
        whole.
        """
        self.refused = [cut(reason)]
        self.refusals += 1
        self.get_logger().warning(f"refused {self.refused[0]}", throttle_duration_sec=1.0)

    def _obey_valves(self, message: JointState) -> bool:
        """Apply a command of the driver; whether it could be used."""
        try:
            if tuple(message.name) != self.simulation.channels:
                raise ValueError(
                    f"name: expected {list(self.simulation.channels)}, got {list(message.name)}"
                )
            self.watch.receive(self.simulation.time, message.position)
        except ValueError as error:
            self._refuse(f"{VALVES}: {error}")
            return False
        return True

    def _reset(self) -> str:
        now = self.simulation.time
        self.simulation.reset()
        self.diverged = ""
        self.commanders.restart()
        self.command_topics.forget()
        self._set_time(now if self.clock.follows else 0.0)
        return f"the simulation is back at its start, time {self.simulation.time:g}"

    def _set_time(self, now: float) -> None:
        """Let the simulation go on at another time [s]."""
        self.simulation.start += now - self.simulation.time
        self.watch.reset(now)
        self.ticked = now
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
            raise ValueError(
                "this simulation follows /clock: pause the simulation that publishes it"
            )
        self.paused = on
        self.pace.restart(self.simulation.time)
        return "paused" if on else "running"

    # ---------------------------------------------------------------- what goes out
    def _send_sensors(self) -> None:
        """Hand a sensor sample to the driver."""
        message = self._sensor_message
        message.header.stamp = stamp_of_seconds(self.simulation.time)
        message.effort = array.array("d", self.simulation.read_sensors().tolist())
        self.driver.send(message)

    def publish_clock(self) -> None:
        """Publish the simulated time."""
        self.ticked = self.simulation.time
        self.clock.publish_time(self.ticked)

    def _publish_standing(self) -> None:
        """Publish the time while the simulation stands. While it waits for commanders that is the
        last tick: another one, which depends on the machine's load, would move their next command.
        """
        if self.paused or self.clock.follows:
            self.publish_clock()
        else:
            self.clock.publish_time(self.ticked)

    def _warnings(self) -> list[str]:
        """Warnings for the user; refused messages are named once."""
        warnings, self.refused = [*self.refused, self.clock.warning(), clock_conflict(self)], []
        if self.watch.silent(self.simulation.time):
            warnings.append("no pneumaticbox/valves: outlets are open")
        warnings.append(self.driver.warning())
        warnings.append(self._single.warning())
        if self.simulation.stops.warning:
            warnings.append(self.simulation.stops.warning)
        return warnings

    def publish_diagnostics(self) -> None:
        """Publish state and warnings of the simulation, once a second of wall time."""
        values = {
            "simulated time [s]": f"{self.simulation.time:.3f}",
            "real-time factor": f"{self.pace.factor():.3f}",
            "answers missed in lockstep": str(self.driver.missed),
            "refused messages": str(self.refusals),
            "hand": self.simulation.hand.name,
            "object": self.simulation.object.name if self.simulation.object else "",
        }
        awaiting = "waits at its start for a strategy" if self.commanders.awaited else "running"
        state = "paused" if self.paused else awaiting
        errors = (
            [f"{self.diverged}: the simulation is stopped until sim/reset"] if self.diverged else []
        )
        self._executor.serve_rest()
        report = Report("simulation", state, self._warnings(), values, errors)
        self.diagnostics.publish([report], stamp_of_seconds(self.simulation.time))

    def close(self) -> None:
        """End the driver, where it is in this process, and the simulation."""
        self.driver.close()
        self.simulation.close()
        self._executor.close()
        self.destroy_node()

    # ---------------------------------------------------------------- one sample
    def advance(self) -> None:
        """Publish a sample, simulate to the next one while the driver computes, receive its
        answer.
        """
        simulation = self.simulation
        before = simulation.time
        heard, paced = self.commanders.heard(), self.lockstep and self.commanders.commanding
        self.command_topics.obey(before, heard or not paced)
        self._send_sensors()
        stale = self.watch.silent(before)
        valves = self.watch.valves(before)
        for _ in range(self.substeps):
            simulation.step(valves)
        wait = self.lockstep and not stale
        self.driver.await_answer(wait, heard or not wait)
        self._executor.serve(SERVE_SLICE)
        self._publish_state(before)
        self.driver.serve()

    def _publish_state(self, before: float) -> None:
        """Publish what is due since the time `before` [s]. The tick comes last, so that its
        receivers already have the state of its time.
        """
        now = self.simulation.time
        stamp = stamp_of_seconds(now)
        if _crossed(before, now, self.marker_period):
            self.markers.publish_markers(stamp)
        if _due(before, now, self.rates["joint_rate"]):
            self.state_topics.publish_joints(stamp)
        if _crossed(before, now, CONTACTS_PERIOD):
            self.markers.publish_contacts(stamp)
        if _due(before, now, self.rates["wrench_rate"]):
            self.state_topics.publish_wrench(stamp)
        if _crossed(before, now, FAST_PERIOD):
            self.state_topics.publish_fast(stamp)
            self.transforms.publish(stamp)
            self.publish_clock()

    def halt(self, reason: str) -> None:
        """Stop the diverged simulation and its air flow until `sim/reset`; the reason is logged."""
        self.diverged = reason
        self.get_logger().error(f"{reason}: the simulation is stopped until sim/reset")
        self.publish_diagnostics()

    def stand(self) -> None:
        """Serve messages and services while the simulation is stopped; a paused simulation still
        publishes its time.
        """
        if not self.diverged:
            self._publish_standing()
        end = time.monotonic() + STANDSTILL_CLOCK_PERIOD
        while self.stands and time.monotonic() < end:
            self.clock.wait(SERVE_PERIOD)
            self.driver.look()
            self.command_topics.obey(self.simulation.time)
            self._executor.serve(SERVE_SLICE)
            self.driver.serve()
        if change := self.clock.jump(self.simulation.time):
            self._set_time(self.simulation.time + change)

    @property
    def stands(self) -> bool:
        """Whether the simulation is stopped: it has diverged, waits for the clock that it follows
        or for its commanders, or is paused without a pending single step.
        """
        now = self.simulation.time
        if self.diverged or not self.clock.allows(now):
            return True
        if self.paused and not self.single_steps:
            return True
        return self.lockstep and self.commanders.hold(now)

    def await_commands(self) -> None:
        """In lockstep, wait at most `COMMANDS_WAIT` [s] of wall time for those commanders whose
        last command is not stamped later than the simulated time.
        """
        if self.lockstep and not self.paused and not self.diverged:
            self.commanders.hold(self.simulation.time, COMMANDS_WAIT)


def _crossed(before: float, after: float, period: float) -> bool:
    """True when a multiple of `period` lies in (before, after]."""
    return int(after / period + 1e-6) > int(before / period + 1e-6)


def _due(before: float, after: float, rate: float) -> bool:
    """Whether a topic of this rate [Hz], 0 for every sample, is due."""
    return not rate or _crossed(before, after, 1.0 / rate)


def run(node: HandSim, stop: threading.Event) -> None:
    """Step the simulation and serve ROS until `stop` is set."""
    reported_at = 0.0
    node.stop = stop
    while not stop.is_set():
        node.await_commands()
        if node.stands:
            node.stand()
        else:
            node.single_steps = max(0, node.single_steps - 1)
            try:
                node.advance()
            except Diverged as reason:
                node.halt(str(reason))
            node.pace.wait(node.simulation.time)
        if time.monotonic() - reported_at >= REPORT_PERIOD:
            node.publish_diagnostics()
            reported_at = time.monotonic()


def main(args: list[str] | None = None) -> int:
    """Run the node; returns the exit status of `run_node`."""
    return run_node("hand_sim", HandSim, run, usage=HELP, args=args, failures=failures())


if __name__ == "__main__":
    sys.exit(main())
