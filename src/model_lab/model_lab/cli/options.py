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
from model_lab.measurements.hands import LARGEST_FRICTION, Grasped, Plate
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
    *("direction", "duration", "p_in", "p_out", "mass", "friction_integral", "injector_integral"),
    *("tip_x", "tip_y", "tip_z", "tip_qx", "tip_qy", "tip_qz", "tip_qw"),
    *("torque_x", "torque_y", "torque_z"),
    "temperature",
)  # quantities of columns of an imported file
OF_HAND = re.compile(r"wrist|places|pressure\.\w+|\w+_tip")
DECIMAL_SIGNS = {"point": ".", "comma": ","}  # by name
Argument = tuple[tuple[str, ...], dict[str, Any]]
"""What `ArgumentParser.add_argument` takes."""


def argument(*flags: str, **given: Any) -> Argument:
    """An argument of a command: what `ArgumentParser.add_argument` takes."""
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
        raise argparse.ArgumentTypeError(f"expected a whole number not below {least}, got {text}")
    return value


def _processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def column_map(text: str) -> tuple[str, tuple[str, str]]:
    """(quantity, (column, unit)) from the text NAME=COLUMN[:UNIT]; the unit is "" if it is not
    given.
    """
    quantity, equals, column = text.partition("=")
    name, _, unit = column.partition(":")
    known = quantity in MAPPED or OF_HAND.fullmatch(quantity) is not None
    if not equals or not (name or unit) or not known:
        raise argparse.ArgumentTypeError(
            f"expected NAME=COLUMN:UNIT where NAME is one of {', '.join(MAPPED)} (for a hand also "
            f"wrist, places, pressure.CHANNEL or a marker such as index_tip), got {text}"
        )
    return quantity, (name, unit)


def _of_file(text: str) -> tuple[str, str]:
    """(file name, what is said of it) from the text [FILE=]WHAT, where FILE may be a path; without
    FILE, the name is "".

    >>> _of_file("mocap/poses.csv=0,180,0")
    ('poses.csv', '0,180,0')
    """
    file, _, said = text.rpartition("=")
    return Path(file).name, said


def clock_shift(text: str) -> tuple[str, float]:
    """(file name, time [s]) from the text FILE=SECONDS."""
    file, seconds = _of_file(text)
    try:
        return file, float(seconds)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"expected FILE=SECONDS, such as forces.csv=0.25, got {text}"
        ) from None


def attitude(text: str) -> tuple[str, tuple[float, ...]]:
    """(file name, (roll, pitch, yaw) [rad]) from the text [FILE=]ROLL,PITCH,YAW in degrees; without
    FILE, the name is "", which stands for all files.

    >>> attitude("poses.csv=0,180,0")
    ('poses.csv', (0.0, 3.141592653589793, 0.0))
    """
    file, angles = _of_file(text)
    try:
        roll, pitch, yaw = (math.radians(float(angle)) for angle in angles.split(","))
    except ValueError:
        roll = pitch = yaw = math.nan
    if not math.isfinite(roll + pitch + yaw):
        raise argparse.ArgumentTypeError(
            f"expected ROLL,PITCH,YAW or FILE=ROLL,PITCH,YAW in degrees, got {text}"
        )
    return file, (roll, pitch, yaw)


def stretch_before(text: str) -> tuple[str, float]:
    """(file name, largest stretch [-] before the run) from the text [FILE=]STRETCH; without FILE,
    the name is "", which stands for all files.
    """
    file, stretch = _of_file(text)
    try:
        return file, float(stretch)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"expected STRETCH or FILE=STRETCH, such as 1.5, got {text}"
        ) from None


def mode_of(text: str) -> tuple[str, str]:
    """(file name, mode of a test of rubber) from the text [FILE=]MODE; without FILE, the name is
    "", which stands for all files.
    """
    from model_lab.measurements.measurement_set import MODES

    file, mode = _of_file(text)
    if mode not in MODES:
        raise argparse.ArgumentTypeError(
            f"expected MODE or FILE=MODE with one of {', '.join(MODES)}, got {text}"
        )
    return file, mode


def name_of_file(text: str) -> tuple[str, str]:
    """(file name, name of its sheet or specimen) from the text [FILE=]NAME; without FILE, the first
    is "", which stands for all files.
    """
    file, name = _of_file(text)
    if not name:
        raise argparse.ArgumentTypeError(f"expected NAME or FILE=NAME, got {text}")
    return file, name


def plate(text: str) -> Plate:
    """The plate of a press from the text FRICTION[,HEIGHT], with the height in m."""
    try:
        friction, height = map(float, text.split(",") if "," in text else (text, "0"))
    except ValueError:
        friction, height = math.nan, 0.0
    if not (0.0 < friction <= LARGEST_FRICTION and math.isfinite(height)):
        raise argparse.ArgumentTypeError(
            f"expected FRICTION[,HEIGHT], friction above 0 and at most {LARGEST_FRICTION:g}, "
            f"got {text}"
        )
    return Plate(friction, height)


def touched(arguments: argparse.Namespace) -> Grasped | Plate | None:
    """What the hand of a press or grasp touches, as stated; raises ValueError for both at once."""
    what, scene, level = arguments.object, arguments.scene, arguments.plate
    if (what and level) or (scene and not what):
        got = "--object and --plate" if what else "--scene without --object"
        raise ValueError(
            "--object, --scene, --plate: expected --object NAME (with --scene NAME, if it is not "
            f"the usual scene), or --plate FRICTION, got {got}"
        )
    return Grasped(what, scene or Grasped.scene) if what else level


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
    help="seed of all random draws (default: %(default)s)",
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
    """Load the measurement set that the arguments name."""
    with Progress("reading") as progress:
        return load_measurements(arguments.data, progress)


def model(arguments: argparse.Namespace) -> Model:
    """Load the model that the arguments name, with the paths of the user's own effects in it."""
    return named_model(arguments, arguments.model)


def named_model(arguments: argparse.Namespace, name: str) -> Model:
    """Load a model by its file or shipped name. Effects of the user's own that are in it need no
    file there if `--effects` gives it.
    """
    found = load_model(name, own_classes(arguments.effects), arguments.allow_effect_files)
    found = replace(found, free_modulus=found.free_modulus or arguments.free_modulus)
    named = {effect.name for effect in found.effects}
    own = {key: path for key, path in file_of_each(arguments.effects).items() if key in named}
    return replace(found, files={**found.files, **own})


def given(
    arguments: argparse.Namespace,
) -> tuple[Model, dict[str, type[Effect]], MeasurementSet]:
    """(model, effect classes by name, measurement set) that the arguments name."""
    known, data = of_set(arguments)
    return known, all_classes(known, arguments.effects), data


def of_set(arguments: argparse.Namespace) -> tuple[Model, MeasurementSet]:
    """(model, measurement set) that the arguments name. For a hand, the model gets the effect
    `gravity` if it has none, and a printed line says so.
    """
    known, data = model(arguments), measurements(arguments)
    fitting = with_weight(data, known)
    if fitting is not known:
        print(f"{arguments.model} has no weight: the hand's weight is added (effect gravity)")
    return fitting, data


def check_json(arguments: argparse.Namespace) -> None:
    """Check, before any work, that the JSON file of the result can be written; raises ValueError if
    not.
    """
    if arguments.json is not None:
        check_new(arguments.json, arguments.force)


def save_json(arguments: argparse.Namespace, content: dict[str, Any]) -> None:
    """Write the result as JSON if the arguments name a file for it."""
    if arguments.json is not None:
        write_json(arguments.json, content, arguments.force)
