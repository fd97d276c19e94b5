"""The command `softhand failures`: a picture an object of typical failures of a sweep (Fig. 8.5).

Each failure is a row: its trial is run again in process up to the moment at which it failed, and
drawn some time before, then, and some time after.
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
from numpy.typing import NDArray

from grasp_strategies.judging.failure import GraspWatch
from grasp_strategies.judging.judge import GRIPPED, GraspResult
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.sweep.results import read_results
from grasp_strategies.sweep.trial_line import trial_of
from grasp_strategies.trials import started_scene
from pneuflex_sim.pictures.render import HandState, Renderer
from softhand_bringup.film.command import VIEWS, camera_of
from softhand_bringup.film.recording import FilmedScene, Recording
from softhand_model.progress import Progress

Record = Mapping[str, Any]
Array = NDArray[np.float64]

AROUND = (-1.0, -0.4, 0.0, 0.4)  # [s] from the failure to each picture of it
SIZE = (480, 400)  # of a picture [pixels]
RESOLUTION = 100  # [dots an inch]
COUNT = 3  # failures an object


@dataclass(frozen=True)
class Replay:
    """A failure that was run again: states at times [s] from the failure, what draws them, and the
    result as it is now.
    """

    recording: Recording
    times: list[float]
    result: GraspResult


def typical(records: Iterable[Record], count: int = COUNT) -> list[Record]:
    """At most `count` failures: of each cause, the most frequent first, the trial whose place is
    nearest to the middle of all that failed so; then others, each as far as can be from the places
    of those before.

    Args:
        records: of trials of one object, as `softhand sweep` writes them.
        count: how many.
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
    """Where the object was (x, y) [m] under a hand that was not displaced."""
    return np.array(record["placement"]["offset"], float)


def _middle(records: Sequence[Record]) -> Record:
    places = np.array([_place(record) for record in records])
    return records[int(np.argmin(np.linalg.norm(places - places.mean(axis=0), axis=1)))]


def replay(record: Record, around: Sequence[float] = AROUND) -> Replay:
    """Run the trial of a failure again until the last picture of it is due.

    Args:
        record: `settings` that are not usual, `placement`, and `failed_at` [s].
        around: times of the pictures from the failure on [s]; those before the start are of it.

    Raises:
        ValueError: the settings have a name that does not exist.
    """
    settings, placement = trial_of(record)
    started = started_scene(settings)
    scene = FilmedScene(started.place(placement).simulation, settings.step)
    end = record["failed_at"] + max(around)

    def all_seen(watch: GraspWatch) -> str:
        return "all is drawn" if watch.last.time >= end - 1e-9 else ""

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
    """Draw failures, one a row, into a PNG file; returns a sentence for each that the run of now
    ends in another way than its record.

    Raises:
        ValueError: there are none, or one cannot be run.
    """
    if not records:
        raise ValueError("failures: expected at least one trial that failed, got none")
    width, height = SIZE[0] / RESOLUTION, SIZE[1] / RESOLUTION
    figure, axes = plt.subplots(
        len(records),
        len(AROUND),
        figsize=(width * len(AROUND), (height + 0.3) * len(records)),
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
                    f"{again.result.cause or GRIPPED} now"
                )
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=RESOLUTION)
    plt.close(figure)
    return differences


def _draw_row(axes: Any, record: Record, again: Replay, view: str) -> None:
    recording = again.recording
    options = argparse.Namespace(view=view, camera=None, distance=None, size=SIZE)
    camera = camera_of(options, recording)
    shown: list[HandState] = recording.states
    for column, (ax, state, time) in enumerate(zip(axes, shown, again.times, strict=True)):
        ax.imshow(recording.renderer.frame(state, SIZE, camera))
        ax.set(xticks=[], yticks=[])
        ax.set_xlabel(f"{time:.2f} s", fontsize=9)
        if AROUND[column] == 0.0:
            for side in ax.spines.values():
                side.set(color="firebrick", linewidth=2.5)
    title = f"{record['cause']}, in phase {record['phase']}    ({record['key']})"
    axes[0].set_title(title, loc="left", fontsize=11)


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(
        prog="softhand failures",
        description="Draw typical failures of a sweep, a picture an object; the trials run again.",
    )
    add = found.add_argument
    add("results", type=Path, help="results.jsonl of a sweep, or its folder")
    add("-o", "--out", type=Path, required=True, help="folder for the pictures, <object>.png")
    add("--object", action="append", help="this object alone; may be given again (all)")
    add("--count", type=int, default=COUNT, help="failures a picture (%(default)s)")
    add("--view", choices=VIEWS, default="oblique", help="where it is seen from (%(default)s)")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw the pictures; 0, or 2 when the options cannot be used."""
    options = parser().parse_args(arguments)
    try:
        return _run(options)
    except (ValueError, OSError) as error:
        print(f"softhand failures: {error}", file=sys.stderr)
        return 2


def _run(options: argparse.Namespace) -> int:
    records = read_results(options.results)
    if not records:
        raise ValueError(f"{options.results}: expected results of a sweep, got none")
    there = sorted({record["object"] for record in records})
    chosen = options.object or there
    if missing := sorted(set(chosen) - set(there)):
        raise ValueError(f"--object: expected some of {', '.join(there)}, got {missing[0]}")
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
