"""A push on the simulated finger with real nodes: what mass and pressure control make of it."""

import json
import subprocess
import sys

import pytest

from softhand_bringup.processes.suite import node_environment
from thesis.equilibrium_point.equilibrium_point import enclosed_changes, looks
from thesis.equilibrium_point.recording import Push, read_recordings

LIMIT = 240.0  # [s] of wall time for all of it, on a machine that does other things too
PUSHES = """
import json, sys
from dataclasses import asdict
from pathlib import Path
from threading import Event
from thesis.equilibrium_point.session import Session

folder = Path(sys.argv[1])
pushes = Session(folder, 1, print, ("mass", "pressure"), Event()).run()
(folder / "pushes.json").write_text(json.dumps([asdict(push) for push in pushes]))
"""


@pytest.fixture(scope="module")
def courses(tmp_path_factory, domain):
    """Both pushes, played once by a process of its own."""
    folder = tmp_path_factory.mktemp("push")
    line = [sys.executable, "-c", PUSHES, str(folder)]
    subprocess.run(line, env=node_environment(folder / "log", domain), timeout=LIMIT, check=True)
    pushes = [Push(**entry) for entry in json.loads((folder / "pushes.json").read_text())]
    return {course.push.mode: course for course in read_recordings(folder / "bag", pushes)}


def test_a_push_under_mass_control_moves_along_the_line_of_equal_air_mass(courses):
    seen = courses["mass"]
    pressure, volume = looks(seen, seen.pressure), looks(seen, seen.volume)
    assert len(seen.openings) == 0
    assert pressure[1] > pressure[0] + 4e3
    assert volume[1] < 0.97 * volume[0]
    # p_abs V by measured pressure and geometry, of some 30 mg; the sensor's gain is 0.4 % off
    assert abs(enclosed_changes(seen)[0]) < 0.15e-6
    assert volume[2] == pytest.approx(volume[0], rel=2e-3)


def test_a_push_under_pressure_control_lets_air_out_and_in_again(courses):
    seen = courses["pressure"]
    change, left = enclosed_changes(seen)
    assert len(seen.openings) >= 2
    assert change < -1e-6
    assert abs(left) < 0.6 * abs(change)
