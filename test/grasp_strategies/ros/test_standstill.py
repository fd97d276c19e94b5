"""A sequencer's process that a signal stops notices it itself."""

import os
import signal
import subprocess
import sys
import time

import pytest
from ros_domain import held_domain

from softhand_bringup.processes.suite import node_environment

pytestmark = pytest.mark.system

WAITS = """
import rclpy
from rclpy.parameter import Parameter
from grasp_strategies.ros import scene_clock
from grasp_strategies.scene import SceneError

scene_clock.STANDSTILL_TIMEOUT = 0.5
rclpy.init()
node = rclpy.create_node("waits", parameter_overrides=[Parameter("use_sim_time", value=True)])
clock = scene_clock.SceneClock(node)
clock.watch()
for _ in range(20):
    clock.wait(0.1)
clock.refuse_standstill()  # waits as long as they were asked for are none
print("waits", flush=True)
try:
    while True:  # at the signal it may wait or not
        clock.wait(0.1)
        clock.refuse_standstill()
except SceneError as error:
    print(error, flush=True)
"""


def test_a_process_that_was_stopped_says_so_itself(tmp_path):
    with held_domain() as domain:
        environment = node_environment(tmp_path / "log", domain)
        command = [sys.executable, "-c", WAITS]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as child:
            try:
                assert child.stdout.readline() == "waits\n"
                os.kill(child.pid, signal.SIGSTOP)
                time.sleep(2.0)
                os.kill(child.pid, signal.SIGCONT)
                assert "this sequencer itself stood still for" in child.stdout.readline()
            finally:
                child.kill()
