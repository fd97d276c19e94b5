"""Comparison of engines: the same trials in each engine, and which have the same verdict."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

DIFFERING_SHOWN = 8  # trials that differ, named in a line of text


@dataclass(frozen=True)
class Agreement:
    """Verdicts of trials that several engines ran.

    Args:
        name: what the trials share, such as plan and object.
        engines: names of the engines.
        verdicts: whether the object was gripped in each of the engines, by the name of a trial.
        refusal: the first reason for which an engine has no verdict on some trials; empty if all
            have one.
    """

    name: str
    engines: tuple[str, ...]
    verdicts: Mapping[str, tuple[bool, ...]]
    refusal: str = ""

    @property
    def gripped(self) -> dict[str, int]:
        """Number of successes by engine."""
        return {
            name: sum(found[k] for found in self.verdicts.values())
            for k, name in enumerate(self.engines)
        }

    @property
    def differing(self) -> dict[str, list[str]]:
        """Trials on which the engines differ, with the engines in which they were gripped."""
        return {
            trial: [name for name, held in zip(self.engines, found, strict=True) if held]
            for trial, found in self.verdicts.items()
            if len(set(found)) > 1
        }

    @property
    def same(self) -> int:
        """Number of trials with the same verdict in all engines."""
        return len(self.verdicts) - len(self.differing)

    @property
    def text(self) -> str:
        """One line, which names some of the trials on which the engines differ.

        >>> verdicts = {"seed 0": (True, True), "seed 1": (True, False)}
        >>> Agreement("ball", ("pybullet", "mujoco"), verdicts).text
        'gripped pybullet 2, mujoco 1 of 2; same verdict 1 of 2; differ: seed 1 (pybullet)'
        """
        count, counts = len(self.verdicts), self.gripped.items()
        words = f"gripped {', '.join(f'{name} {held}' for name, held in counts)} of {count}"
        words += f"; same verdict {self.same} of {count}"
        named = [f"{trial} ({', '.join(held)})" for trial, held in self.differing.items()]
        if named:
            more = [f"{len(named) - DIFFERING_SHOWN} more"] if len(named) > DIFFERING_SHOWN else []
            words += f"; differ: {', '.join(named[:DIFFERING_SHOWN] + more)}"
        return words + (f"; not compared: {self.refusal}" if self.refusal else "")

    def record(self) -> dict[str, Any]:
        """The agreement as plain data for JSON."""
        counts = {"trials": len(self.verdicts), "gripped": self.gripped, "same": self.same}
        differing = {"differing": self.differing, "refusal": self.refusal}
        return {"name": self.name, **counts, **differing, "text": self.text}


def add_engines(parser: argparse.ArgumentParser) -> None:
    """Add the option of a command that runs the same trials in several engines and compares their
    verdicts.
    """
    words = "run the trials in each of these and compare the verdicts, such as pybullet,mujoco"
    parser.add_argument("--engines", type=_names, metavar="NAME,NAME", help=words)


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split(","))
