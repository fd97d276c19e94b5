"""Beside a suite that somebody else has started: nobody commands its hand by mistake."""

import os
import subprocess
import sys

import pytest
from geometry_msgs.msg import PoseStamped
from ros_peer import Peer
from trajectory_msgs.msg import JointTrajectory

from softhand_bringup.processes import domain as domains
from softhand_bringup.processes import suite
from softhand_bringup.processes.domain import DomainTaken, held_domain, is_used
from softhand_bringup.ros.run_domain import refuse_strangers, run_domain, run_enclave
from softhand_ros.client_link import ClientLink

COMMANDS = {
    "demo": ["softhand_bringup.ros.demo"],
    "lab-story": ["softhand_bringup.ros.lab_story"],
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_run_refuses_a_domain_with_nodes_of_others(nodes, peer, domain, guard, tmp_path, name):
    peer.wait_for_driver()
    targets = peer.listen(PoseStamped, "wrist/target_pose")
    commands = peer.listen(JointTrajectory, "pneumaticbox/command")
    peer.wait(peer.phases, "the sequencer")
    told = subprocess.run(
        [sys.executable, "-m", *COMMANDS[name], "--out", str(tmp_path / "out")],
        env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
        preexec_fn=guard.enrol,
        capture_output=True,
        text=True,
        timeout=110,
    )
    assert told.returncode == 2, told.stdout + told.stderr
    last = told.stdout.splitlines()[-1]
    assert last.startswith(f"{name}: ")
    assert f"ROS domain {domain} has nodes that this run did not start (/" in last
    assert "unset ROS_DOMAIN_ID" in last
    assert not list((tmp_path / "out").rglob("log/hand_sim.log"))  # nothing was started
    peer.spin(1.0)
    assert (targets, commands, set(peer.phases())) == ([], [], {"idle"})
    assert {name: process.exit_code for name, process in nodes.items()} == dict.fromkeys(nodes)


def test_a_run_has_a_domain_of_its_own_where_the_user_has_set_none(monkeypatch):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    said = []
    with run_domain(said.append) as first, run_domain(said.append) as second:
        assert first != second
        assert not is_used(first) and not is_used(second)
    assert f"ROS_DOMAIN_ID={first})" in said[0]
    assert f"ROS_DOMAIN_ID={second})" in said[1]


def test_a_domain_in_which_a_node_runs_is_not_chosen(tmp_path, monkeypatch):
    with held_domain() as free:
        monkeypatch.setattr(domains, "DOMAINS", (free, *domains.DOMAINS))
        peer = Peer(free, tmp_path)
    try:
        assert is_used(free)
        with held_domain() as other:  # the lock of the first is free again
            assert other != free
    finally:
        peer.close()


def test_what_is_no_number_is_refused(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "seven")
    expected = pytest.raises(ValueError, match="ROS_DOMAIN_ID: expected a number, got 'seven'")
    with expected, run_domain(print):
        pass


def test_nodes_of_the_run_are_told_from_one_that_comes_later(launcher, domain):
    enclave = run_enclave(domain)
    own = suite.SuiteOptions(enclave=enclave)
    with ClientLink("test", domain, enclave=enclave) as link:

        def publish(kind):
            return bool(link.node.count_publishers(kind))

        launcher.start(suite.driver(own))
        assert link.wait(lambda: publish("pneumaticbox/state"), 60.0)
        refuse_strangers(link)
        launcher.start(suite.sequencer(suite.SuiteOptions()))
        assert link.wait(link.strangers, 60.0)  # later than their topics on a busy machine
        with pytest.raises(DomainTaken, match=r"\(/grasp_sequencer (publishes|offers) /"):
            refuse_strangers(link)
