"""Set-up of the middleware: the profile, and shared memory that killed processes left."""

import mmap
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from softhand_bringup.processes.domain import FIRST_PORT, PORTS
from softhand_bringup.processes.suite import node_environment
from softhand_ros import middleware
from softhand_ros.middleware import PROFILE, PROFILE_VARIABLES, set_up_middleware

SWITCH = "RMW_FASTRTPS_USE_QOS_FROM_XML"


@pytest.fixture
def unset(monkeypatch):
    """An environment without profiles, as it was before afterwards."""
    for name in (*PROFILE_VARIABLES, SWITCH):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)


def test_without_a_profile_of_the_users_the_shipped_one_is_taken(unset):
    set_up_middleware()
    assert os.environ[PROFILE_VARIABLES[-1]] == str(PROFILE)
    assert os.environ[SWITCH] == "1"
    ElementTree.parse(PROFILE)


@pytest.mark.parametrize("name", PROFILE_VARIABLES)
def test_a_profile_of_the_users_stands(unset, monkeypatch, name):
    monkeypatch.setenv(name, "mine.xml")
    set_up_middleware()
    assert os.environ[name] == "mine.xml"
    assert SWITCH not in os.environ


START = """
from softhand_ros.middleware import set_up_middleware
set_up_middleware()
import rclpy
rclpy.init()
rclpy.create_node("late").destroy_node()
"""


def test_a_node_starts_where_a_killed_process_left_an_unfinished_port(domain, tmp_path):
    first = FIRST_PORT + PORTS * domain + 11  # unicast of the first participant, RTPS 9.6.1.1
    left = [middleware.SHARED_MEMORY / f"fastrtps_port{first + 2 * k}" for k in range(3)]
    for path in left:
        path.write_bytes((1).to_bytes(4, "little") + bytes(52396))
        _age(path)
    environment = node_environment(tmp_path, domain)
    try:
        subprocess.run([sys.executable, "-c", START], env=environment, timeout=30, check=True)
        assert not any(path.exists() and path.read_bytes()[0] == 1 for path in left)
    finally:
        for path in left:
            path.unlink(missing_ok=True)


WAITING = START.replace("rclpy.create", "node = rclpy.create").replace(
    ".destroy_node()", "; print('ready', flush=True); input()"
)


def test_writers_of_a_killed_readers_port_are_told_and_those_of_a_living_one_are_not(
    domain, tmp_path
):
    environment = node_environment(tmp_path, domain)
    nodes, ports = [], []
    try:
        for _ in range(2):
            pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
            lines = [sys.executable, "-c", WAITING]
            nodes.append(subprocess.Popen(lines, env=environment, **pipes))
            assert nodes[-1].stdout.readline() == b"ready\n"
            ports.append({path: _mapped(path) for path in _read_by(nodes[-1].pid)})
            assert ports[-1]
        nodes[0].kill()
        nodes[0].wait()
        for path in ports[0]:
            _age(path.with_name(f"{path.name}_el"))
        middleware.remove_ports_without_reader()
        assert not any(path.exists() for path in ports[0])
        assert all(path.exists() for path in ports[1])
        assert not any(_is_marked_ok(memory, path) for path, memory in ports[0].items())
        assert all(_is_marked_ok(memory, path) for path, memory in ports[1].items())
    finally:
        for node in nodes:
            node.kill()
            node.communicate()
        middleware.remove_ports_without_reader()


def _age(path, seconds=60.0):
    os.utime(path, (time.time() - seconds, time.time() - seconds))


@pytest.mark.parametrize(
    ("how", "kept"), [("left", False), ("taken again meanwhile", True), ("just made", True)]
)
def test_a_port_whose_number_another_process_just_takes_is_left_alone(
    how, kept, tmp_path, monkeypatch
):
    monkeypatch.setattr(middleware, "SHARED_MEMORY", tmp_path)
    port, lock = tmp_path / "fastrtps_port8011", tmp_path / "fastrtps_port8011_el"
    content = bytes(16) + middleware.NODE_OF_PORT + bytes(16) + (8011).to_bytes(4, "little")
    port.write_bytes(content + bytes(20) + bytes([7]) + bytes(64))
    lock.touch()
    if how != "just made":
        _age(lock)

    def locked(file, operation):
        if how == "taken again meanwhile":  # between opening and locking
            lock.unlink()
            lock.touch()

    monkeypatch.setattr(middleware.fcntl, "flock", locked)
    before = port.read_bytes()
    middleware.remove_ports_without_reader()
    assert port.exists() == lock.exists() == kept
    assert not kept or port.read_bytes() == before


def _read_by(process):
    """Ports that a process has locked."""
    for file in Path(f"/proc/{process}/fd").iterdir():
        path = file.readlink()
        if path.match(middleware.READER_LOCKS):
            yield path.with_name(path.name.removesuffix("_el"))


def _mapped(path):
    """The memory of a port as its writers have it."""
    with path.open("rb") as file:
        return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)


def _is_marked_ok(memory, port):
    """The flag behind number, listeners, two times, length and count of those who wait."""
    number = int(port.name.removeprefix("fastrtps_port"))
    at = memory.find(number.to_bytes(4, "little"))
    return bool(memory[at + 6 * 4] & 1)


def test_what_another_process_may_still_finish_is_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr(middleware, "SHARED_MEMORY", tmp_path)
    monkeypatch.setattr(middleware, "INITIALIZATION_LIMIT", 1.0)
    young, done = tmp_path / "fastrtps_port8001", tmp_path / "fastrtps_port8003"
    lock = tmp_path / "fastrtps_port8001_el"
    lock.touch()
    young.write_bytes(bytes(8))
    done.write_bytes((2).to_bytes(4, "little"))
    begun = time.monotonic()
    middleware.remove_unfinished_segments()
    assert time.monotonic() - begun > 0.8
    assert not young.exists() and done.exists() and lock.exists()
