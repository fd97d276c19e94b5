"""The plant's side of the driver in a test: it sends samples and waits for the valves of each."""

import array
import time

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from ros_peer import PATIENCE, Peer, seconds
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from softhand_model.pneumatics import PneumaticPlant

MODULE = "pneumaticbox_driver.ros.node"
CHANNELS = ["a", "b"]
VOLUME = 1e-4
BOX = {"channels": CHANNELS, "rest_volumes": [VOLUME] * 2, "pressure_limits": [1e5] * 2}
MG = 1e-6
DEEP = QoSProfile(depth=1000)


class PlantPeer(Peer):
    """The plant's side: sends samples and waits for the valves of each."""

    def __init__(self, domain, log_folder):
        super().__init__(domain, log_folder)
        self.put(VOLUME)
        self.valves = self.listen(JointState, "pneumaticbox/valves", DEEP)
        self.states = self.listen(JointState, "pneumaticbox/state", DEEP)
        self.told = self.listen(DiagnosticArray, "/diagnostics")

    def put(self, volume):
        """Put bottles of this volume [m3] on the channels of a new plant."""
        self.volumes = [volume] * len(CHANNELS)
        self.plant = PneumaticPlant(CHANNELS, self.volumes)
        self.rest = self.plant.rest_mass(self.volumes)

    def sample(self, readings=None, names=(*CHANNELS, "supply")):
        """Publish a sample of the plant's present, or other readings."""
        values = self.plant.read() if readings is None else np.array(readings, dtype=float)
        message = JointState(name=list(names), effort=array.array("d", values.tolist()))
        nanoseconds = round(self.plant.time * 1e9)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(nanoseconds, 10**9)
        self.publish(JointState, "pneumaticbox/sensors", message)

    def step(self, dt=0.002):
        """One lockstep: sample, the answer to just this sample, the plant by dt [s]."""
        self.sample()
        now = round(self.plant.time * 1e9)

        def answered():
            return self.valves and round(seconds(self.valves[-1].header.stamp) * 1e9) == now

        self.wait(answered, f"valves with stamp {now}")
        command = [int(value) for value in self.valves[-1].position]
        self.plant.step(dt, command, self.volumes)

    def connect(self):
        """Until the driver is there, and past its start."""
        self.wait(lambda: self.node.count_publishers("pneumaticbox/valves"), "the driver")
        self.wait(lambda: self.node.count_subscribers("pneumaticbox/sensors"), "the driver")
        self.run(0.6, 0.01)

    def run(self, duration, dt=0.002):
        for _ in range(round(duration / dt)):
            self.step(dt)

    def command(self, *masses, names=CHANNELS, **fields):
        point = JointTrajectoryPoint(positions=[float(mass) for mass in masses], **fields)
        message = JointTrajectory(joint_names=list(names), points=[point])
        self.deliver(JointTrajectory, "pneumaticbox/command", message)

    def change(self, name, value):
        """Set a parameter of the driver; why it was refused, "" when it was not."""
        changed = [Parameter(name, value=value).to_parameter_msg()]
        answer = self.call(SetParameters, "pneumaticbox/set_parameters", parameters=changed)
        result = answer.results[0]
        return "" if result.successful else result.reason

    def mass(self):
        return self.plant.mass - self.rest

    def diagnosis(self, *words, limit=PATIENCE, keep_going=True):
        """Wait for a status in which all words stand, the samples going on or not."""
        self.told.clear()
        end = time.monotonic() + limit
        while time.monotonic() < end:
            for message in self.told:
                for status in message.status:
                    if all(word in f"{status.name} {status.message}" for word in words):
                        return status
            if keep_going:
                self.step(0.01)
            self.spin(0.02)
        pytest.fail(f"no diagnostic with {words}")
