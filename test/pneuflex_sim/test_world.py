"""The engine that the simulator runs on."""

import subprocess
import sys


def test_the_engine_is_loaded_without_a_word():
    code = "import pneuflex_sim.world; print('loaded', file=__import__('sys').stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "loaded\n")
