"""What the pushes came to: figures for each controller, and one sentence."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from softhand_bringup.demo.verdict import versions
from thesis.equilibrium_point.course import Course


@dataclass(frozen=True)
class Outcome:
    """One push: gauge pressure [Pa] and volume [m3] before it, pressed and after it; valve openings
    from its start to its end; force of the pressed finger [N].

    `enclosed_change` is how much more air is in the pressed finger than before, by pressure and
    shape [kg]: nothing under mass control. `enclosed_left` is the same after the push.
    """

    mode: str
    openings: int
    pressure: tuple[float, float, float]
    volume: tuple[float, float, float]
    force: float
    enclosed_change: float
    enclosed_left: float


def outcome(course: Course) -> Outcome:
    """Figures of a push."""
    enclosed = course.enclosed
    looks = (course.before, course.pressed, course.after)
    before, pressed, after = (look(enclosed) for look in looks)
    return Outcome(
        course.push.mode,
        len(course.openings),
        (looks[0](course.pressure), looks[1](course.pressure), looks[2](course.pressure)),
        (looks[0](course.volume), looks[1](course.volume), looks[2](course.volume)),
        course.pressed(course.force),
        pressed - before,
        after - before,
    )


def as_in_the_thesis(outcomes: Sequence[Outcome]) -> bool:
    """Whether mass control left the valves closed and every other controller opened one."""
    return all((outcome.openings == 0) == (outcome.mode == "mass") for outcome in outcomes)


def line(outcomes: Sequence[Outcome]) -> str:
    """The verdict in one line."""
    word = "as in Figs 4.1 and 4.2" if as_in_the_thesis(outcomes) else "NOT as in Figs 4.1 and 4.2"
    return f"{word}: " + "; ".join(_told(outcome) for outcome in outcomes)


def _told(outcome: Outcome) -> str:
    pressure, volume = 1e-3 * np.array(outcome.pressure), 1e6 * np.array(outcome.volume)
    return (
        f"{outcome.mode} control opened a valve {outcome.openings} times, "
        f"{pressure[0]:.1f} to {pressure[1]:.1f} kPa and {volume[0]:.2f} to {volume[1]:.2f} cm3, "
        f"{1e6 * outcome.enclosed_change:+.2f} mg while pressed, "
        f"{1e6 * outcome.enclosed_left:+.2f} mg after"
    )


def write(path: Path, outcomes: Sequence[Outcome], seed: int) -> None:
    """Write result.json: figures in SI units, the seed, and the versions that took part."""
    content = {
        "as_in_the_thesis": as_in_the_thesis(outcomes),
        "pushes": [asdict(outcome) for outcome in outcomes],
        "seed": seed,
        "versions": versions(),
    }
    path.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
