"""What system tests ask of the suite's nodes, in the words of the interface."""

import math
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_peer import LATCHED, PATIENCE, Peer, seconds
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from softhand_bringup.processes.launcher import NodeDied
from softhand_ros.diagnostics import PREPARING

EVERY_PHASE = QoSProfile(depth=50, durability=DurabilityPolicy.TRANSIENT_LOCAL)

AMBIENT = 101_325.0  # [Pa]
CHANNELS = ["a", "b", "c", "d"]  # of RBO Hand 2


class SuitePeer(Peer):
    """A peer that knows the suite's topics and services, and the launcher of its nodes."""

    launcher = None

    def state(self):
        """Latest state of the driver, or None."""
        return next(reversed(self.listen(JointState, "pneumaticbox/state")), None)

    def sensors(self):
        """Latest absolute pressures [Pa] of the channels, as the plant's sensors tell, or None."""
        sample = next(reversed(self.listen(JointState, "pneumaticbox/sensors")), None)
        return None if sample is None else list(sample.effort)[:-1]

    def valves(self):
        """Latest valve states, or None."""
        message = next(reversed(self.listen(JointState, "pneumaticbox/valves")), None)
        return None if message is None else list(message.position)

    def phases(self):
        """Names of the phases so far."""
        return [message.data for message in self.listen(String, "grasp/phase", EVERY_PHASE)]

    def result(self):
        """Key-value pairs of the last grasp/result."""
        results = self.listen(DiagnosticArray, "grasp/result", LATCHED)
        return {p.key: p.value for p in results[-1].status[0].values} if results else {}

    def time(self):
        """Simulated time [s], or None."""
        tick = next(reversed(self.listen(Clock, "/clock")), None)
        return None if tick is None else seconds(tick.clock)

    def wait_for_driver(self):
        """Until the driver answers the simulator's samples; while a node says that it prepares, as
        when it compiles on a busy machine, the limit does not count.
        """
        reports = self.listen(DiagnosticArray, "/diagnostics")
        seen, end = 0, time.monotonic() + PATIENCE
        while not self.state() and time.monotonic() < end:
            self.spin(0.5)
            fresh, seen = reports[seen:], len(reports)
            if any(v.key == PREPARING for a in fresh for s in a.status for v in s.values):
                end = time.monotonic() + PATIENCE
        self.wait(self.state, "a message on pneumaticbox/state", 0.0)
        self.wait(self.time, "a tick of /clock")

    def pass_time(self, duration, limit=PATIENCE):
        """Let so much simulated time [s] pass."""
        end = self.time() + duration
        self.wait(lambda: self.time() >= end, f"{duration} s of simulated time", limit)

    def command(self, masses, channels=None, after=0.0):
        """Command air masses [kg] on pneumaticbox/command."""
        message = JointTrajectory(joint_names=CHANNELS if channels is None else channels)
        point = JointTrajectoryPoint(positions=[float(m) for m in masses])
        point.time_from_start.sec = math.floor(after)
        point.time_from_start.nanosec = round(after % 1 * 1e9)
        message.points = [point]
        self.publish(JointTrajectory, "pneumaticbox/command", message)

    def grasp(self):
        """Call the grasp; a future."""
        return self.request(Trigger, "grasp/surface_constrained", limit=PATIENCE)

    def trigger(self, service, limit=PATIENCE):
        """Call a Trigger service and wait for its answer."""
        return self.call(Trigger, service, limit)

    def troubles(self):
        """A node that has ended, and diagnostics that are not OK, as heard for two of their
        periods.
        """
        arrays = self.listen(DiagnosticArray, "/diagnostics")
        del arrays[:]
        self.spin(2.0)
        found = [s for array in arrays for s in array.status if s.level != DiagnosticStatus.OK]
        return "; ".join(["", *self._ended(), *sorted(set(map(status_text, found)))])

    def _ended(self):
        try:
            if self.launcher is not None:
                self.launcher.check()
        except NodeDied as ended:
            return [str(ended)]
        return []

    def diagnosis(self, *words, limit=PATIENCE, heard=False):
        """Wait for a diagnostic status in which all these words stand; its text. What was `heard`
        since the last look counts as well, if asked for.
        """
        arrays = self.listen(DiagnosticArray, "/diagnostics")
        if not heard:
            del arrays[:]

        def told():
            texts = [status_text(status) for array in arrays for status in array.status]
            return next((t for t in texts if all(word in t for word in words)), None)

        return self.wait(told, f"a diagnostic with {words}", limit)


def status_text(status):
    """All of a diagnostic status in one line."""
    values = ", ".join(f"{pair.key}: {pair.value}" for pair in status.values)
    return f"{status.name}: {status.message} ({values})"
