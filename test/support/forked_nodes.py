"""Nodes as processes forked from one that has loaded Python, what nodes compute with, and compiled
kernels, but nothing of ROS. That saves much of the processor time of a start.

They are like others: each is of a session of its own, with its own environment variables, output,
and ROS. Tests of how a node starts and ends take the suite's `Launcher`, for whole programs.
"""

import atexit
import contextlib
import functools
import gc
import importlib
import json
import os
import select
import signal
import socket
import struct
import subprocess
import sys
from pathlib import Path

from softhand_bringup.processes.launcher import Launcher, NodeProcess

NODES = (
    "pneuflex_sim.ros.node",
    "pneumaticbox_driver.ros.node",
    "grasp_strategies.ros.node",
    "model_lab.ros.monitor",
    "softhand_bringup.ros.recorder",
    "mock_bench",
    "faulty_plant_node",
)
LOADED = (
    "grasp_strategies.sequencer",
    "model_lab.live.watch",
    "softhand_bringup.bags.writing",
)
READ_AT_START = ("PYTHON", "NUMBA", "LD_")  # environment variables; a fork takes these two as well:
TAKEN = ("PYTHONPATH", "PYTHONUNBUFFERED")
NUMBER = struct.Struct("i")


class ForkedProcess(NodeProcess):
    """A node that is forked; a program, where a fork would not be the same."""

    def __init__(self, command, environment, log, guard):
        if command.module in NODES and _at_start(environment) == _at_start(os.environ):
            self.name, self.log = command.name, log
            self._process = _Fork(command.command_line()[2:], dict(environment), log, guard)
        else:
            super().__init__(command, environment, log, guard)


class ForkingLauncher(Launcher):
    """A launcher whose nodes are forked."""

    process = ForkedProcess


def _at_start(environment):
    names = (name for name in environment if name.startswith(READ_AT_START) and name not in TAKEN)
    return {name: environment[name] for name in names}


class _Fork:
    """What `NodeProcess` asks of a process, of one that is not this one's child."""

    returncode = None

    def __init__(self, line, environment, log, guard):
        self._told, tell = os.pipe()
        request = json.dumps([os.getcwd(), line, environment]).encode()
        with log.open("wb") as output:
            socket.send_fds(_server(), [request], [output.fileno(), guard._ids, tell])
        os.close(tell)
        self.pid = self._next()

    def poll(self):
        if self.returncode is None and select.select([self._told], [], [], 0.0)[0]:
            self.returncode = self._next()
            os.close(self._told)
        return self.returncode

    def wait(self, timeout=None):
        if self.returncode is None:
            select.select([self._told], [], [], timeout)
        if self.poll() is None:
            raise subprocess.TimeoutExpired("node", timeout)
        return self.returncode

    def send_signal(self, number):
        os.kill(self.pid, number)

    def _next(self):
        return NUMBER.unpack(os.read(self._told, NUMBER.size))[0]


@functools.cache
def _server():
    """A connection to the process that forks; it ends when this one does."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    line = [sys.executable, __file__, str(theirs.fileno())]
    with theirs:
        process = subprocess.Popen(line, pass_fds=[theirs.fileno()], start_new_session=True)
    atexit.register(lambda: (ours.close(), process.wait()))
    return ours


def _load():
    """Import what nodes compute with, and call its kernels. Nothing of ROS: its tracing begins a
    thread as it is loaded, which a fork would not have.
    """
    sys.path.insert(0, str(Path(__file__).parents[2]))
    for module in LOADED:
        importlib.import_module(module)
    importlib.import_module("scripts.precompile").compile_simulator()
    if "rclpy" in sys.modules:
        raise RuntimeError(f"expected modules without ROS, got rclpy by one of {LOADED}")
    gc.collect()
    gc.freeze()


def _serve(connection):
    """Answer requests for nodes, each by a process that waits for the node and tells how it ended.

    Returns what was asked for, in the node.
    """
    while True:
        content, files, *_ = socket.recv_fds(connection, 1 << 20, 3)
        with contextlib.suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        if not content:
            sys.exit()
        if os.fork() == 0:
            connection.close()
            output, guard, tell = files
            node = os.fork()
            if node == 0:
                os.close(tell)
                return json.loads(content), output, guard
            os.write(tell, NUMBER.pack(node))
            _, status = os.waitpid(node, 0)
            os.write(tell, NUMBER.pack(os.waitstatus_to_exitcode(status)))
            os._exit(0)
        for file in files:
            os.close(file)


def _become(request, output, guard):
    """Make of this process the node that was asked for; its module."""
    os.setsid()
    os.write(guard, b"%d\n" % os.getpid())
    null = os.open(os.devnull, os.O_RDONLY)
    for source, target in ((null, 0), (output, 1), (output, 2)):
        os.dup2(source, target)
    for file in (null, output, guard):
        os.close(file)
    folder, (module, *arguments), environment = request
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = [module, *arguments]
    sys.path[:2] = [folder, *filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))]
    return importlib.import_module(module)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    _load()
    asked = _serve(socket.socket(fileno=int(sys.argv[1])))
    sys.exit(_become(*asked).main())
