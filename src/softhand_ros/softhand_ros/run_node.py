"""Start and end of a node's process: signals, exit status, one line for what is wrong."""

from __future__ import annotations

import importlib
import signal
import sys
from collections.abc import Callable
from threading import Event
from typing import Protocol, TypeVar

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from softhand_ros.middleware import set_up_middleware
from softhand_ros.topics import refuse_time_before_zero

ENDING = (signal.SIGINT, signal.SIGTERM)


class Closing(Protocol):
    """A node, or what stands around one."""

    def close(self) -> None:
        """Leave things safe, and destroy the node."""


N = TypeVar("N", bound=Closing)


def run_node(
    name: str,
    make: Callable[[], N],
    serve: Callable[[N, Event], None],
    *,
    usage: str = "",
    args: list[str] | None = None,
    failures: tuple[type[Exception], ...] = (),
) -> int:
    """Run a node until SIGINT or SIGTERM.

    Args:
        name: before what is printed of an error.
        make: makes the node.
        serve: has it work until the event is set.
        usage: what -h and --help print; empty leaves them to others.
        args: command line without the program; None for that of the process.
        failures: what ends the node with status 1.

    Returns:
        Exit status: 0 after a signal, 1 after a failure, 2 for parameters, names or files that
        cannot be used. An error is printed in one line.
    """
    if usage and helped(usage, args):
        return 0
    stop = Event()
    # Event.set from a handler of its own: rclpy's would end the context under the node's feet
    for number in ENDING:
        signal.signal(number, lambda *_: stop.set())
    set_up_middleware()
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    node, status = None, 0
    try:
        node = make()
        if isinstance(node, Node):
            refuse_time_before_zero(node)
        serve(node, stop)
    except (ValueError, OSError, ParameterException) as error:
        status = _fail(name, error, 2)
    except failures as error:
        status = _fail(name, error, 1)
    finally:
        for number in ENDING:
            signal.signal(number, signal.SIG_IGN)
        if node is not None:
            node.close()
        rclpy.try_shutdown()
    return status


def helped(usage: str, args: list[str] | None) -> bool:
    """Whether the command line asks for help, which is printed then."""
    asked = bool({"-h", "--help"} & set(sys.argv[1:] if args is None else args))
    if asked:
        print(usage)
    return asked


def start_node(usage: str, module: str, args: list[str] | None = None) -> int:
    """Print the help if it is asked for, else load the module of a node and run its `main`.

    What a node computes with takes a second to load and more on a busy machine; its help does not
    wait for that.
    """
    return 0 if helped(usage, args) else int(importlib.import_module(module).main(args))


def _fail(name: str, error: Exception, status: int) -> int:
    print(f"{name}: {error}", file=sys.stderr)
    return status
