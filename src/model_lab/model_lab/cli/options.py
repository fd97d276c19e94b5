"""Options that several commands share."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.documents.output_file import check_new, write_json
from softhand_model.effects import Effect, effect_classes, effects_in_file
from softhand_model.effects.effect import EXPERIMENTS
from softhand_model.model_file import ALLOW_EFFECT_FILES, ALLOW_HELP, Model, load_model
from softhand_model.progress import Progress

Argument = tuple[tuple[str, ...], dict[str, Any]]
"""What `ArgumentParser.add_argument` takes."""


def argument(*flags: str, **given: Any) -> Argument:
    """An argument of a command."""
    return flags, given


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


# ---------------------------------------------------------------------- declared
DATA = argument(
    "data", type=Path, metavar="DATA", help="folder of the measurements, with experiment.yaml"
)
MODEL = argument(
    "--model",
    default="base",
    metavar="M",
    help="model file, or the name of a shipped one (default: %(default)s)",
)
FREE_MODULUS = argument(
    "--free-modulus",
    action="store_true",
    help="fit the shear modulus without bounds, as where the rubber itself is tested",
)
EFFECTS = (
    argument(
        "--effects",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="Python file with effects of your own, which is run; may be given again",
    ),
    argument(ALLOW_EFFECT_FILES, action="store_true", help=ALLOW_HELP),
)
RESULTS = (
    argument("--json", type=Path, metavar="OUT", help="write the result as JSON, too"),
    argument("--force", action="store_true", help="overwrite files that exist"),
)
SEED = argument(
    "--seed",
    type=_seed,
    default=0,
    metavar="N",
    help="of all that is drawn at random (default: %(default)s)",
)
JOBS = argument(
    "--jobs",
    type=_positive,
    default=_processors(),
    metavar="N",
    help="processes (default: %(default)s)",
)


# ---------------------------------------------------------------------- used
def measurements(arguments: argparse.Namespace) -> MeasurementSet:
    """The measurement set that the arguments name."""
    with Progress("reading") as progress:
        return load_measurements(arguments.data, progress)


def model(arguments: argparse.Namespace) -> Model:
    """The model that the arguments name, with the files of the user's own effects in it."""
    return named_model(arguments, arguments.model)


def named_model(arguments: argparse.Namespace, name: str) -> Model:
    """A model by file or shipped name; it may name the user's own effects without their file."""
    found = load_model(name, own_classes(arguments), arguments.allow_effect_files)
    found = replace(found, free_modulus=found.free_modulus or arguments.free_modulus)
    named = {effect.name for effect in found.effects}
    own = {key: path for key, path in files(arguments).items() if key in named}
    return replace(found, files={**found.files, **own})


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
