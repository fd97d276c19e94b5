"""Start and end of a node's process: signals, exit status, errors in one line."""

from __future__ import annotations

import gc
import importlib
import os
import signal
import sys
from collections.abc import Callable
from threading import Event, Thread
from typing import Protocol, TypeVar

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from softhand_ros.middleware import set_up_middleware
from softhand_ros.topics import refuse_time_before_zero

INSISTING = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)  # SIGHUP: the terminal has closed
ENDING = (signal.SIGINT, *INSISTING)
# A stopped driver could not vent. A terminal sends these at Ctrl-Z and to processes in background.
IGNORED = (signal.SIGTSTP, signal.SIGTTIN, signal.SIGTTOU)
STDERR = 2
TERMINATION_LIMIT = 1.7  # wall time from SIGTERM to the end of the process, without closing [s]


class Closing(Protocol):
    """What `run_node` runs: a node, or an object that owns one."""

    def close(self) -> None:
        """Bring the device into a safe state and destroy the node."""


N = TypeVar("N", bound=Closing)


def run_node(
    name: str,
    make: Callable[[], N],
    serve: Callable[[N, Event], None],
    *,
    usage: str = "",
    args: list[str] | None = None,
    failures: tuple[type[Exception], ...] = (),
    closing_time: Callable[[N], float] = lambda node: 0.0,
) -> int:
    """Run a node until SIGINT, SIGTERM, SIGHUP or SIGQUIT.

    The process ends within TERMINATION_LIMIT [s] and `closing_time`, by force if need be, after
    SIGTERM, SIGHUP and SIGQUIT, and after a SIGINT that comes before the node is made. After a
    later SIGINT it takes the time that it needs. SIGHUP is ignored where it was before (`nohup`),
    and so are the signals by which a terminal stops a process.

    Args:
        name: name of the command, printed before an error.
        make: makes and returns the node.
        serve: called with the node and an event; runs the node until the event is set.
        usage: text for -h and --help; empty: these options are not handled here.
        args: command line without the program; None for that of the process.
        failures: exceptions that end the node with status 1.
        closing_time: additional time that closing the node may take [s].

    Returns:
        Exit status: 0 after a signal, 1 after a failure or an end by force, 2 for parameters, names
        or files that cannot be used. An error is printed in one line.
    """
    if usage and helped(usage, args):
        return 0
    ending = Ending(name)
    set_up_middleware()
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    node, status = None, 0
    try:
        node = make()
        if isinstance(node, Node):
            refuse_time_before_zero(node)
        gc.collect()
        gc.freeze()  # what there is now stays: later collections need not look through it
        ending.begin_serving(closing_time(node))
        serve(node, ending.stop)
    except failures as error:
        status = _fail(name, error, 1)
    except (ValueError, OSError, ParameterException) as error:
        status = _fail(name, error, 2)
    finally:
        if node is None:
            gc.collect()  # publishers of what `make` left would go on telling others of a node
        else:
            node.close()
        rclpy.try_shutdown()
        ending.close()
    return status


class Ending:
    """Sets the event `stop` at a signal in ENDING, and ends the process by force if it does not end
    in time.

    A thread reads the signals from a pipe, as Python's handlers wait while the main thread is in a
    long call such as a compilation.

    Args:
        name: name of the command, printed before a message.
    """

    def __init__(self, name: str) -> None:
        self.stop = Event()
        self._name, self._closed = name, Event()
        self._serving, self._limit = False, TERMINATION_LIMIT
        self._signals, self._wakeup = os.pipe()
        os.set_blocking(self._wakeup, False)
        self._wakeup_before = signal.set_wakeup_fd(self._wakeup)
        # rclpy's handlers would end the context under the node's feet
        kept = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
        self._ending = [number for number in ENDING if not (kept and number == signal.SIGHUP)]
        for number in self._ending:
            signal.signal(number, lambda *_: self.stop.set())
        for number in IGNORED:
            signal.signal(number, signal.SIG_IGN)
        self._thread = Thread(target=self._watch, name="ending", daemon=True)
        self._thread.start()

    def begin_serving(self, closing_time: float) -> None:
        """Note that the node has been made; closing it may take this additional time [s]."""
        self._serving, self._limit = True, TERMINATION_LIMIT + closing_time

    def _watch(self) -> None:
        while numbers := os.read(self._signals, 64):
            if not set(self._ending) & set(numbers):
                continue
            self.stop.set()
            if set(INSISTING) & set(numbers) or not self._serving:
                self._closed.wait(self._limit)
                if not self._closed.is_set():
                    self._force()

    def _force(self) -> None:
        status = 0
        if self._serving:
            status = 1
            text = f"{self._name}: not closed {self._limit:g} s after the signal: ended by force\n"
            os.write(STDERR, text.encode())
        os._exit(status)

    def close(self) -> None:
        """Note that the node has been closed: only the interpreter has to end."""
        self._closed.set()
        signal.set_wakeup_fd(self._wakeup_before)
        os.close(self._wakeup)
        self._thread.join()
        os.close(self._signals)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # as usual the second of two
        for number in INSISTING:
            if number in self._ending:
                signal.signal(number, signal.SIG_DFL)  # even that may hang


def helped(usage: str, args: list[str] | None) -> bool:
    """Print the help if the command line asks for it; returns whether it does."""
    asked = bool({"-h", "--help"} & set(sys.argv[1:] if args is None else args))
    if asked:
        print(usage)
    return asked


def start_node(usage: str, module: str, args: list[str] | None = None) -> int:
    """Print the help if it is asked for, else import the module of a node and run its `main`.

    Importing the numerical libraries of a node takes a second or more; its help does not need them.
    """
    return 0 if helped(usage, args) else int(importlib.import_module(module).main(args))


def _fail(name: str, error: Exception, status: int) -> int:
    print(f"{name}: {error}", file=sys.stderr)
    return status
