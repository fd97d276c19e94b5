"""Backends are loaded only when they are asked for."""

import subprocess
import sys


def test_the_node_loads_neither_plant_nor_wiring_before_a_backend_is_chosen():
    program = (
        "import sys, pneumaticbox_driver.ros.node; print([name for name in sys.modules if "
        "name.startswith('softhand_model.pneumatics') or '.backends.hardware' in name "
        "or '.backends.embedded' in name or name == 'gpiod'])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr
