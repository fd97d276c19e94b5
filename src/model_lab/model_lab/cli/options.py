"""Options that several commands share."""

from __future__ import annotations

import argparse
import math
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from model_lab.experiments.hand_pose import with_weight
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.own_effects import all_classes, file_of_each, own_classes
from softhand_common.documents.output_file import check_new, write_json
from softhand_common.progress import Progress
from softhand_model.effects import Effect
from softhand_model.model_file import ALLOW_EFFECT_FILES, ALLOW_HELP, Model, load_model

MAPPED = (
    "time",
    "pressure",
    "tip_angle",
    "tip_force",
    "stretch",
    "strain",
    "stress",
    "temperature",
)  # quantities of columns of an imported file
OF_HAND = re.compile(r"wrist|places|pressure\.\w+|\w+_tip")
DECIMAL_SIGNS = {"point": ".", "comma": ","}  # by name
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


def column_map(text: str) -> tuple[str, tuple[str, str]]:
    """Quantity, column and unit ("" if it is not given) of NAME=COLUMN[:UNIT]."""
    quantity, equals, column = text.partition("=")
    name, _, unit = column.partition(":")
    known = quantity in MAPPED or OF_HAND.fullmatch(quantity) is not None
    if not equals or not (name or unit) or not known:
        raise argparse.ArgumentTypeError(
            f"expected NAME=COLUMN:UNIT with NAME of {', '.join(MAPPED)} (of a hand also wrist, "
            f"places, pressure.CHANNEL or a marker such as index_tip), got {text}"
        )
    return quantity, (name, unit)


def clock_shift(text: str) -> tuple[str, float]:
    """File and time [s] of FILE=SECONDS."""
    file, _, seconds = text.rpartition("=")
    try:
        return file, float(seconds)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected FILE=SECONDS, got {text}") from None


def attitude(text: str) -> tuple[str, tuple[float, ...]]:
    """File ("" for all) and roll, pitch, yaw [rad] of [FILE=]ROLL,PITCH,YAW in degrees.

    >>> attitude("poses.csv=0,180,0")
    ('poses.csv', (0.0, 3.141592653589793, 0.0))
    """
    file, _, angles = text.rpartition("=")
    try:
        roll, pitch, yaw = (math.radians(float(angle)) for angle in angles.split(","))
    except ValueError:
        roll = pitch = yaw = math.nan
    if not math.isfinite(roll + pitch + yaw):
        raise argparse.ArgumentTypeError(f"expected [FILE=]ROLL,PITCH,YAW in degrees, got {text}")
    return file, (roll, pitch, yaw)


def stretch_before(text: str) -> tuple[str, float]:
    """File ("" for all) and largest stretch before its run, of [FILE=]STRETCH."""
    file, _, stretch = text.rpartition("=")
    try:
        return file, float(stretch)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected [FILE=]STRETCH, got {text}") from None


def sheet_of(text: str) -> tuple[str, str]:
    """File ("" for all) and sheet, of [FILE=]SHEET."""
    file, _, sheet = text.rpartition("=")
    if not sheet:
        raise argparse.ArgumentTypeError(f"expected [FILE=]SHEET, got {text}")
    return file, sheet


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
GIVEN = (DATA, MODEL, FREE_MODULUS, *EFFECTS)
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
    found = load_model(name, own_classes(arguments.effects), arguments.allow_effect_files)
    found = replace(found, free_modulus=found.free_modulus or arguments.free_modulus)
    named = {effect.name for effect in found.effects}
    own = {key: path for key, path in file_of_each(arguments.effects).items() if key in named}
    return replace(found, files={**found.files, **own})


def given(
    arguments: argparse.Namespace,
) -> tuple[Model, dict[str, type[Effect]], MeasurementSet]:
    """Model, effects that take part, and measurement set."""
    known, data = of_set(arguments)
    return known, all_classes(known, arguments.effects), data


def of_set(arguments: argparse.Namespace) -> tuple[Model, MeasurementSet]:
    """Model and measurement set; says so where the model gets the weight that hands have."""
    known, data = model(arguments), measurements(arguments)
    fitting = with_weight(data, known)
    if fitting is not known:
        print(f"{arguments.model} has no weight; that of the hand is taken in (effect gravity)")
    return fitting, data


def check_json(arguments: argparse.Namespace) -> None:
    """Refuse a result that could not be written, before any work."""
    if arguments.json is not None:
        check_new(arguments.json, arguments.force)


def save_json(arguments: argparse.Namespace, content: dict[str, Any]) -> None:
    """Write the result as JSON if asked for."""
    if arguments.json is not None:
        write_json(arguments.json, content, arguments.force)
