"""Launcher: starts nodes as processes, watches them, stops them in order, leaves none behind."""

from __future__ import annotations

import ctypes
import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

ParameterValue = bool | int | float | str | Sequence[bool | int | float | str]

_PR_SET_PDEATHSIG = 1  # prctl(2)
_LIBC = ctypes.CDLL(None)

# Each is sent once and given so long [s] before the next, harsher one.
STOP_SIGNALS = ((signal.SIGINT, 5.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, 2.0))


class NodeDied(RuntimeError):
    """A process ended that should be running; the message says which, how, and its last words."""


@dataclass(frozen=True)
class NodeCommand:
    """What to start.

    Args:
        name: of the process in messages and of its log file.
        module: started as `python -m <module>`.
        parameters: ROS parameters, passed as `-p name:=value`.
        arguments: further command line arguments, in front of the ROS arguments.
        remappings: ROS names, passed as `-r from:=to`.
    """

    name: str
    module: str
    parameters: Mapping[str, ParameterValue] = field(default_factory=dict)
    arguments: Sequence[str] = ()
    remappings: Mapping[str, str] = field(default_factory=dict)

    def command_line(self) -> list[str]:
        """The process's arguments.

        >>> NodeCommand("sim", "pneuflex_sim.ros.node", {"step": 0.002}).command_line()[1:]
        ['-m', 'pneuflex_sim.ros.node', '--ros-args', '-p', 'step:=0.002']
        """
        line = [sys.executable, "-m", self.module, *self.arguments]
        if self.parameters or self.remappings:
            line.append("--ros-args")
        for name, value in self.parameters.items():
            line += ["-p", f"{name}:={json.dumps(value)}"]
        for source, target in self.remappings.items():
            line += ["-r", f"{source}:={target}"]
        return line


class NodeProcess:
    """One running node; its output goes to a log file."""

    def __init__(self, command: NodeCommand, environment: Mapping[str, str], log: Path) -> None:
        self.name = command.name
        self.log = log
        with log.open("wb") as output:
            self._process = subprocess.Popen(
                command.command_line(),
                env=dict(environment),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                # a session of its own: Ctrl-C reaches the launcher alone, which stops in order
                start_new_session=True,
                preexec_fn=_die_with_parent,
            )

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """None while it runs; negative: ended by that signal."""
        return self._process.poll()

    def send(self, number: signal.Signals) -> None:
        """Send a signal, if the process still runs."""
        if self.exit_code is None:
            self._process.send_signal(number)

    def wait(self, limit: float) -> int | None:
        """Exit code, or None if it still runs after `limit` [s]."""
        try:
            return self._process.wait(limit)
        except subprocess.TimeoutExpired:
            return None

    def output(self) -> str:
        """What it has printed so far."""
        return self.log.read_text(errors="replace")

    def last_words(self) -> str:
        """The last line it printed."""
        lines = self.output().strip().splitlines()
        return lines[-1].strip() if lines else "no output"


class Launcher:
    """The processes of one run; a context manager that stops them at its end.

    Args:
        log_folder: gets `<name>.log` of every process; made if missing.
        environment: of the processes, see `environment.node_environment`.
    """

    def __init__(self, log_folder: Path, environment: Mapping[str, str]) -> None:
        log_folder.mkdir(parents=True, exist_ok=True)
        self._log_folder = log_folder
        self._environment = environment
        self._processes: list[NodeProcess] = []

    def start(self, command: NodeCommand) -> NodeProcess:
        """Start one process.

        Raises:
            ValueError: a process of that name has been started already and runs.
        """
        if any(p.name == command.name and p.exit_code is None for p in self._processes):
            raise ValueError(f"name: expected one that is not running, got {command.name}")
        process = NodeProcess(command, self._environment, self._log_folder / f"{command.name}.log")
        self._processes.append(process)
        return process

    def check(self) -> None:
        """Raise NodeDied if one of the processes has ended."""
        for process in self._processes:
            if process.exit_code is not None:
                raise NodeDied(
                    f"{process.name} ended with code {process.exit_code}: {process.last_words()} "
                    f"(log: {process.log})"
                )

    def stop(self) -> dict[str, int | None]:
        """Stop all, the last started first; exit codes by name."""
        running = [p for p in reversed(self._processes) if p.exit_code is None]
        for process in running:
            stop_process(process)
        return {process.name: process.exit_code for process in self._processes}

    def __enter__(self) -> Launcher:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def stop_process(process: NodeProcess) -> int | None:
    """Ask with SIGINT, insist with SIGTERM, end with SIGKILL; the exit code."""
    for number, patience in STOP_SIGNALS:
        process.send(number)
        if process.wait(patience) is not None:
            break
    return process.exit_code


def wait_until(condition: Callable[[], object], limit: float, period: float = 0.02) -> bool:
    """Whether `condition()` became true within `limit` [s]; looked at every `period` [s]."""
    end = time.monotonic() + limit
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(period)
    return True


def _die_with_parent() -> None:
    # runs in the child between fork and exec: also a killed launcher leaves no orphans
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGINT)
    # `make demo &` in a script hands down an ignored SIGINT, which exec would keep
    signal.signal(signal.SIGINT, signal.SIG_DFL)
