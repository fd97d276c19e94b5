"""A test's own ROS node: what it hears, says and calls."""

import os
import time

import rclpy
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions

from softhand_bringup.processes.suite import node_environment

PATIENCE = 60.0  # [s] a busy machine may take to do what an idle one does at once
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Peer:
    """Keeps every message of the topics it listens to; spins only while it waits."""

    def __init__(self, domain, log_folder):
        os.environ.update(node_environment(log_folder, domain))
        self._context = Context()
        rclpy.init(
            context=self._context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
        )
        self.node = Node("test_peer", context=self._context, enable_rosout=False)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._heard = {}
        self._publishers = {}

    def close(self):
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)

    def spin(self, duration):
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0:
            self._executor.spin_once(timeout_sec=left)

    def wait(self, condition, what, limit=PATIENCE):
        """Spin until `condition()`; fail the test with `what` when `limit` [s] is over."""
        end = time.monotonic() + limit
        while not (found := condition()):
            if time.monotonic() > end:
                raise AssertionError(f"not within {limit} s: {what}{self.troubles()}")
            self._executor.spin_once(timeout_sec=0.05)
        return found

    def troubles(self):
        """What to add when something did not come."""
        return ""

    def listen(self, kind, topic, qos=50):
        """The growing list of a topic's messages."""
        if topic not in self._heard:
            heard = self._heard[topic] = []
            self.node.create_subscription(kind, topic, heard.append, qos)
        return self._heard[topic]

    def publish(self, kind, topic, message, limit=PATIENCE):
        """Publish once somebody listens."""
        if topic not in self._publishers:
            self._publishers[topic] = self.node.create_publisher(kind, topic, 10)
        publisher = self._publishers[topic]
        self.wait(publisher.get_subscription_count, f"a subscriber of {topic}", limit)
        publisher.publish(message)
        return publisher

    def deliver(self, kind, topic, message, limit=PATIENCE):
        """Publish, and wait until everybody who listens has it: a reader that has not yet
        discovered this writer gets the message late, when it is sent again.
        """
        publisher = self.publish(kind, topic, message, limit)
        if not publisher.wait_for_all_acked(Duration(seconds=limit)):
            raise AssertionError(f"{topic}: a message did not arrive within {limit} s")

    def request(self, kind, service, limit=PATIENCE, **fields):
        """Call a service without waiting for the answer: a future."""
        client = self.node.create_client(kind, service)
        self.wait(client.service_is_ready, f"service {service}", limit)
        return client.call_async(kind.Request(**fields))

    def call(self, kind, service, limit=PATIENCE, **fields):
        """Call a service and wait for its answer; again once when none has come in 5 s:
        a service that has not yet discovered the caller's reader loses its answer.
        """
        futures = [self.request(kind, service, **fields)]
        end = time.monotonic() + min(5.0, limit / 4)

        def answer():
            if len(futures) == 1 and time.monotonic() > end:
                futures.append(self.request(kind, service, **fields))
            return next((future for future in futures if future.done()), None)

        return self.wait(answer, f"an answer of {service}", limit).result()


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec
