"""A process that answers like simulator and driver, with the behaviour of MockScene.

It ends by itself after `--life` [s] of wall time, and on SIGINT or SIGTERM.
"""

import argparse
import math
import signal
import sys
import time
from pathlib import Path

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped, WrenchStamped
from mock_scene import CHANNELS, MockScene
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Int32
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import Marker, MarkerArray

from softhand_ros.diagnostics import PREPARING

STEP = 0.01


def options():
    parser = argparse.ArgumentParser()
    parser.add_argument("--parts", default="simulator,driver")
    parser.add_argument("--factor", type=float, default=5.0)
    parser.add_argument("--life", type=float, default=60.0)
    parser.add_argument("--slip", type=float, default=0.0)
    parser.add_argument("--refuse-vent", action="store_true")
    parser.add_argument("--command-timeout", type=float, default=0.0, help="of the driver [s]")
    parser.add_argument("--preparing", type=Path, help="nothing begins while this file is there")
    parser.add_argument("--spoil-every", type=int, default=0, help="every n-th object pose is NaN")
    return parser.parse_args()


class MockBench(Node):
    def __init__(self, arguments):
        super().__init__("mock_bench")
        self.arguments, self.paused, self.ticks = arguments, False, 0
        self.scene = MockScene(slip_speed=arguments.slip)
        if "simulator" in arguments.parts:
            self.offer_simulator()
        if "driver" in arguments.parts:
            self.offer_driver()

    def offer_simulator(self):
        self.clock_out = self.create_publisher(Clock, "/clock", 10)
        self.wrist_out = self.create_publisher(PoseStamped, "wrist/pose", 10)
        self.object_out = self.create_publisher(PoseStamped, "scene/object_pose", 10)
        self.wrench_out = self.create_publisher(WrenchStamped, "wrist/wrench", 10)
        self.contacts_out = self.create_publisher(MarkerArray, "hand/contacts", 10)
        self.create_subscription(PoseStamped, "wrist/target_pose", self.on_target, 10)
        self.create_service(SetBool, "sim/pause", self.on_pause)

    def offer_driver(self):
        self.state_out = self.create_publisher(JointState, "pneumaticbox/state", 10)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.vents_out = self.create_publisher(Int32, "mock/vents", latched)
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.told = 0.0
        self.create_service(Trigger, "pneumaticbox/reset", self.on_reset)
        self.create_subscription(JointTrajectory, "pneumaticbox/command", self.on_command, 10)
        self.create_service(Trigger, "pneumaticbox/vent", self.on_vent)
        self.create_service(SetBool, "pneumaticbox/enable", self.on_enable)
        self.enabled, self.commanded = True, math.inf

    def on_target(self, message):
        place, turn = message.pose.position, message.pose.orientation
        self.scene.command_wrist([place.x, place.y, place.z], [turn.x, turn.y, turn.z, turn.w])

    def on_command(self, message):
        if self.scene.vented:
            return  # latched, as the driver does
        self.commanded = self.scene.time
        by_name = dict(zip(message.joint_names, message.points[-1].positions, strict=True))
        self.scene.command_air(np.array([by_name[name] for name in CHANNELS]))

    def on_vent(self, request, response):
        response.success, response.message = not self.arguments.refuse_vent, "as asked"
        if response.success:
            self.scene.vent()
            self.vents_out.publish(Int32(data=self.scene.vented))
        return response

    def on_enable(self, request, response):
        self.enabled, response.success = request.data, True
        self.tell_diagnostics()
        return response

    def on_reset(self, request, response):
        self.scene.vented = 0
        response.success = True
        return response

    def tell_diagnostics(self):
        vented = bool(self.scene.vented)
        level = DiagnosticStatus.ERROR if vented else DiagnosticStatus.OK
        text = "vented until pneumaticbox/reset" if vented else "in operation"
        if not self.enabled:
            level, text = DiagnosticStatus.WARN, "disabled: valves are closed"
        status = DiagnosticStatus(name="pneumaticbox: safety", level=level, message=text)
        self.diagnostics.publish(DiagnosticArray(status=[status]))

    def tell_preparing(self):
        status = DiagnosticStatus(
            name="hand_sim: simulation",
            level=DiagnosticStatus.WARN,
            message="compiling the numerical kernels",
            values=[KeyValue(key=PREPARING, value="yes")],
        )
        self.diagnostics.publish(DiagnosticArray(status=[status]))

    def on_pause(self, request, response):
        self.paused = response.success = request.data
        return response

    def tick(self):
        self.ticks += 1
        stamp = Time(nanoseconds=round(self.scene.time * 1e9)).to_msg()
        if "simulator" in self.arguments.parts:
            self.clock_out.publish(Clock(clock=stamp))
        if self.paused:
            return
        self.scene.step(STEP)
        seen = self.scene.observe()
        if "simulator" in self.arguments.parts:
            self.publish_simulator(seen, stamp)
        if "driver" in self.arguments.parts:
            state = JointState(name=list(CHANNELS), position=seen.air_mass, effort=seen.pressure)
            state.header.stamp = stamp
            limit = self.arguments.command_timeout
            if limit and self.scene.time - self.commanded > limit:
                self.scene.vent()
            self.state_out.publish(state)
            if time.monotonic() - self.told > 1.0:
                self.told = time.monotonic()
                self.tell_diagnostics()

    def publish_simulator(self, seen, stamp):
        every = self.arguments.spoil_every
        place = seen.object_position * (np.nan if every and self.ticks % every == 0 else 1.0)
        self.object_out.publish(pose(stamp, place, seen.object_orientation))
        self.wrist_out.publish(pose(stamp, seen.wrist_position, seen.wrist_orientation))
        wrench = WrenchStamped()
        wrench.header.stamp = stamp
        wrench.wrench.force.z = float(seen.wrist_force[2])
        self.wrench_out.publish(wrench)
        pairs = [f"{b}/object" if b != "table" else "object/table" for b in sorted(seen.touching)]
        markers = [Marker(action=Marker.DELETEALL), *(Marker(ns=pair) for pair in pairs)]
        self.contacts_out.publish(MarkerArray(markers=markers))


def pose(stamp, position, orientation):
    message = PoseStamped()
    message.header.stamp, message.header.frame_id = stamp, "world"
    place, turn = message.pose.position, message.pose.orientation
    place.x, place.y, place.z = map(float, position)
    turn.x, turn.y, turn.z, turn.w = map(float, orientation)
    return message


def main():
    arguments = options()
    stop = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.append(True))
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node = MockBench(arguments)
    executor = EventsExecutor()
    executor.add_node(node)
    begin = due = time.monotonic()
    while not stop and arguments.preparing and arguments.preparing.exists():
        node.tell_preparing()
        executor.spin_once(timeout_sec=0.2)
    while not stop and time.monotonic() - begin < arguments.life:
        node.tick()
        due = max(due + STEP / arguments.factor, time.monotonic())  # late: slower, never faster
        while (left := due - time.monotonic()) > 0:
            executor.spin_once(timeout_sec=left)
        executor.spin_once(timeout_sec=0)
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
