"""What tests ask of the driver and the node `faulty_plant`, each a process of its own."""

import os
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray
from ros_peer import PATIENCE, Peer, seconds
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from softhand_bringup.processes.launcher import NodeCommand

MODULE = "faulty_plant_node"


def plant_command(**parameters):
    """The plant as a process; it wants `plant_path` in its environment."""
    return NodeCommand("faulty_plant", MODULE, parameters)


def plant_path():
    """Environment with which `faulty_plant_node` is found."""
    paths = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    return {"PYTHONPATH": os.pathsep.join(path for path in paths if path)}


class FaultyPlantPeer(Peer):
    """A peer that gives the plant its orders and knows the truth."""

    def __init__(self, domain, log_folder, channels):
        super().__init__(domain, log_folder)
        self.channels = list(channels)
        self.truths = self.listen(JointState, "plant/truth", 1000)
        self.obeyed = self.listen(String, "plant/obeyed")
        self.told = self.listen(DiagnosticArray, "/diagnostics")

    def connect(self):
        """Until the driver answers the plant's samples."""
        states = self.listen(JointState, "pneumaticbox/state")
        self.wait(lambda: states and self.truths, "driver and plant")
        self.pass_time(0.8)

    @property
    def truth(self):
        return self.truths[-1]

    def time(self):
        """What the plant's clock shows [s]."""
        return seconds(self.truth.header.stamp)

    def pass_time(self, duration, limit=PATIENCE):
        """Let so much of the plant's time [s] pass."""
        del self.truths[:-1]
        end = self.time() + duration
        self.wait(lambda: self.time() >= end, f"{duration} s of the plant's time", limit)

    def order(self, text, limit=PATIENCE):
        """Give the plant an order and wait until it has obeyed."""
        self.obeyed.clear()
        self.publish(String, "plant/order", String(data=text))
        self.wait(lambda: any(m.data == text for m in self.obeyed), f"order {text}", limit)

    def command(self, *masses):
        """Command air masses [kg]."""
        point = JointTrajectoryPoint(positions=[float(mass) for mass in masses])
        message = JointTrajectory(joint_names=self.channels, points=[point])
        self.publish(JointTrajectory, "pneumaticbox/command", message)

    def trigger(self, service):
        return self.call(Trigger, f"pneumaticbox/{service}")

    def diagnosis(self, *words, limit=PATIENCE):
        """Wait for a diagnostic status in which all words stand; its text."""
        self.told.clear()

        def told():
            for message in self.told:
                for status in message.status:
                    text = f"{status.name}: {status.message}"
                    if all(word in text for word in words):
                        return text
            return None

        return self.wait(told, f"a diagnostic with {words}", limit)
