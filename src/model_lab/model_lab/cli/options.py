"""Options that several commands share."""

from __future__ import annotations

import argparse
import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from threading import Event, Lock, Thread
from types import TracebackType
from typing import Any, TextIO

from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.effects import Effect, effect_classes, effects_in_file
from softhand_model.effects.effect import EXPERIMENTS
from softhand_model.model_file import Model, load_model
from softhand_model.output_file import check_new, write_json

DEFAULT_MODEL = "base"


# ---------------------------------------------------------------------- declared
def add_data(parser: argparse.ArgumentParser) -> None:
    """The measurement set, by place."""
    parser.add_argument(
        "data", type=Path, metavar="DATA", help="folder of the measurements, with experiment.yaml"
    )


def add_model(parser: argparse.ArgumentParser) -> None:
    """The model, `base` if it is not named."""
    parser.add_argument(
        "--model",
        default=DEFAULT_MODEL,
        metavar="M",
        help="model file, or the name of a shipped one (default: %(default)s)",
    )


def add_effects(parser: argparse.ArgumentParser) -> None:
    """A user's own effects."""
    parser.add_argument(
        "--effects",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="Python file with effects of your own, which then take part; may be given again",
    )


def add_results(parser: argparse.ArgumentParser) -> None:
    """Where results go."""
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the result as JSON, too")
    add_force(parser)


def add_force(parser: argparse.ArgumentParser) -> None:
    """Whether results may overwrite what is there."""
    parser.add_argument("--force", action="store_true", help="overwrite files that exist")


def add_seed(parser: argparse.ArgumentParser) -> None:
    """What is drawn at random; same seed, same answer."""
    parser.add_argument(
        "--seed",
        type=_seed,
        default=0,
        metavar="N",
        help="of all that is drawn at random (default: %(default)s)",
    )


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Number of processes."""
    parser.add_argument(
        "--jobs",
        type=_positive,
        default=_processors(),
        metavar="N",
        help="processes (default: %(default)s)",
    )


# ---------------------------------------------------------------------- used
def measurements(arguments: argparse.Namespace) -> MeasurementSet:
    """The measurement set that the arguments name."""
    with Progress("reading the measurements") as progress:
        return load_measurements(arguments.data, progress)


def model(arguments: argparse.Namespace) -> Model:
    """The model that the arguments name, with the files of the user's own effects in it."""
    return named_model(arguments, arguments.model)


def named_model(arguments: argparse.Namespace, name: str) -> Model:
    """A model by file or shipped name; it may name the user's own effects without their file."""
    found = load_model(name, own_classes(arguments))
    named = {effect.name for effect in found.effects}
    own = {key: path for key, path in files(arguments).items() if key in named}
    return replace(found, files={**own, **found.files})


def classes(arguments: argparse.Namespace, known: Model) -> dict[str, type[Effect]]:
    """Effects that take part: built-in ones, those of the model, and the user's own."""
    of_model = {effect.name: type(effect) for effect in known.effects}
    return {**effect_classes(), **of_model, **own_classes(arguments)}


def own_classes(arguments: argparse.Namespace) -> dict[str, type[Effect]]:
    """The user's own effects, by name.

    Raises ValueError for one that acts in no experiment, or in two files.
    """
    found: dict[str, type[Effect]] = {}
    for path in arguments.effects:
        for name, effect in effects_in_file(path).items():
            if name in found:
                raise ValueError(f"{path}: effect {name}: expected it in one file, got it in two")
            if not effect.experiments:
                raise ValueError(
                    f"{path}: effect {name}: experiments: expected some of "
                    f"{', '.join(EXPERIMENTS)}, got none"
                )
            found[name] = effect
    return found


def files(arguments: argparse.Namespace) -> dict[str, Path]:
    """The file of each of the user's own effects."""
    return {name: path for path in arguments.effects for name in effects_in_file(path)}


def check_json(arguments: argparse.Namespace) -> None:
    """Refuse a result that could not be written, before any work."""
    if arguments.json is not None:
        check_new(arguments.json, arguments.force)


def save_json(arguments: argparse.Namespace, content: dict[str, Any]) -> None:
    """Write the result as JSON if asked for."""
    if arguments.json is not None:
        write_json(arguments.json, content, arguments.force)


def _positive(text: str) -> int:
    return _whole(text, 1)


def _seed(text: str) -> int:
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if value < least:
        raise argparse.ArgumentTypeError(f"expected a whole number from {least}, got {text}")
    return value


def _processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


PATIENCE = 2.0  # [s] before anything is shown
LINE_EVERY = 5.0  # [s] between lines where none can be written over
MOVE_EVERY = 0.2  # [s] between changes of one that can


class Progress:
    """A sign of life: one line that moves on a terminal, else a line every few seconds; a context.

    It shows by itself, also while nothing is told. Call it with the part that is done, from 0 to 1,
    and what is done now.

    Args:
        what: what is done, such as `reading the measurements`.
        stream: where it is shown, the standard error if None.
        patience: time [s] before anything is shown.
    """

    def __init__(self, what: str, stream: TextIO | None = None, patience: float = PATIENCE) -> None:
        self._what, self._patience = what, patience
        self._stream = sys.stderr if stream is None else stream
        self._moves = self._stream.isatty()
        self._part: float | None = None
        self._step = ""
        self._width = 0
        self._ended = Event()
        self._lock = Lock()
        self._start = time.monotonic()

    def __call__(self, part: float, step: str = "") -> None:
        """Tell the part that is done and what is done now."""
        with self._lock:
            self._part, self._step = part, step

    def __enter__(self) -> Progress:
        self._start = time.monotonic()
        self._thread = Thread(target=self._show_until_ended, daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop, and take a moving line away again."""
        self._ended.set()
        self._thread.join()
        if self._width:
            self._stream.write("\r" + " " * self._width + "\r")
            self._stream.flush()

    def _show_until_ended(self) -> None:
        pause = self._patience
        while not self._ended.wait(pause):
            self._show()
            pause = MOVE_EVERY if self._moves else LINE_EVERY

    def _show(self) -> None:
        line = self._line()
        if self._moves:
            self._stream.write("\r" + line.ljust(self._width))
            self._width = len(line)
        else:
            self._stream.write(line + "\n")
        self._stream.flush()

    def _line(self) -> str:
        with self._lock:
            part, step = self._part, self._step
        shown = f" {100.0 * part:.0f} %," if part else ""
        detail = f", {step}" if step else ""
        return f"{self._what}:{shown} {time.monotonic() - self._start:.0f} s{detail}"
