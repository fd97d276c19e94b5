"""The launcher, tried with small scripts in place of nodes."""

import os
import signal
import subprocess
import sys
import textwrap
import threading

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


def test_what_a_thread_has_started_outlives_it(start):
    thread = threading.Thread(target=start, args=("one", SLEEPER))
    thread.start()
    thread.join()
    assert up(start("two", SLEEPER))
    start.launcher.check()


def test_what_a_process_has_started_ends_with_a_killed_launcher(tmp_path):
    script = f"""
        import subprocess, sys, time
        from pathlib import Path
        from softhand_bringup.processes.launcher import Launcher, NodeCommand
        folder = Path({str(tmp_path)!r})
        environment = {{"PYTHONPATH": str(folder)}}
        print(Launcher(folder, environment).start(NodeCommand("s", "family")).pid, flush=True)
        time.sleep(60)
    """
    family = """
        import subprocess, sys
        deaf = "import signal, time; signal.signal(2, signal.SIG_IGN); time.sleep(60)"
        child = subprocess.Popen([sys.executable, "-c", deaf])
        print(child.pid, flush=True)
        child.wait()
    """
    (tmp_path / "family.py").write_text(textwrap.dedent(family))
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, text=True
    ) as parent:
        child = int(parent.stdout.readline())
        log = tmp_path / "s.log"
        assert wait_until(lambda: log.read_text().strip(), 10.0)
        grandchild = int(log.read_text())
        parent.kill()
    assert wait_until(lambda: not is_alive(child) and not is_alive(grandchild), 15.0)


BRIEF = """
    import subprocess, sys
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    print(child.pid, flush=True)
"""


def test_what_a_process_that_has_ended_left_behind_ends_with_the_launcher(start):
    process = start("brief", BRIEF)
    assert process.wait(10.0) == 0
    child = int(process.last_words())
    assert is_alive(child)
    start.launcher.stop()
    assert wait_until(lambda: not is_alive(child), 10.0)


def test_what_a_process_that_has_ended_left_behind_ends_with_a_killed_launcher(tmp_path):
    (tmp_path / "brief.py").write_text(textwrap.dedent(BRIEF))
    script = f"""
        import time
        from pathlib import Path
        from softhand_bringup.processes.launcher import Launcher, NodeCommand
        folder = Path({str(tmp_path)!r})
        process = Launcher(folder, {{"PYTHONPATH": str(folder)}}).start(NodeCommand("s", "brief"))
        process.wait(60.0)
        print(process.last_words(), flush=True)
        time.sleep(60)
    """
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, text=True
    ) as parent:
        child = int(parent.stdout.readline())
        assert is_alive(child)
        parent.kill()
    assert wait_until(lambda: not is_alive(child), 10.0)


def test_a_process_that_is_just_being_started_ends_with_a_killed_launcher(tmp_path):
    (tmp_path / "late.py").write_text("import time; time.sleep(60)")
    deaf = "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); time.sleep(60)"
    (tmp_path / "deaf.py").write_text(deaf)  # the first is being ended when the second comes
    script = f"""
        import os, threading, time
        from pathlib import Path
        from softhand_bringup.processes.launcher import Launcher, NodeCommand
        folder = Path({str(tmp_path)!r})
        launcher = Launcher(folder, {{"PYTHONPATH": str(folder)}})
        launcher.start(NodeCommand("d", "deaf"))
        time.sleep(2.0)
        enrol, output = launcher._guard.enrol, os.dup(1)
        def slowly():
            os.write(output, b"%d\\n" % os.getpid())
            time.sleep(0.5)
            enrol()
        launcher._guard.enrol = slowly
        launcher.start(NodeCommand("s", "late"))
    """
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, text=True
    ) as parent:
        child = int(parent.stdout.readline())
        parent.kill()
        parent.wait()
        assert is_alive(child)
    assert wait_until(lambda: not is_alive(child), 10.0)


def test_no_process_is_started_that_nobody_would_end(start):
    start.launcher._guard._warden.kill()
    start.launcher._guard._warden.wait()
    with pytest.raises(NodeDied, match="ends nodes after a crash ended with code -9"):
        start("one", SLEEPER)


def test_what_the_user_has_set_stands(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    environment = node_environment(tmp_path, domain=42)
    assert environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
    assert environment["ROS_DOMAIN_ID"] == "42"
