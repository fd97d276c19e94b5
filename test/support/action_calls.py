"""A test's goals to an action of a node in another process, and what that node finds there."""

import os

from rclpy.action import ActionClient

from softhand_bringup.processes.suite import node_environment


def environment_with(log_folder, domain, *folders):
    """The environment of a node with these folders first on its PYTHONPATH."""
    environment = node_environment(log_folder, domain)
    paths = [*map(str, folders), environment.get("PYTHONPATH", "")]
    return environment | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}


def folder_without_types(folder):
    """The folder, with a control_msgs in it that cannot be imported."""
    (folder / "control_msgs.py").write_text("raise ImportError('as where it is not installed')")
    return folder


def check_nothing_offered(peer, node, process):
    """The process of a node has said in one line that it has no action, and offers none."""
    told = [line for line in process.output().splitlines() if "control_msgs" in line]
    assert len(told) == 1 and "[INFO]" in told[0] and "is not offered" in told[0]
    services = [name for name, _ in peer.node.get_service_names_and_types_by_node(node, "/")]
    assert services and not [name for name in services if "/_action/" in name]


class Goal:
    """A goal that was sent: whether it was accepted, its feedback so far, its result.

    `wait(condition, what)` is how the test waits, while the node has what it needs.
    """

    def __init__(self, peer, kind, name, goal, wait=None):
        self._wait = wait or peer.wait
        self._client = ActionClient(peer.node, kind, name)
        peer.wait(self._client.server_is_ready, f"the action {name}")
        self.feedback = []
        sent = self._client.send_goal_async(
            goal, feedback_callback=lambda message: self.feedback.append(message.feedback)
        )
        self._wait(sent.done, "an answer to the goal")
        self._handle = sent.result()
        self.accepted = self._handle.accepted
        self._result = self._handle.get_result_async() if self.accepted else None

    def cancel(self):
        """Ask for the end; returns when the server has answered."""
        done = self._handle.cancel_goal_async()
        self._wait(done.done, "an answer to the cancel")
        return done.result()

    def result(self):
        """Final status and result."""
        self._wait(self._result.done, "a result")
        answer = self._result.result()
        return answer.status, answer.result
