# PYTHON_ARGCOMPLETE_OK
"""The command `softhand`: all commands of the suite as subcommands, and its nodes by `run`.

Completion in the shell: `eval "$(register-python-argcomplete softhand)"`.
"""

from __future__ import annotations

import argparse
import difflib
import importlib
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

import argcomplete

from softhand_common.standard_output import with_checked_output

COMMANDS: dict[str, dict[str, tuple[str, str]]] = {
    "grasp": {
        "demo": ("softhand_bringup.ros.demo", "a grasp by simulator, driver, sequencer (ROS)"),
        "trials": ("softhand_trials.trials", "simulated grasps without ROS, as JSON"),
        "sweep": (
            "softhand_trials.sweep.command",
            "many trials, by a plan; continues when stopped",
        ),
        "search": ("softhand_trials.search.command", "values that minimise a cost"),
        "film": ("softhand_bringup.film.command", "film of a trial or a bag: PNG, GIF or MP4"),
        "failures": ("softhand_bringup.film.failures", "pictures of failed trials of a sweep"),
        "figures": ("softhand_bringup.figures", "the two pictures of a grasp, from its bag"),
    },
    "build": {
        "hand": ("softhand_design.commands.hand", "design, moulds, parts, picture, URDF of a hand"),
        "skin": ("pneuflex_sim.commands.skin", "a hand that closes, as meshes or pictures"),
        "objects": ("pneuflex_sim.commands.objects", "objects to grasp: table or picture"),
        "materials": (
            "softhand_design.commands.materials",
            "rubbers, fibres, and which rubber suits",
        ),
        "choke-foil": (
            "softhand_design.commands.choke_foil",
            "drawing of the foil with the chokes, as SVG",
        ),
    },
    "measure": {
        "lab": ("model_lab.cli.main", "compare, diagnose, add ...; also as model-lab"),
        "lab-demo": ("model_lab.cli.demo", "find an effect that is hidden, and add it"),
        "lab-story": ("softhand_bringup.ros.lab_story", "the same on a running finger (ROS)"),
        "hand-story": ("softhand_bringup.ros.hand_story", "the same on a running hand (ROS)"),
    },
    "box": {
        "calibrate": (
            "pneumaticbox_driver.calibration.command",
            "calibrate the simulated box; a real one by its service",
        ),
        "hardware": (
            "pneumaticbox_driver.backends.hardware.__main__",
            "read sensors, switch valves of a real box",
        ),
    },
    "record": {
        "record": ("softhand_bringup.ros.recorder", "write all topics to a bag (ROS)"),
        "repair-bag": ("softhand_bringup.bags.repair", "repair a bag whose recorder was killed"),
    },
}
NODES = {
    "hand_with_box": (
        "softhand_bringup.ros.hand_with_box.interface",
        "the simulator and the driver, in one process",
    ),
    "hand_sim": ("pneuflex_sim.ros.interface", "the simulator"),
    "driver": ("pneumaticbox_driver.ros.interface", "control of the channels' air"),
    "sequencer": ("grasp_strategies.ros.interface", "runs grasp strategies"),
    "monitor": ("model_lab.ros.interface", "compares hand and model, live"),
}
RUN = "run"
USAGE = "usage: softhand COMMAND [OPTIONS]    (softhand COMMAND --help: its options)"


def overview() -> str:
    """The help text: all commands and nodes of the suite."""
    lines = [USAGE, "", "Grasping with pneumatic soft hands: simulator, driver, strategies, lab."]
    for group, commands in COMMANDS.items():
        lines += ["", f"{group}:"]
        lines += [f"  {name:<12}{words}" for name, (_, words) in commands.items()]
    lines += ["", "nodes, without ROS installed (softhand run NODE --ros-args -p NAME:=VALUE):"]
    lines += [f"  run {name:<14}{words}" for name, (_, words) in NODES.items()]
    return "\n".join(lines)


def modules() -> dict[str, str]:
    """Module of each command; nodes have the names `run NODE`."""
    found = {name: module for group in COMMANDS.values() for name, (module, _) in group.items()}
    return found | {f"{RUN} {name}": module for name, (module, _) in NODES.items()}


@with_checked_output("softhand")
def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command with the arguments behind its name; returns its exit status, 2 for an unknown
    name, or 74 when the standard output cannot be written.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if "_ARGCOMPLETE" in os.environ:
        return _complete()
    if not words or words[0] in ("-h", "--help", "help"):
        print(overview())
        return 0
    taken = 2 if words[0] == RUN else 1
    name, rest = " ".join(words[:taken]), words[taken:]
    if name not in modules():
        return _refuse(name)
    if taken == 2:
        _start(name, rest)
    return int(importlib.import_module(modules()[name]).main(rest) or 0)


def _start(name: str, arguments: list[str]) -> NoReturn:
    """Replace this process by that of a node, which imports its modules itself."""
    os.execv(sys.executable, [sys.executable, "-m", modules()[name], *arguments])


def _refuse(name: str) -> int:
    near = difflib.get_close_matches(name, modules(), 1)
    hint = f"did you mean {near[0]}?" if near else "softhand --help lists them"
    print(f"softhand: expected a command, got {name!r}; {hint}", file=sys.stderr)
    return 2


def _complete() -> int:
    """Complete the command line for the shell: names of commands, then options of a command."""
    words = os.environ.get("COMP_LINE", "").split()
    name = words[1] if len(words) > 1 else ""
    if name in modules() and not os.environ["COMP_LINE"].endswith(name):
        # a command first parses its arguments; instead of that its parser then completes and exits
        os.environ["_ARGCOMPLETE"] = str(int(os.environ["_ARGCOMPLETE"]) + 1)
        argparse.ArgumentParser.parse_args = (  # type: ignore[method-assign]
            lambda self, *_, **__: argcomplete.autocomplete(self)  # type: ignore[assignment]
        )
        importlib.import_module(modules()[name]).main([])
        return 0
    parser = argparse.ArgumentParser(prog="softhand")
    commands = parser.add_subparsers()
    for single in (name for group in COMMANDS.values() for name in group):
        commands.add_parser(single)
    commands.add_parser(RUN).add_argument("node", choices=list(NODES))
    argcomplete.autocomplete(parser)
    return 0


if __name__ == "__main__":
    sys.exit(main())
