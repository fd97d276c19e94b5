"""Drive a box from a script: air masses, a pressure, a valve pulse at a moment set beforehand.

`python examples/drive_the_box.py` starts the driver on its pretended bench in a process of its own
and prints what the channels do.
"""

import os
import tempfile
from pathlib import Path

import pytest

from pneumaticbox_driver.ros.client import PneumaticboxClient
from softhand_bringup.processes.domain import held_domain
from softhand_bringup.processes.launcher import Launcher, NodeCommand
from softhand_bringup.processes.suite import node_environment

pytestmark = pytest.mark.system

BOTTLES = {  # two bottles of 0.1 L
    "backend": "embedded",
    "channels": ["a", "b"],
    "rest_volumes": [1e-4, 1e-4],
    "pressure_limits": [1.5e5, 1.5e5],
    "embedded_rate": 200.0,  # [Hz]; 500 where nothing else keeps the machine busy
}
MASS = 4e-5  # [kg]
PRESSURE = 20e3  # gauge [Pa]


def drive(domain):
    """Masses of channel a [kg], its last pressure [Pa], and how late its valve let air in [s]."""
    folder = Path(tempfile.mkdtemp())
    environment = node_environment(folder, domain)
    os.environ.update(environment)  # of this process, whose client looks for the driver
    driver = NodeCommand("driver", "pneumaticbox_driver.ros.node", BOTTLES)
    with Launcher(folder, environment) as launcher:
        launcher.start(driver)
        with PneumaticboxClient(domain=domain) as box:
            return run(box)


def run(box):
    """Run the box; returns as `drive`."""
    box.run({"a": [0.5 * MASS, MASS], "b": [0.0, 0.0]}, times=[1.0, 2.0])
    masses = [state.mass["a"] for state in box.monitor(3.0)]

    box.configure(control_mode={"a": "pressure"})
    box.run({"a": PRESSURE})
    pressures = [state.pressure["a"] for state in box.monitor(2.0)]

    box.configure(control_mode="time")
    start = box.now + 0.5
    before = box.state.pressure["b"]
    box.schedule({"b": [(0.0, 1), (0.4, 0)]}, start=start)
    risen = [s.time for s in box.monitor(1.5) if s.pressure["b"] > before + 3e3]
    box.stop()
    return masses, pressures[-1], risen[0] - start


def test_a_script_can_drive_the_box():
    with held_domain() as domain:
        masses, pressure, delay = drive(domain)
    assert masses[-1] == pytest.approx(MASS, abs=2.5e-6)
    assert pressure == pytest.approx(PRESSURE, abs=4e3)
    assert 0.02 < delay < 0.2  # the valve's delay of 20-40 ms, and 3 kPa through a 0.2 mm choke


if __name__ == "__main__":
    with held_domain() as free:
        masses, pressure, delay = drive(free)
    print(f"a holds {1e6 * masses[-1]:.1f} mg of air after 3 s, {1e6 * MASS:.0f} mg were asked for")
    print(f"then {1e-3 * pressure:.1f} kPa, of {1e-3 * PRESSURE:.0f} kPa asked for")
    print(f"b begins to fill {1e3 * delay:.0f} ms after the moment that was set for its valve")
