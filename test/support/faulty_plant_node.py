"""The node `faulty_plant`: bottles, relief valves and faults behind the simulator's topics.

Like hand_sim it publishes /clock and `pneumaticbox/sensors` and follows `pneumaticbox/valves` in
lockstep. It takes orders (`FaultyPlant.order`) as std_msgs/String on `plant/order`, says those it
has obeyed on `plant/obeyed`, and tells the truth on `plant/truth`: position = mass [kg], velocity =
highest gauge pressure since the last order [Pa], effort = gauge pressure [Pa].

    python -m faulty_plant_node --ros-args -p channels:=[a,b]
"""

import array
import signal
import sys
import threading
import time

import rclpy
from builtin_interfaces.msg import Time
from faulty_plant import FaultyPlant
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from pneuflex_sim.ros.clock import Pace

PERIOD = 0.002  # of the sensor samples [s]
SLOW = 5  # samples between ticks of the clock, and between truths
ANSWER_LIMIT = 0.05  # wall time to wait for the valves that answer a sample [s]
DEFAULTS = {
    "channels": ["a", "b"],
    "volumes": [30e-6, 30e-6],
    "limits": [80e3, 80e3],
    "supply": 300e3,
    "seed": 0,
    "relief": True,
    "real_time_factor": 2.0,
}


class FaultyPlantNode(Node):
    """Publishes samples and truth, obeys valves and orders."""

    def __init__(self):
        super().__init__("faulty_plant")
        for name, value in DEFAULTS.items():
            self.declare_parameter(name, value)
        value = {name: self.get_parameter(name).value for name in DEFAULTS}
        self.pace = Pace(value.pop("real_time_factor"))
        self.plant = FaultyPlant(**value)
        self.answered, self.heard = -1, False
        self.clock = self.create_publisher(Clock, "/clock", 10)
        self.sensors = self.create_publisher(JointState, "pneumaticbox/sensors", 10)
        self.truth = self.create_publisher(JointState, "plant/truth", 10)
        self.obeyed = self.create_publisher(String, "plant/obeyed", 10)
        self.create_subscription(JointState, "pneumaticbox/valves", self.on_valves, 10)
        self.create_subscription(String, "plant/order", self.on_order, 10)
        self.sample = JointState(name=[*self.plant.channels, "supply"])

    def on_valves(self, message):
        self.plant.receive([int(value) for value in message.position])
        self.answered, self.heard = _nanoseconds(message.header.stamp), True

    def on_order(self, message):
        try:
            self.plant.order(message.data)
        except (ValueError, TypeError) as error:
            self.get_logger().error(f"{message.data}: {error}")
        else:
            self.obeyed.publish(message)

    def advance(self, executor, count):
        """Publish a sample, wait for its answer, let the plant run to the next one."""
        plant = self.plant
        stamp = _stamp(plant.stamp)
        self.sample.header.stamp = stamp
        self.sample.effort = array.array("d", plant.plant.read().tolist())
        self.sensors.publish(self.sample)
        if count % SLOW == 0:
            self.clock.publish(Clock(clock=stamp))
            self.publish_truth(stamp)
        self.wait_for_answer(executor, _nanoseconds(stamp))
        plant.advance(PERIOD)

    def wait_for_answer(self, executor, sample):
        executor.spin_once(timeout_sec=0)
        deadline = time.monotonic() + ANSWER_LIMIT
        # a driver that has been silent for long is gone, and not to be waited for
        while self.heard and not self.plant.silent and self.answered != sample:
            left = deadline - time.monotonic()
            if left <= 0:
                return
            executor.spin_once(timeout_sec=left)

    def publish_truth(self, stamp):
        plant = self.plant
        truth = JointState(name=list(plant.channels))
        truth.header.stamp = stamp
        truth.position = array.array("d", plant.mass.tolist())
        truth.velocity = array.array("d", plant.peak.tolist())
        truth.effort = array.array("d", plant.gauge.tolist())
        self.truth.publish(truth)


def _nanoseconds(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


def _stamp(seconds):
    sec, nanosec = divmod(round(seconds * 1e9), 10**9)
    return Time(sec=sec, nanosec=nanosec)


def main():
    """Run until SIGINT or SIGTERM."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    node = FaultyPlantNode()
    executor = EventsExecutor(context=node.context)
    executor.add_node(node)
    count = 0
    while not stop.is_set():
        node.advance(executor, count)
        node.pace.wait(node.plant.plant.time)
        count += 1
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
