"""Launcher: starts nodes as processes, watches them, and stops all of them in order."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from softhand_bringup.processes.warden import end_group

ParameterValue = bool | int | float | str | Sequence[bool | int | float | str]

WARDEN = Path(__file__).with_name("warden.py")

# signals with the time [s] after which the next one is sent
STOP_SIGNALS = ((signal.SIGINT, 5.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, 2.0))


class NodeDied(RuntimeError):
    """A process ended unexpectedly; the message has its name, exit code and last output."""


@dataclass(frozen=True)
class NodeCommand:
    """The command of a node.

    Args:
        name: name of the process in messages, and of its log file.
        module: run as `python -m <module>`.
        parameters: ROS parameters, passed as `-p name:=value`.
        arguments: further command line arguments, before the ROS arguments.
        remappings: ROS names, passed as `-r from:=to`.
        enclave: ROS enclave of the node; empty: none.
    """

    name: str
    module: str
    parameters: Mapping[str, ParameterValue] = field(default_factory=dict)
    arguments: Sequence[str] = ()
    remappings: Mapping[str, str] = field(default_factory=dict)
    enclave: str = ""

    def command_line(self) -> list[str]:
        """The command line of the process.

        >>> NodeCommand("sim", "pneuflex_sim.ros.node", {"step": 0.002}).command_line()[1:]
        ['-m', 'pneuflex_sim.ros.node', '--ros-args', '-p', 'step:=0.002']
        """
        line = [sys.executable, "-m", self.module, *self.arguments]
        if self.parameters or self.remappings or self.enclave:
            line.append("--ros-args")
        for name, value in self.parameters.items():
            line += ["-p", f"{name}:={json.dumps(value)}"]
        for source, target in self.remappings.items():
            line += ["-r", f"{source}:={target}"]
        if self.enclave:
            line += ["--enclave", self.enclave]
        return line


class NodeProcess:
    """One running node; its output goes to a log file.

    Args:
        command: command of the node.
        environment: variables of the process.
        log: file for its output.
        guard: guard that ends the node when this process has died.
    """

    def __init__(
        self, command: NodeCommand, environment: Mapping[str, str], log: Path, guard: Guard
    ) -> None:
        self.name = command.name
        self.log = log
        with log.open("wb") as output:
            self._process = subprocess.Popen(
                command.command_line(),
                env=dict(environment),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                # a session of its own: Ctrl-C reaches only the launcher, which stops in order
                start_new_session=True,
                preexec_fn=guard.enrol,
            )

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """Exit code; None while it runs, negative after a signal."""
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
        """The output so far."""
        return self.log.read_text(errors="replace")

    def last_words(self) -> str:
        """The last line of its output."""
        lines = self.output().strip().splitlines()
        return lines[-1].strip() if lines else "no output"


class Launcher:
    """The processes of one run; a context manager that stops them at its end.

    Args:
        log_folder: folder for `<name>.log` of every process; created if missing.
        environment: variables of the processes, see `suite.node_environment`.
    """

    process = NodeProcess  # what `start` makes

    def __init__(self, log_folder: Path, environment: Mapping[str, str]) -> None:
        log_folder.mkdir(parents=True, exist_ok=True)
        self._log_folder = log_folder
        self._environment = environment
        self._processes: list[NodeProcess] = []
        self._guard = Guard()

    def start(self, command: NodeCommand) -> NodeProcess:
        """Start one process.

        Raises:
            ValueError: a process of that name is running already.
            NodeDied: the guard has ended, which would end the node if this process died.
        """
        if any(p.name == command.name and p.exit_code is None for p in self._processes):
            raise ValueError(f"name: expected a process that is not running, got {command.name}")
        self._guard.check()
        log = self._log_folder / f"{command.name}.log"
        process = self.process(command, self._environment, log, self._guard)
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
        """Stop all processes and the processes that they have started, the last one first; returns
        exit codes by name.
        """
        for process in reversed(self._processes):
            if process.exit_code is None:
                stop_process(process)
            end_group(process.pid)
        return {process.name: process.exit_code for process in self._processes}

    def __enter__(self) -> Launcher:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        self._guard.close()


class Guard:
    """Ends processes when this one has died, even by SIGKILL, by means of a process that runs the
    module `warden`.

    A signal at the death of the parent (prctl) would already be sent when the thread that started
    the process ends, could be missed while the process starts, and cannot be followed by other
    signals.
    """

    def __init__(self) -> None:
        reading, writing = os.pipe()
        self._warden = subprocess.Popen(
            [sys.executable, "-I", "-S", str(WARDEN), str(os.getpid())],
            stdin=reading,
            start_new_session=True,  # signals to the launcher's group do not reach it
        )
        os.close(reading)
        self._ids = writing

    def check(self) -> None:
        """Raise NodeDied when the warden has ended."""
        if (code := self._warden.poll()) is not None:
            raise NodeDied(f"the process that ends nodes after a crash ended with code {code}")

    def enrol(self) -> None:
        """Register the calling process; runs in the child between fork and exec, so that no process
        is missed.

        Also restores signals: a script that runs `make demo &` passes on an ignored SIGINT.
        """
        os.write(self._ids, b"%d\n" % os.getpid())
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)

    def close(self) -> None:
        """End the warden, which first ends processes that still run."""
        os.close(self._ids)
        self._warden.wait()


def stop_process(process: NodeProcess) -> int | None:
    """Stop a process by SIGINT, then SIGTERM, then SIGKILL; returns its exit code."""
    for number, patience in STOP_SIGNALS:
        process.send(number)
        if process.wait(patience) is not None:
            break
    return process.exit_code


def wait_until(condition: Callable[[], object], limit: float, period: float = 0.02) -> bool:
    """Whether `condition()` became true within `limit` [s]; it is checked every `period` [s]."""
    end = time.monotonic() + limit
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(period)
    return True
