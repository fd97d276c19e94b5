"""The command `softhand failures`: typical failures of a sweep, one picture per object (Fig. 8.5).

Each row shows one failure: its trial is run again in process, and drawn shortly before, at and
after the time at which it failed.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from grasp_strategies.judging.failure import GraspWatch
from grasp_strategies.judging.judge import OUTCOME_GRIPPED, GraspResult
from grasp_strategies.sequencer import Sequencer
from pneuflex_sim.pictures.render import HandState, Renderer
from softhand_bringup.film.command import CAMERA_VIEWS, camera_of
from softhand_bringup.film.recording import FilmedScene, Recording
from softhand_common.documents.output_file import save_figure
from softhand_common.numerics.arrays import Array
from softhand_common.progress import Progress
from softhand_trials.sweep.results import read_results
from softhand_trials.sweep.trial_task import trial_of
from softhand_trials.trials import started_scene

Record = Mapping[str, Any]

FRAME_OFFSETS = (-1.0, -0.4, 0.0, 0.4)  # [s] from the failure to each picture of it
FAILURE_SIZE = (480, 400)  # of a picture [pixels]
FAILURE_DPI = 100  # [dots an inch]
FAILURES_PER_OBJECT = 3  # failures an object


@dataclass(frozen=True)
class Replay:
    """A failed trial that was run again: its states, the times [s] of the states since the start,
    and the new result.
    """

    recording: Recording
    times: list[float]
    result: GraspResult


def typical(records: Iterable[Record], count: int = FAILURES_PER_OBJECT) -> list[Record]:
    """At most `count` typical failures.

    First, for each cause in order of frequency, the trial whose object place is nearest to the mean
    place of this cause; then the trials that are farthest from the places chosen so far.

    Args:
        records: records of trials of one object, as `softhand sweep` writes them.
        count: largest number of failures.
    """
    failed = [record for record in records if record.get("failed_at") is not None]
    causes = Counter(record["cause"] for record in failed).most_common(count)
    chosen = [_middle([r for r in failed if r["cause"] == cause]) for cause, _ in causes]
    while len(chosen) < min(count, len(failed)):
        taken = np.array([_place(record) for record in chosen])
        others = [record for record in failed if record not in chosen]
        apart = [np.linalg.norm(taken - _place(record), axis=1).min() for record in others]
        chosen.append(others[int(np.argmax(apart))])
    return chosen


def _place(record: Record) -> Array:
    """Offset (x, y) [m] of the object from its usual place."""
    return np.array(record["placement"]["offset"], float)


def _middle(records: Sequence[Record]) -> Record:
    places = np.array([_place(record) for record in records])
    return records[int(np.argmin(np.linalg.norm(places - places.mean(axis=0), axis=1)))]


def replay(record: Record, around: Sequence[float] = FRAME_OFFSETS) -> Replay:
    """Run a failed trial again, up to the time of its last picture.

    Args:
        record: record of the trial, with `settings`, `placement` and `failed_at` [s].
        around: times of the pictures relative to the failure [s]; for times before the start, the
            start is shown.

    Raises:
        ValueError: a name in the settings does not exist.
    """
    settings, placement = trial_of(record)
    started = started_scene(settings)
    scene = FilmedScene(started.place(placement).simulation, settings.step)
    end = record["failed_at"] + max(around)

    def all_seen(watch: GraspWatch) -> str:
        return "all states are recorded" if watch.last.time >= end - 1e-9 else ""

    result = Sequencer(scene, started.strategy, options=settings.options, decided=all_seen).run()
    last = len(scene.states) - 1
    chosen = [round((record["failed_at"] + time) / settings.step) for time in around]
    chosen = [min(max(index, 0), last) for index in chosen]
    simulation = scene.simulation
    renderer = Renderer(simulation.hand, settings.object, simulation.scene, settings.segments)
    recording = Recording(
        [scene.states[index] for index in chosen],
        np.array([scene.pressures[index] for index in chosen]),
        settings.step,
        renderer,
        result.cause,
    )
    times = [index * settings.step for index in chosen]
    return Replay(recording, times, result)


def draw_failures(records: Sequence[Record], path: Path, view: str = "oblique") -> list[str]:
    """Draw failures into a PNG file, one per row; returns a sentence for each trial whose result
    now differs from its record.

    Raises:
        ValueError: there are no failures, or one cannot be run.
    """
    if not records:
        raise ValueError("failures: expected at least one failed trial in the results, got none")
    width, height = FAILURE_SIZE[0] / FAILURE_DPI, FAILURE_SIZE[1] / FAILURE_DPI
    figure, axes = plt.subplots(
        len(records),
        len(FRAME_OFFSETS),
        figsize=(width * len(FRAME_OFFSETS), (height + 0.3) * len(records)),
        squeeze=False,
        layout="constrained",
    )
    differences = []
    with Progress("drawing") as progress:
        for row, record in enumerate(records):
            progress("failures", row + 1, len(records))
            again = replay(record)
            _draw_row(axes[row], record, again, view)
            if again.result.cause != record["cause"]:
                differences.append(
                    f"{record['key']}: {record['cause']} in the record, "
                    f"{again.result.cause or OUTCOME_GRIPPED} now"
                )
    save_figure(figure, path, dpi=FAILURE_DPI)
    plt.close(figure)
    return differences


def _draw_row(axes: Any, record: Record, again: Replay, view: str) -> None:
    recording = again.recording
    options = argparse.Namespace(view=view, camera=None, distance=None, size=FAILURE_SIZE)
    camera = camera_of(options, recording)
    shown: list[HandState] = recording.states
    for column, (ax, state, time) in enumerate(zip(axes, shown, again.times, strict=True)):
        ax.imshow(recording.renderer.frame(state, FAILURE_SIZE, camera))
        ax.set(xticks=[], yticks=[])
        ax.set_xlabel(f"{time:.2f} s", fontsize=9)
        if FRAME_OFFSETS[column] == 0.0:
            for side in ax.spines.values():
                side.set(color="firebrick", linewidth=2.5)
    title = f"{record['cause']}, in phase {record['phase']}    ({record['key']})"
    axes[0].set_title(title, loc="left", fontsize=11)


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(
        prog="softhand failures",
        description="Draw typical failures of a sweep, one picture per object, from new runs of "
        "their trials.",
    )
    add = found.add_argument
    add("results", type=Path, help="results.jsonl of a sweep, or its folder")
    add("-o", "--out", type=Path, required=True, help="folder for the pictures, <object>.png")
    add("--object", action="append", help="only this object; can be repeated (all)")
    add("--count", type=int, default=FAILURES_PER_OBJECT, help="failures per object (%(default)s)")
    add(
        "--view",
        choices=CAMERA_VIEWS,
        default="oblique",
        help="direction of the camera (%(default)s)",
    )
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw the pictures; returns 0, or 2 when the options cannot be used."""
    options = parser().parse_args(arguments)
    try:
        return _run(options)
    except (ValueError, OSError) as error:
        print(f"softhand failures: {error}", file=sys.stderr)
        return 2


def _run(options: argparse.Namespace) -> int:
    records = read_results(options.results, ("object", "settings", "placement"), "outcome")
    if not records:
        raise ValueError(
            f"{options.results}: expected results of a sweep, got none; `softhand sweep` makes them"
        )
    known = sorted({record["object"] for record in records})
    chosen = options.object or known
    if missing := sorted(set(chosen) - set(known)):
        raise ValueError(f"--object: expected some of {', '.join(known)}, got {missing[0]}")
    for name in chosen:
        failed = typical([r for r in records if r["object"] == name], options.count)
        if not failed:
            print(f"{name}: no trial failed")
            continue
        path = options.out / f"{name}.png"
        for difference in draw_failures(failed, path, options.view):
            print(f"softhand failures: {difference}", file=sys.stderr)
        print(f"{path}: {', '.join(str(record['cause']) for record in failed)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
