"""A stored grasp as a strategy file: the object is held out, gripped, released and shaken (8.2.2).

The phases are those in which the grasps were found (`patterns`). Added are waits for the air, as
chokes and valves take longer than the ramps, and, after the release, a roll of the hand by 45 deg
to either side and a shake of 30 mm. The judge of strategies decides whether the object is still in
the hand; whether the right parts hold it is judged by the experiment.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from grasp_strategies.strategy.description import FORMAT
from softhand_common.documents.output_file import write_new
from softhand_model.hand.hand import load_hand
from thesis.chapter_8.dexterity.feix import PALM, THUMB, grasp_types
from thesis.chapter_8.dexterity.patterns import Pattern, Patterns, Times

HEAD = "# Written by `python -m thesis run feix`; docs/thesis/feix.md says how it was found."
SCENE = "held"  # without a table, the hand upright
ASIDE = [0.6, 0.0, 0.1]  # out of the hand's way, in the wrist frame [m]
FILLED = {"until": {"air_mass_error": {"below": 5e-6}}, "time_out": 6.0, "on_time_out": "next"}
ROLL, SHAKE = math.radians(45.0), 0.030  # [rad], [m]
SUCCESS = {  # the limits of the experiment's judge
    "lift_height": 0.100,
    "hold_time": 1.0,
    "hold_phase": "hold",
    "max_slip": 0.010,
    "max_turn": 0.349,
}


def write_strategies(patterns: Patterns, folder: Path) -> list[Path]:
    """Write `NN.yaml` of every stored grasp, over earlier ones; the files in order of the types."""
    paths = [folder / f"{number:02d}.yaml" for number in sorted(patterns.grasps)]
    for number, path in zip(sorted(patterns.grasps), paths, strict=True):
        write_new(path, strategy_text(number, patterns), force=True)
    return paths


def strategy_text(number: int, patterns: Patterns) -> str:
    """The strategy file of the stored grasp of a type; raises KeyError when none is stored."""
    pattern, kind = patterns.grasps[number].pattern, grasp_types()[number]
    content = {
        "format": FORMAT,
        "name": f"feix_{number}",
        "description": f"Feix type {number}, {kind.name}: the object is held out to the pre-grasp "
        "posture, gripped, let go and shaken",
        "hand": patterns.hand,
        "objects": [pattern.object],
        "scene": SCENE,
        "segments": patterns.segments,
        "step": patterns.step,
        "finger_contact": True,
        "success": SUCCESS,
        "phases": [
            *_close(pattern, patterns.times, _palm_channels(patterns.hand)),
            *_shake(),
            {"name": "hold", "duration": 1.2},
            {
                "name": "take_away",
                "option": "lower_and_release",
                "hold_object": {"position": ASIDE},
                "air_mass": dict.fromkeys(load_hand(patterns.hand).channels, 0.0),
                "air_ramp": 0.5,
                **FILLED,
            },
        ],
    }
    text: str = yaml.dump(content, Dumper=_NoAliases, sort_keys=False, width=150, **_FLOW)
    return f"{HEAD}\n{text}"


_FLOW: Mapping[str, Any] = {"default_flow_style": None}


class _NoAliases(yaml.SafeDumper):
    """A YAML dumper that writes repeated values out instead of as aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        """Whether a value is never written as a reference."""
        return True


def _close(pattern: Pattern, times: Times, palm: set[str]) -> list[dict[str, Any]]:
    """From the pre-grasp posture to the object that is let go."""
    pose = {"position": list(pattern.position), "orientation": list(pattern.orientation)}
    return [
        {"name": "put_aside", "hold_object": {"position": ASIDE}},
        _filling("pre_grasp", pattern.pre, times.pre),
        {"name": "settle", "duration": times.settle},
        {"name": "hold_out", "hold_object": pose},
        *(_filling(name, masses, times.grasp) for name, masses in _rounds(pattern, palm)),
        {"name": "settle_grasp", "duration": times.settle},
        {"name": "release", "release_object": times.release},
        {"name": "settle_release", "duration": times.settle},
    ]


def _rounds(pattern: Pattern, palm: set[str]) -> Sequence[tuple[str, dict[str, float]]]:
    """Names and masses [kg] of the fills, in order."""
    if not pattern.palm_first:
        return (("grasp", dict(pattern.final)),)
    return (
        ("grasp_by_palm", {c: mass for c, mass in pattern.final.items() if c in palm}),
        ("grasp_by_fingers", {c: mass for c, mass in pattern.final.items() if c not in palm}),
    )


def _palm_channels(hand: str) -> set[str]:
    chains = (load_hand(hand).chain(name) for name in (PALM, THUMB))
    return {channel for chain in chains for channel in chain.channels.values()}


def _filling(name: str, masses: Mapping[str, float], ramp: float) -> dict[str, Any]:
    return {"name": name, "air_mass": dict(masses), "air_ramp": ramp, **FILLED}


def _shake() -> list[dict[str, Any]]:
    """Roll by 45 deg to either side, and 30 mm to and fro."""
    turns = (("roll", ROLL, 0.7), ("roll_back", -2.0 * ROLL, 1.2), ("upright", ROLL, 0.7))
    ways = (("to", SHAKE, 0.4), ("fro", -2.0 * SHAKE, 0.6), ("middle", SHAKE, 0.4))
    return [
        *(_moved(name, "wrist", time, rpy=[round(turn, 6), 0, 0]) for name, turn, time in turns),
        *(_moved(name, "wrist_level", time, [0, way, 0]) for name, way, time in ways),
    ]


def _moved(
    name: str, frame: str, duration: float, position: Sequence[float] = (0, 0, 0), **turn: Any
) -> dict[str, Any]:
    wrist = {"frame": frame, "position": list(position), **turn}
    return {"name": name, "wrist": wrist, "duration": duration}
