"""A node that refuses to start, run in the test's own process: Python is not started for each."""

import importlib
import signal

from softhand_ros.run_node import ENDING


def refusal(command, capfd):
    """The one line that a node prints as it refuses what a `NodeCommand` gives it."""
    main = importlib.import_module(command.module).main
    handlers = {number: signal.getsignal(number) for number in ENDING}
    capfd.readouterr()
    try:
        status = main(command.command_line()[3:])  # behind `python -m module`
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    printed = "".join(capfd.readouterr())
    assert status == 2, printed
    assert "Traceback" not in printed
    return printed.strip().splitlines()[-1]
