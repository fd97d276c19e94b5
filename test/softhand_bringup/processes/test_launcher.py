"""The launcher, tried with small scripts in place of nodes."""

import os
import signal
import subprocess
import sys
import textwrap

import pytest

from softhand_bringup.processes.launcher import Launcher, NodeCommand, NodeDied, wait_until
from softhand_bringup.processes.suite import node_environment


@pytest.fixture
def start(tmp_path, monkeypatch):
    """Start a script as if it were a node."""
    environment = node_environment(tmp_path / "log")
    environment["PYTHONPATH"] = str(tmp_path)
    with Launcher(tmp_path / "log", environment) as launcher:

        def start(name, script, **parts):
            (tmp_path / f"{name}_script.py").write_text(textwrap.dedent(script))
            return launcher.start(NodeCommand(name, f"{name}_script", **parts))

        start.launcher = launcher
        yield start


SLEEPER = """
    import signal, sys, time
    signal.signal(signal.SIGINT, lambda *_: sys.exit(0))
    print("up", flush=True)
    time.sleep(60)
"""


def up(process):
    return wait_until(lambda: "up" in process.output(), 10.0)


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_stop_asks_first_and_reports_the_exit_codes(start):
    assert up(start("one", SLEEPER)) and up(start("two", SLEEPER))
    assert start.launcher.stop() == {"one": 0, "two": 0}


def test_a_process_deaf_to_requests_is_ended(start, monkeypatch):
    patience = ((signal.SIGINT, 0.2), (signal.SIGTERM, 0.2), (signal.SIGKILL, 5.0))
    monkeypatch.setattr("softhand_bringup.processes.launcher.STOP_SIGNALS", patience)
    deaf = start(
        "deaf",
        """
        import signal, time
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        print("up", flush=True)
        time.sleep(60)
        """,
    )
    assert up(deaf)
    assert start.launcher.stop() == {"deaf": -signal.SIGKILL}


def test_a_dead_process_is_named_with_its_last_words(start):
    process = start("brief", "print('hand: no such hand'); raise SystemExit(3)")
    assert process.wait(10.0) == 3
    with pytest.raises(NodeDied, match="brief ended with code 3: hand: no such hand"):
        start.launcher.check()


def test_parameters_reach_the_process_as_ros_arguments(start):
    process = start(
        "echo",
        "import sys; print(sys.argv[1:])",
        arguments=["x"],
        parameters={"hand": "rbo_hand_2", "gui": False, "object_offset": [0.01, 0.0]},
        remappings={"a": "b"},
    )
    process.wait(10.0)
    assert process.last_words() == str(
        ["x", "--ros-args", "-p", 'hand:="rbo_hand_2"', "-p", "gui:=false"]
        + ["-p", "object_offset:=[0.01, 0.0]", "-r", "a:=b"]
    )


def test_a_second_process_of_the_same_name_is_refused(start):
    assert up(start("one", SLEEPER))
    with pytest.raises(ValueError, match="not running, got one"):
        start("one", SLEEPER)


def test_a_killed_launcher_leaves_no_orphans(tmp_path):
    (tmp_path / "sleeper.py").write_text(textwrap.dedent(SLEEPER))
    script = f"""
        import time
        from pathlib import Path
        from softhand_bringup.processes.suite import node_environment
        from softhand_bringup.processes.launcher import Launcher, NodeCommand
        folder = Path({str(tmp_path)!r})
        environment = node_environment(folder) | {{"PYTHONPATH": str(folder)}}
        process = Launcher(folder, environment).start(NodeCommand("s", "sleeper"))
        while "up" not in process.output():
            time.sleep(0.02)
        print(process.pid, flush=True)
        time.sleep(60)
    """
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, text=True
    ) as parent:
        child = int(parent.stdout.readline())
        assert is_alive(child)
        parent.kill()
    assert wait_until(lambda: not is_alive(child), 5.0)


def test_what_the_user_has_set_stands(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    environment = node_environment(tmp_path, domain=42)
    assert environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
    assert environment["ROS_DOMAIN_ID"] == "42"
