"""The picture of a story: a run under the base model, and again under the mended one.

`python -m softhand_bringup.lab_story.picture out/lab-story docs/figures/live.png`
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from softhand_bringup.bags.reading import Bag
from softhand_bringup.lab_story.measuring import ANGLES, RESIDUAL, Played
from softhand_bringup.lab_story.recorded import still_stamps

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
SESSIONS = {"measured": "base model", "mended": "with the effect added"}


@dataclass(frozen=True)
class Course:
    """One run: time [s] from its start, tip angle and the monitor's residual [deg], and where the
    pressure stands.
    """

    time: Array
    angle: Array
    residual: Array
    still: NDArray[np.bool_]


def draw(folder: Path, target: Path) -> None:
    """Draw the first run that both sessions of a story have.

    Raises:
        ValueError: the story of the folder was not told to its end, or added nothing.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    first = _shared(json.loads((folder / "result.json").read_text(encoding="utf-8")), folder)
    figure = Figure(figsize=(9.0, 5.5), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 2, sharex=True, sharey="row")
    courses = {s: read_course(folder / s / "bag", first[s]) for s in SESSIONS}
    largest = max(np.abs(c.residual[c.still]).max(initial=0.5) for c in courses.values())
    for column, (session, title) in enumerate(SESSIONS.items()):
        _draw_angles(panels[0, column], courses[session], title)
        _draw_residual(panels[1, column], courses[session], 1.2 * float(largest))
    panels[0, 0].set_ylabel("tip angle [deg]")
    panels[1, 0].set_ylabel("residual [deg]")
    panels[0, 0].legend(frameon=False)
    figure.savefig(target, dpi=110)


def read_course(bag: Path, run: Played) -> Course:
    """A run out of the bag of its session."""
    with Bag(bag) as recording:
        angles, residuals = recording.joints(ANGLES), recording.joints(RESIDUAL)
    known = dict(zip(angles.time.round(6), angles.position[:, 0], strict=True))
    time = residuals.time.round(6)
    inside = (time >= run.start) & (time <= run.end) & np.isin(time, list(known))
    still = np.array(still_stamps(bag)) / 1e9
    return Course(
        time[inside] - run.start,
        np.degrees([known[t] for t in time[inside]]),
        np.degrees(residuals.position[inside, 0]),
        np.isin(time[inside], still.round(6)),
    )


def _shared(result: dict[str, Any], folder: Path) -> dict[str, Played]:
    runs = {
        session: {entry["name"]: Played(**entry) for entry in result["runs"].get(session, [])}
        for session in SESSIONS
    }
    name = next((name for name in runs["mended"] if name in runs["measured"]), None)
    if name is None:
        raise ValueError(f"{folder}: expected a run under both models, got {result['runs']}")
    return {session: runs[session][name] for session in SESSIONS}


def _draw_angles(panel: Axes, course: Course, title: str) -> None:
    panel.plot(course.time, course.angle, color="black", label="measured")
    panel.plot(course.time, course.angle - course.residual, color="tab:red", label="predicted")
    panel.set_title(title)


def _draw_residual(panel: Axes, course: Course, limit: float) -> None:
    """In red where the pressure stands; the rest, in which the finger's inertia plays, in grey."""
    panel.axhline(0.0, color="black", linewidth=0.5)
    moving, standing = ~course.still, course.still
    panel.plot(course.time[moving], course.residual[moving], ".", color="0.8", markersize=3)
    panel.plot(course.time[standing], course.residual[standing], ".", color="tab:red", markersize=4)
    panel.set_ylim(-limit, limit)
    panel.set_xlabel("time [s]")


def main(arguments: list[str] | None = None) -> int:
    """Draw; 2 for a folder that holds no story told to its end."""
    words = sys.argv[1:] if arguments is None else arguments
    if len(words) != 2:
        print("usage: python -m softhand_bringup.lab_story.picture FOLDER PICTURE", file=sys.stderr)
        return 2
    try:
        draw(Path(words[0]), Path(words[1]))
    except (OSError, KeyError, ValueError) as error:
        print(f"lab-story: cannot draw: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
