"""Draws a lab story: one run, predicted by the base model and by the improved one.

`python -m softhand_bringup.lab_story.picture out/lab-story docs/figures/live.png`
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from softhand_bringup.bags.reading import Bag
from softhand_bringup.lab_story.measuring import ANGLES, RESIDUAL, PlayedRun
from softhand_bringup.lab_story.recorded import still_stamps
from softhand_common.documents.json_document import read_json
from softhand_common.documents.output_file import save_figure
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import Node
from softhand_common.numerics.arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
SESSIONS = {"measured": "base model", "mended": "with the effect added"}


@dataclass(frozen=True)
class MonitoredRun:
    """One run: time [s] from its start, tip angle and the monitor's residual [deg], and whether the
    pressure is constant; all (k,).
    """

    time: Array
    angle: Array
    residual: Array
    still: NDArray[np.bool_]


def draw(folder: Path, target: Path) -> None:
    """Draw the first run that both sessions of a lab story have.

    Raises:
        ValueError: the lab story in the folder did not reach its end, or no effect was added.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    first = _shared(read_json(folder / "result.json"), folder)
    figure = Figure(figsize=(9.0, 5.5), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 2, sharex=True, sharey="row")
    runs = {s: read_run(folder / s / "bag", first[s]) for s in SESSIONS}
    largest = max(np.abs(c.residual[c.still]).max(initial=0.5) for c in runs.values())
    for column, (session, title) in enumerate(SESSIONS.items()):
        _draw_angles(panels[0, column], runs[session], title)
        _draw_residual(panels[1, column], runs[session], 1.2 * float(largest))
    panels[0, 0].set_ylabel("tip angle [deg]")
    panels[1, 0].set_ylabel("residual [deg]")
    panels[0, 0].legend(frameon=False)
    save_figure(figure, target, dpi=110)


def read_run(bag: Path, run: PlayedRun) -> MonitoredRun:
    """Read a run from the bag of its session."""
    with Bag(bag) as recording:
        angles, residuals = recording.joints(ANGLES), recording.joints(RESIDUAL)
    known = dict(zip(angles.time.round(6), angles.position[:, 0], strict=True))
    time = residuals.time.round(6)
    inside = (time >= run.start) & (time <= run.end) & np.isin(time, list(known))
    still = np.array(still_stamps(bag)) / 1e9
    return MonitoredRun(
        time[inside] - run.start,
        np.degrees([known[t] for t in time[inside]]),
        np.degrees(residuals.position[inside, 0]),
        np.isin(time[inside], still.round(6)),
    )


def _shared(result: Node, folder: Path) -> dict[str, PlayedRun]:
    found = result.mapping()
    if "runs" not in found:
        raise result.error("the key runs", listed(found))
    sessions = found["runs"].mapping()
    runs = {
        session: {run.name: run for run in map(_played, sessions[session].items())}
        if session in sessions
        else {}
        for session in SESSIONS
    }
    name = next((name for name in runs["mended"] if name in runs["measured"]), None)
    if name is None:
        raise ValueError(
            f"{folder}: expected a run that both sessions ({listed(SESSIONS)}) have, got none in "
            f"{listed(sessions) or 'an empty list of sessions'}"
        )
    return {session: runs[session][name] for session in SESSIONS}


def _played(node: Node) -> PlayedRun:
    entry = node.fields([field.name for field in fields(PlayedRun)])
    for key in ("start", "end"):
        entry[key].number()
    entry["name"].text()
    return PlayedRun(**node.value)


def _draw_angles(panel: Axes, run: MonitoredRun, title: str) -> None:
    panel.plot(run.time, run.angle, color="black", label="measured")
    panel.plot(run.time, run.angle - run.residual, color="tab:red", label="predicted")
    panel.set_title(title)


def _draw_residual(panel: Axes, run: MonitoredRun, limit: float) -> None:
    """Draw the residual in red at constant pressure, else in grey: there inertia matters."""
    panel.axhline(0.0, color="black", linewidth=0.5)
    moving, standing = ~run.still, run.still
    panel.plot(run.time[moving], run.residual[moving], ".", color="0.8", markersize=3)
    panel.plot(run.time[standing], run.residual[standing], ".", color="tab:red", markersize=4)
    panel.set_ylim(-limit, limit)
    panel.set_xlabel("time [s]")


def main(arguments: list[str] | None = None) -> int:
    """Draw the picture; returns 0, or 2 when it cannot be drawn."""
    words = sys.argv[1:] if arguments is None else arguments
    if len(words) != 2:
        print("usage: python -m softhand_bringup.lab_story.picture FOLDER PICTURE", file=sys.stderr)
        return 2
    try:
        draw(Path(words[0]), Path(words[1]))
    except (OSError, ValueError) as error:
        print(f"lab-story: cannot draw: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
