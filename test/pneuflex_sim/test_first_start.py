"""The simulator's first start on a machine, when nothing has been compiled."""

import subprocess
import sys

from ros_domain import held_domain

from softhand_bringup.processes.suite import node_environment

SCRIPT = """
import time
import numpy as np
import rclpy
from pneuflex_sim.ros.node import HandSim
rclpy.init()
simulation = HandSim().simulation
begin = time.process_time()
simulation.read_sensors()
simulation.step(np.ones(4))
print("first step:", time.process_time() - begin, flush=True)
rclpy.shutdown()
"""


def test_a_first_start_compiles_before_the_first_sample(tmp_path):
    """A pause of seconds between two samples looks like a dead simulator, and the driver vents."""
    empty = tmp_path / "empty"
    with held_domain() as domain:
        environment = node_environment(tmp_path, domain) | {"NUMBA_CACHE_DIR": str(empty)}
        command = [sys.executable, "-c", SCRIPT]
        told = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=100)
    assert list(empty.rglob("*.nbi")), "nothing had to be compiled"
    assert "compiling the numerical kernels" in told.stderr
    assert float(told.stdout.split("first step:")[1].split()[0]) < 0.2


def test_the_engine_is_loaded_without_a_word():
    code = "import pneuflex_sim.world; print('loaded', file=__import__('sys').stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "loaded\n")
