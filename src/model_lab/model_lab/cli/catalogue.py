"""The commands of `model-lab`: what each is for, its arguments, and the function that does it."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from model_lab.cli import commands, options
from model_lab.cli.options import Argument, argument

NOISE = 0.006  # of synthesised sets


@dataclass(frozen=True)
class Command:
    """One command of `model-lab`.

    help: one line. description: longer text. examples: shell lines. arguments: in the order of the
    help. run: the function that does the work, given the parsed arguments.
    """

    help: str
    description: str
    examples: tuple[str, ...]
    arguments: tuple[Argument, ...]
    run: Callable[[argparse.Namespace], None]


COMMANDS: Mapping[str, Command] = {
    "import": Command(
        "make a set of files as you have them",
        "Make a measurement set of CSV or text files in any dialect, spreadsheets, MAT files and "
        "bags. Columns "
        "are recognised by their names (English, German, French) and units; what is not certain "
        "is asked, or without a terminal named in one line. Of two files of one run, one has the "
        "input and one the output, each with its own times. The set keeps the units of the files "
        "(kPa, psi, deg, N, ...).",
        (
            "model-lab import r1.csv r2.csv -o out/set --hand rbo_hand_2",
            "model-lab import druck.csv winkel.csv -o out/set --map pressure=p:mbar",
            "model-lab import pull.csv -o out/strip --map 'stretch=elongation(Weg,50mm)'"
            " --map 'stress=per_area(Kraft,30mm2)'",
            "model-lab import poses.csv -o out/hand --hand rbo_hand_2 --wrist 0,90,0",
            "model-lab import out/demo/bag -o out/grasp --hand rbo_hand_2 --experiment grasp"
            " --object cylinder",
        ),
        (
            argument(
                "files",
                nargs="+",
                type=Path,
                metavar="FILE",
                help="CSV, TXT, XLSX or MAT files, rosbag2 folders, ROS 1 bags",
            ),
            argument(
                "-o", "--out", type=Path, required=True, metavar="SET", help="folder to write"
            ),
            argument(
                "--experiment",
                metavar="E",
                help="free_bending, blocked_tip, uniaxial, rubber, valve_pulse, base_torque, "
                "hand_pose, hand_motion, press or grasp (default: as columns say; of a hand, "
                "poses)",
            ),
            argument(
                "--map",
                type=options.column_map,
                action="append",
                default=[],
                metavar="NAME=COLUMN[:UNIT]",
                help="which column is time, pressure, tip_angle, tip_force, stretch, strain, "
                "stress or another one of the experiment (p_in, tip_qw, torque_x, ...), and its "
                "unit (of time also a rate, 30Hz); may be given again. The "
                "tip angle may be made of what was tracked: quaternion(X,Y,Z,W), "
                "plane_markers(X1,Y1,X2,Y2), markers(...) in space, tip(X,Y) from the base, or "
                "chord(ANGLE). Of a testing machine stretch=elongation(DISPLACEMENT,50mm) and "
                "stress=per_area(FORCE,30mm2). Of a hand also pressure.CHANNEL, and index_tip or "
                "wrist: the words that its columns share; places=:mm and pressure=:kPa say units "
                "of all",
            ),
            argument(
                "--msgs",
                type=Path,
                metavar="DIR",
                help="definitions PACKAGE/msg/NAME.msg of message types that a bag does not define",
            ),
            argument(
                "--decimal",
                choices=list(options.DECIMAL_SIGNS),
                help="decimal sign of the numbers, where they do not show it",
            ),
            argument(
                "--sheet",
                type=options.name_of_file,
                action="append",
                default=[],
                metavar="[FILE=]SHEET",
                help="sheet of a spreadsheet, where several hold numbers; may be given again",
            ),
            argument(
                "--shift",
                type=options.clock_shift,
                action="append",
                default=[],
                metavar="FILE=SECONDS",
                help="time to add to the clock of a file; may be given again",
            ),
            argument(
                "--hand",
                metavar="HAND[:FINGER]",
                help="hand by name or file, of which a finger was measured; or whose markers "
                "were followed (columns such as index_tip.x), or that is in bags of this suite",
            ),
            argument("--object", help="what was grasped (--experiment grasp), by name or file"),
            argument("--scene", help="where it was grasped (default: table)"),
            argument(
                "--plate",
                type=options.plate,
                metavar="FRICTION[,HEIGHT]",
                help="friction coefficient of the level plate on which a hand was pressed "
                "(--experiment press), and its height in m (0)",
            ),
            argument(
                "--wrist",
                type=options.attitude,
                action="append",
                default=[],
                metavar="[FILE=]R,P,Y",
                help="how the wrist of a hand was held in a file, in those that match a pattern "
                "such as '*_up_*', or in all: roll, pitch, yaw in "
                "degrees (0,0,0: fingers up); may be given again",
            ),
            argument(
                "--specimen",
                type=options.name_of_file,
                action="append",
                default=[],
                metavar="[FILE=]NAME",
                help="name of the specimen of a file, of those that match a pattern such as "
                "'thin_*', or of all (default: as the names of the files say); may be given again",
            ),
            argument(
                "--stretched-to",
                type=options.stretch_before,
                action="append",
                default=[],
                metavar="[FILE=]STRETCH",
                help="largest stretch of the specimen before the run, 1 for none, of a file or of "
                "all; may be given again",
            ),
            argument(
                "--mode",
                type=options.mode_of,
                action="append",
                default=[],
                metavar="[FILE=]MODE",
                help="uniaxial, pure_shear or equibiaxial: how the rubber was stretched in a file "
                "or in all (default: as the names of the files say); may be given again",
            ),
            argument(
                "--split-restarts",
                action="store_true",
                help="begin a new run where the clock of a file begins anew or pauses",
            ),
            argument("--yes", action="store_true", help="ask nothing; take what is certain"),
            argument("--force", action="store_true", help="overwrite files that exist"),
        ),
        commands.import_files,
    ),
    "compare": Command(
        "error of a model, and where it lies",
        "Compare a model with measurements: error over all data and held out, fit in percent, "
        "the noise floor, and where the error lies: against pressure, rate, time, history, "
        "temperature and specimen. Tables show units as at the bench (deg, kPa, mg, N mm); --json "
        "is in SI units.",
        (
            "model-lab compare out/set --model base",
            "model-lab compare out/set --model model.yaml --json after.json",
        ),
        (
            *options.GIVEN,
            *options.RESULTS,
            options.SEED,
        ),
        commands.compare,
    ),
    "diagnose": Command(
        "which physical effect is missing",
        "Search the known effects, and your own, for what the model lacks. Names an effect "
        "only if it removes at least half of the excess error on held-out data; else says "
        "`adequate` or `unexplained`. Errors are shown in deg, kPa, mg or N mm, parameters in the "
        "units of docs/reference/effects.md; --json is in SI units.",
        (
            "model-lab diagnose out/set --model base --report out/report",
            "model-lab diagnose out/set --effects examples/own_effect.py --jobs 2",
        ),
        (
            *options.GIVEN,
            argument(
                "--report",
                type=Path,
                metavar="DIR",
                help=f"folder in which to write {commands.REPORT}; learns the missing curve for it "
                "where nothing known explains the error",
            ),
            *options.RESULTS,
            options.SEED,
            options.JOBS,
        ),
        commands.diagnose,
    ),
    "add": Command(
        "add an effect to the model, fitted to the data",
        "Fit the model together with one more effect and write the model file that simulator, "
        "monitor and lab load. `add discrepancy` adds a generic term, marked as not physics, for "
        "when no known effect explains the error. Units: see docs/reference/effects.md.",
        (
            "model-lab add gent_stiffening --data out/set --model base --out model.yaml",
            "model-lab add discrepancy --data out/set --model base --out working.yaml",
        ),
        (
            argument("effect", metavar="EFFECT", help="name of the effect"),
            argument("--data", type=Path, required=True, metavar="DATA", help="measurements"),
            options.MODEL,
            options.FREE_MODULUS,
            argument(
                "--out", type=Path, required=True, metavar="M2", help="the model file to write"
            ),
            *options.EFFECTS,
            *options.RESULTS,
        ),
        commands.add,
    ),
    "learn": Command(
        "what is missing as a curve, if no known effect fits",
        "Learn what a model lacks as a smooth curve: at which stage it acts (input, load, elastic, "
        "structure, output), as an offset, a factor or a lag, and against what, fitted together "
        "with calibration and effects and judged on held-out data against other stages and axes. "
        "Writes an effect file of your own, in SI units, with the curve as its parameters and a "
        "place for the physics that you see in it; nothing where no curve helps.",
        (
            "model-lab learn out/set --model base --out my_effect.py",
            "model-lab add my_effect --effects my_effect.py --data out/set --model base --out "
            "my_effect.yaml",
        ),
        (
            *options.GIVEN,
            argument(
                "--out", type=Path, required=True, metavar="NAME.py", help="effect file to write"
            ),
            argument(
                "--report",
                type=Path,
                metavar="DIR",
                help=f"folder in which to write {commands.LEARNED_PAGE}",
            ),
            *options.RESULTS,
        ),
        commands.learn,
    ),
    "ladder": Command(
        "the errors of several models, side by side",
        "Compare several models with the same measurements: a row for each, with the noise "
        "floor, the lowest error that a model can reach. Errors are shown in deg, kPa, mg or N "
        "mm; --json is in SI units.",
        ("model-lab ladder out/set base gravity model.yaml",),
        (
            options.DATA,
            argument(
                "models",
                nargs="+",
                metavar="MODEL",
                help="model file, or the name of a shipped one",
            ),
            options.FREE_MODULUS,
            *options.EFFECTS,
            *options.RESULTS,
        ),
        commands.ladder,
    ),
    "plan": Command(
        "the next run, to tell apart effects that fit equally well",
        "Propose the experiment in which the effects that the data cannot tell apart differ "
        "most, within the pressures that the set has seen, by what `diagnose` of the same set, "
        "model and effects has found; without that, diagnose first. With --out it is written "
        "as a template: a CSV file of time [s] and pressure [kPa] to be played, and the part of "
        "experiment.yaml for it. --json is in SI units.",
        (
            "model-lab plan out/set --model base --out out/next",
            "model-lab plan out/set --model model.yaml --json next.json",
        ),
        (
            *options.GIVEN,
            argument(
                "--diagnosis",
                type=Path,
                metavar="FILE",
                help="what `diagnose` wrote: its JSON, or the folder of its report",
            ),
            argument("--out", type=Path, metavar="DIR", help="folder for the run's template"),
            *options.RESULTS,
            options.SEED,
            options.JOBS,
        ),
        commands.plan,
    ),
    "synthesize": Command(
        "make measurements with a hidden effect, to try the lab on",
        "Make a measurement set with the model itself: two repeats of six protocols, with noise. "
        "EXPERIMENT is free_bending, blocked_tip, uniaxial, rubber, valve_pulse, base_torque, "
        "hand_pose, hand_motion, press or grasp. With --hide one effect acts in it, which only "
        "`reveal` tells. CSV files are in the units that experiment.yaml states, such as kPa and "
        "deg.",
        (
            "model-lab synthesize free_bending --hide --seed 3 --out trial",
            "model-lab diagnose trial && model-lab reveal trial",
        ),
        (
            argument("experiment", metavar="EXPERIMENT", help="such as free_bending"),
            argument("--hide", action="store_true", help="add an effect, to be found"),
            argument("--out", type=Path, required=True, metavar="DIR", help="folder to write"),
            argument(
                "--noise",
                type=float,
                default=NOISE,
                metavar="SHARE",
                help="standard deviation of the noise, and of the scatter of whole runs, over the "
                "largest reading (default: %(default)s)",
            ),
            argument(
                "--effects",
                type=Path,
                action="append",
                default=[],
                metavar="FILE",
                help="Python file with effects of your own: one of them is hidden",
            ),
            options.SEED,
            *options.RESULTS,
        ),
        commands.synthesize,
    ),
    "reveal": Command(
        "say what was hidden in synthesised measurements",
        "Say which effect acts in a set that `synthesize --hide` made, in SI units.",
        ("model-lab reveal trial",),
        (
            argument("folder", type=Path, metavar="DIR", help="folder of the set"),
            *options.RESULTS,
        ),
        commands.reveal,
    ),
}
