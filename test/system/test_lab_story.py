"""The lab's whole story over ROS, on plans as short as it allows: real processes, real bags."""

import json
import os
import signal
import subprocess
import sys
from types import SimpleNamespace

import pytest
from leftover import nodes_logging_to

from softhand_bringup.bags.reading import Bag
from softhand_bringup.launcher import wait_until

LIMIT = 240.0  # [s] of wall time for all of it, on a machine that does other things too
SHORT = """
import sys
from pathlib import Path
from softhand_bringup.lab_story.measuring import Measurement, Plan
from softhand_bringup.lab_story.story import Story

stairs = Measurement("stairs", (10e3, 20e3, 30e3, 15e3, 0.0), 0.8)
steps = Measurement("steps", (15e3, 5e3, 29e3, 22e3, 0.0), 0.8)
Story(
    Path(sys.argv[1]), "gent_stiffening", 3, lambda line: print(line, flush=True),
    plan=Plan((stairs, steps), repeats=2, rest=0.6),
    check=Plan((steps,), repeats=1, rest=0.6),
    report=False,
).run()
"""


@pytest.fixture(scope="module")
def story(domain, tmp_path_factory):
    """The story of a finger that stiffens, told once."""
    folder = tmp_path_factory.mktemp("story")
    told = subprocess.run(
        [sys.executable, "-c", SHORT, str(folder)],
        env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
        capture_output=True,
        text=True,
        timeout=LIMIT,
    )
    left = nodes_logging_to(folder)
    assert told.returncode == 0, told.stdout + told.stderr
    return SimpleNamespace(
        folder=folder,
        output=told.stdout,
        left=left,
        result=json.loads((folder / "result.json").read_text()),
    )


def test_the_story_leaves_no_process_behind(story):
    assert story.left == []


def test_what_the_simulator_hid_is_found_in_the_bags(story):
    found = story.result["diagnosis"]
    assert found["verdict"] == "effects_missing"
    named = {effect["name"] for effect in found["effects"]}
    assert "gent_stiffening" in named.union(*found["tied"])
    assert len(found["effects"]) == 1
    assert found["rmse_after"] < 0.3 * found["rmse_before"]


def test_the_monitor_sees_the_error_fall_with_the_new_model(story):
    assert story.result["live_after"] < 0.3 * story.result["live_before"]
    # about as near as the lab: the noise of the pressure is the same
    assert story.result["live_after"] < 1.6 * story.result["diagnosis"]["rmse_after"]


def test_the_monitors_residual_is_what_it_was_given_less_what_it_predicts(story):
    for session in ("measured", "mended"):
        with Bag(story.folder / session / "bag") as bag:
            residual, measured = bag.joints("/model/residual"), bag.joints("/hand/tip_angles")
        angle = dict(zip(measured.time, measured.position[:, 0], strict=True))
        assert len(residual.time) > 0.9 * len(measured.time)
        assert all(time in angle for time in residual.time)
        assert residual.names == measured.names == ("finger",)


def test_the_story_names_its_commands_and_opens_the_seal_at_its_end(story):
    lines = story.output.splitlines()
    assert any(line.startswith("$ model-lab diagnose") for line in lines)
    assert any(line.startswith("$ model-lab add") for line in lines)
    assert lines[-1] == "What was hidden: gent_stiffening, jm = 4."
    assert "times smaller" in lines[-2]


def test_ctrl_c_ends_the_story_and_its_nodes(domain, tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "softhand_bringup.lab_story", "--out", str(tmp_path)],
        env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert "1. " in process.stdout.readline()
    assert wait_until(lambda: len(nodes_logging_to(tmp_path)) == 4, 20.0)
    os.killpg(process.pid, signal.SIGINT)
    rest = process.stdout.read()
    assert process.wait(30.0) == 130
    assert "interrupted" in rest
    assert wait_until(lambda: not nodes_logging_to(tmp_path), 5.0)
