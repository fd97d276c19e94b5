"""Nodes that tests start are forked from a process that has imported them: Python needs 1.5 to 2 s
of processor time to import a node, and a run starts hundreds.

A node's modules, environment, output and signals are as from `python -m module`, by which it is
started where a test changes the environment otherwise. Tests of how a process begins or ends ask
for the fixture `cold_nodes`.
"""

import atexit
import ctypes
import importlib
import json
import os
import runpy
import socket
import subprocess
import sys
import time
import traceback
from pathlib import Path

from softhand_bringup.processes import launcher

MODULES = {
    "faulty_plant_node",
    "grasp_strategies.ros.node",
    "mock_bench",
    "model_lab.ros.monitor",
    "pneumaticbox_driver.ros.node",
    "pneuflex_sim.ros.node",
    "softhand_bringup.ros.hand_with_box.node",
    "softhand_bringup.ros.recorder",
}
# Variables that act when a node is made; others may act when its modules are imported.
CHANGED_LATE = {
    "PYTEST_CURRENT_TEST",
    "PYTHONUNBUFFERED",
    "ROS_AUTOMATIC_DISCOVERY_RANGE",
    "ROS_DOMAIN_ID",
    "ROS_LOG_DIR",
}
SUPPORT = Path(__file__).parent
ADOPTION = 36  # of prctl(2): a process whose parent has ended becomes a child of this one


class ForkedNode:
    """A child that another process has forked, as `subprocess.Popen` has it."""

    def __init__(self, pid):
        self.pid, self._code = pid, None

    def poll(self):
        if self._code is None:
            ended, status = os.waitpid(self.pid, os.WNOHANG)
            self._code = os.waitstatus_to_exitcode(status) if ended else None
        return self._code

    def wait(self, limit):
        end = time.monotonic() + limit
        while self.poll() is None:
            if time.monotonic() > end:
                raise subprocess.TimeoutExpired(str(self.pid), limit)
            time.sleep(0.005)
        return self._code

    def send_signal(self, number):
        if self.poll() is None:
            os.kill(self.pid, number)


class Forker:
    """The process that nodes are forked from; it ends with this one."""

    def __init__(self):
        self._link, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        search = os.pathsep.join(filter(None, [str(SUPPORT), os.environ.get("PYTHONPATH")]))
        self.environment = os.environ | {"PYTHONPATH": search, "PYTHONUNBUFFERED": "1"}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "warm_nodes", str(theirs.fileno())],
            env=self.environment,
            pass_fds=[theirs.fileno()],
            start_new_session=True,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
        )
        theirs.close()

    def fork(self, module, arguments, variables, output, guard):
        request = json.dumps([module, arguments, variables]).encode()
        prctl = ctypes.CDLL(None).prctl
        prctl(ADOPTION, 1)
        try:
            socket.send_fds(self._link, [request], [output.fileno(), guard._ids])
            return ForkedNode(int(self._link.recv(32)))
        finally:
            prctl(ADOPTION, 0)

    def close(self):
        self._link.close()
        self._process.wait()


class WarmNode(launcher.NodeProcess):
    """A node that is forked where its environment allows it."""

    forker = None

    def __init__(self, command, environment, log, guard):
        cls = type(self)
        cls.forker = cls.forker or Forker()
        ours = {"PYTHONPATH": None} | cls.forker.environment
        changed = {name for name in ours | environment if ours.get(name) != environment.get(name)}
        if environment.get("PYTHONPATH") == os.environ.get("PYTHONPATH"):
            changed -= {"PYTHONPATH"}
        if command.module not in MODULES or changed - CHANGED_LATE:
            super().__init__(command, environment, log, guard)
            return
        self.name, self.log = command.name, log
        variables = {name: environment[name] for name in changed & environment.keys()}
        arguments = command.command_line()[3:]  # behind `python -m module`
        with log.open("wb") as output:
            self._process = cls.forker.fork(command.module, arguments, variables, output, guard)

    @classmethod
    def close(cls):
        if cls.forker:
            cls.forker.close()
        cls.forker = None


def serve(link):
    """Fork a node for each request; returns in the node, with its module."""
    while True:
        request, handles, _, _ = socket.recv_fds(link, 1 << 18, 2)
        if not request:  # nobody is at the other end
            sys.exit()
        module, arguments, variables = json.loads(request)
        output, guard = handles
        importlib.import_module(module)
        reading, writing = os.pipe()
        if between := os.fork():  # by its end the node becomes a child of who has asked
            os.waitpid(between, 0)
            link.send(os.read(reading, 32))
            for descriptor in (reading, writing, output, guard):
                os.close(descriptor)
            continue
        if node := os.fork():
            os.write(writing, b"%d" % node)
            os._exit(0)
        os.setsid()
        os.write(guard, b"%d\n" % os.getpid())
        os.dup2(output, 1)
        os.dup2(output, 2)
        for descriptor in (reading, writing, output, guard):
            os.close(descriptor)
        link.close()
        os.environ.update(variables)
        sys.argv[1:] = arguments
        del sys.modules[module]
        return module


def run(module):
    """Run a module as `python -m` does and end without taking the interpreter down: objects that
    this process has made before the fork are not the node's.
    """
    status = 1
    try:
        runpy._run_module_as_main(module)
        status = 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
    finally:
        if unexpected := sys.exception():
            traceback.print_exception(unexpected)
        atexit._run_exitfuncs()
        os._exit(status)


if __name__ == "__main__":
    run(serve(socket.socket(fileno=int(sys.argv[1]))))
