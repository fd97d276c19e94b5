"""The commands of `model-lab`: what each is for, its arguments, and what it does.

What a command computes with is imported when it runs, so that `--help` comes at once.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from model_lab.cli import options
from model_lab.cli.options import Argument, argument
from model_lab.own_effects import file_of_each, own_classes
from softhand_common.progress import Progress

REPORT, LEARNED_PAGE = "report.html", "learned.html"
NOISE = 0.006  # of synthesised sets


@dataclass(frozen=True)
class Command:
    """One command: its help, a longer description, examples, arguments in order, and its work."""

    help: str
    description: str
    examples: tuple[str, ...]
    arguments: tuple[Argument, ...]
    run: Callable[[argparse.Namespace], None]


def import_files(arguments: argparse.Namespace) -> None:
    """Propose what the columns are, ask what is open, and write the set."""
    import sys

    from model_lab.importing import told
    from model_lab.importing.importing import make_set, propose
    from model_lab.measurements.save import check_folder
    from model_lab.report.sentences import counted
    from model_lab.report.text import text_table

    check_folder(arguments.out, arguments.force)
    maps, shifts = dict(arguments.map), dict(arguments.shift)
    given = (arguments.msgs, options.DECIMAL_SIGNS.get(arguments.decimal, ""))
    with Progress("reading") as progress:
        progress("the files", 0, 0)
        proposal = propose(arguments.files, arguments.experiment, maps, *given)
    print(text_table(told.table_rows(proposal)))
    if proposal.unsure and not arguments.yes and sys.stdin.isatty():
        maps = told.asked(proposal, maps, input)
        proposal = propose(arguments.files, arguments.experiment, maps, *given)
    stretched_to = dict(arguments.stretched_to)
    found = make_set(
        proposal,
        arguments.hand,
        shifts,
        specimen=arguments.specimen,
        stretched_to=stretched_to,
    )
    found.write(arguments.out)
    said = told.Said(
        arguments.experiment,
        maps,
        arguments.hand,
        shifts,
        arguments.msgs,
        arguments.decimal,
        arguments.specimen,
        stretched_to,
    )
    print(f"\n{proposal.experiment}, {counted(len(found.runs), 'run')}; written: {arguments.out}")
    for remark in found.remarks:
        print(f"note: {remark}")
    print(f"\nThe same again:\n  {told.again(arguments.files, arguments.out, said)}")
    _print_next([f"model-lab compare {arguments.out}", f"model-lab diagnose {arguments.out}"])


def compare(arguments: argparse.Namespace) -> None:
    """Compare, print, and write the JSON."""
    from model_lab.comparison.compare import compare
    from model_lab.report.comparison_text import comparison_json, comparison_text

    options.check_json(arguments)
    model = options.model(arguments)
    data = options.measurements(arguments)
    with Progress("comparing") as progress:
        found = compare(data, model, arguments.seed, progress)
    print(comparison_text(found, arguments.model), end="")
    options.save_json(arguments, comparison_json(found, arguments.model))


def diagnose(arguments: argparse.Namespace) -> None:
    """Diagnose, print the verdict, and write JSON and report."""
    from model_lab.cli import answers, lines
    from model_lab.diagnosis.diagnose import diagnose
    from model_lab.diagnosis.result import UNEXPLAINED
    from model_lab.report.first_look_text import first_look_line
    from model_lab.report.text import diagnosis_json, diagnosis_text
    from softhand_common.documents.output_file import check_new, write_json

    options.check_json(arguments)
    if arguments.report is not None:
        check_new(arguments.report / REPORT, arguments.force)
        check_new(arguments.report / answers.ANSWER, arguments.force)
    model, classes, data = options.given(arguments)
    with Progress("diagnosing") as progress:
        outcome = diagnose(
            data,
            model,
            classes,
            arguments.seed,
            arguments.jobs,
            progress,
            lambda found: progress.say(first_look_line(found, data.output_display)),
        )
    print(diagnosis_text(outcome.diagnosis), end="")
    following = lines.after_diagnosis(arguments, outcome.diagnosis)
    _print_next(following)
    answer = diagnosis_json(outcome.diagnosis, answers.fingerprint(arguments, model, data))
    answers.keep(answer)
    options.save_json(arguments, answer)
    if arguments.report is not None:
        from model_lab.report import write_report

        write_json(arguments.report / answers.ANSWER, answer, arguments.force)

        learned = None
        if outcome.diagnosis.verdict == UNEXPLAINED:
            from model_lab.learning.learn import learn as learn_curve

            with Progress("learning") as progress:
                learned = learn_curve(data, model, classes, progress)
        commands = [lines.diagnosed_again(arguments), *following]
        write_report(outcome, arguments.report / REPORT, commands, learned)


def _print_next(following: Sequence[str]) -> None:
    if following:
        print("\nNext:", *following, sep="\n  ")


def add(arguments: argparse.Namespace) -> None:
    """Fit, print what was found, and write the model file and the JSON."""
    from model_lab.comparison.add import add_effect, check_model_file, write_model
    from model_lab.report.text import addition_json, addition_text

    options.check_json(arguments)
    check_model_file(arguments.out, arguments.force)
    model, classes, data = options.given(arguments)
    with Progress("adding") as progress:
        addition = add_effect(arguments.effect, data, model, classes, progress)
    known = {effect.name for effect in addition.model.effects}
    own = {name: path for name, path in file_of_each(arguments.effects).items() if name in known}
    written = replace(addition.model, files={**model.files, **own})
    fitted_to = data.title or data.experiment
    comment = f"{arguments.effect} added to {arguments.model}, fitted to {fitted_to}"
    write_model(arguments.out, written, comment, arguments.force)
    print(addition_text(addition, arguments.out), end="")
    options.save_json(arguments, addition_json(addition, str(arguments.out)))


def learn(arguments: argparse.Namespace) -> None:
    """Learn, print, and write the effect file, the JSON and the report."""
    from model_lab.cli import lines
    from model_lab.learning import effect_file, words
    from model_lab.learning.learn import learn
    from model_lab.learning.result import learning_json
    from model_lab.report.text import text_table
    from softhand_common.documents.output_file import check_new, write_new

    options.check_json(arguments)
    effect_file.check_name(arguments.out, arguments.force)
    if arguments.report is not None:
        check_new(arguments.report / LEARNED_PAGE, arguments.force)
    model, classes, data = options.given(arguments)
    with Progress("learning") as progress:
        found = learn(data, model, classes, progress)
    print(f"{words.verdict(found)}\n\n{text_table(words.alternative_rows(found))}")
    files = effect_file.files_of(arguments.out)[: len(found.curves)]
    for curve, file in zip(found.curves, files, strict=True):
        origin = f" from {data.title or data.experiment}"
        values, spread = curve.values.tolist(), curve.spread.tolist()
        text = effect_file.text_of(curve.shape, file.stem, values, spread, origin)
        write_new(file, text, arguments.force)
        print(f"\n{text_table(words.curve_rows(curve))}\n\nWritten: {file}.")
    _print_next(lines.after_learning(arguments, files))
    options.save_json(arguments, learning_json(found))
    if arguments.report is not None:
        from model_lab.report import write_learned

        write_learned(found, arguments.report, lines.learned_again(arguments))


def ladder(arguments: argparse.Namespace) -> None:
    """Compare the models, print the rungs, and write the JSON."""
    from model_lab.comparison.ladder import compare_models
    from model_lab.report.comparison_text import ladder_json, ladder_text

    options.check_json(arguments)
    models = {name: options.named_model(arguments, name) for name in arguments.models}
    data = options.measurements(arguments)
    with Progress("comparing") as progress:
        ladder = compare_models(data, models, progress)
    print(ladder_text(ladder), end="")
    options.save_json(arguments, ladder_json(ladder))


def plan(arguments: argparse.Namespace) -> None:
    """Take what `diagnose` found, or diagnose; print what to do next, write template and JSON."""
    from model_lab.cli import answers
    from model_lab.diagnosis.diagnose import diagnose
    from model_lab.measurements.save import check_folder
    from model_lab.report.text import diagnosis_json, plan_json, plan_text, write_template

    options.check_json(arguments)
    if arguments.out is not None:
        check_folder(arguments.out, arguments.force)
    model, classes, data = options.given(arguments)
    fingerprint = answers.fingerprint(arguments, model, data)
    answer = answers.kept(arguments.diagnosis, fingerprint)
    if answer is None:
        with Progress("diagnosing and planning") as progress:
            outcome = diagnose(data, model, classes, arguments.seed, arguments.jobs, progress)
        answer = diagnosis_json(outcome.diagnosis, fingerprint)
        answers.keep(answer)
    files, planned = [], answer["next_experiment"]
    print(plan_text(answer), end="")
    if planned is not None and arguments.out is not None:
        files = write_template(planned, data, arguments.out)
        print(f"Written: {', '.join(map(str, files))}")
    options.save_json(arguments, plan_json(answer, files))


def synthesize(arguments: argparse.Namespace) -> None:
    """Make the set and write it."""
    from model_lab.bench.synthesize import synthesize, write_synthesised
    from model_lab.measurements.save import check_folder

    options.check_json(arguments)
    check_folder(arguments.out, arguments.force)
    own = own_classes(arguments.effects) or None
    experiment = arguments.experiment
    with Progress("measuring") as progress:
        made = synthesize(
            experiment, arguments.seed, arguments.hide, own, arguments.noise, progress
        )
    write_synthesised(made, arguments.out, arguments.force)
    runs = len(made.data.runs)
    print(f"{arguments.out}: {made.data.title}, {runs} runs; the truth is sealed")
    content = {"format": "softhand-synthesis/1", "experiment": experiment}
    options.save_json(arguments, {**content, "folder": str(arguments.out), "runs": runs})


def reveal(arguments: argparse.Namespace) -> None:
    """Open the seal and print what is in it."""
    from model_lab.bench.synthesize import open_seal

    options.check_json(arguments)
    truth = open_seal(arguments.folder)
    for effect in truth["effects"]:
        values = ", ".join(f"{name} = {value:.4g}" for name, value in effect["parameters"].items())
        print(f"hidden: {effect['name']} ({values})" if values else f"hidden: {effect['name']}")
    if not truth["effects"]:
        print("hidden: nothing")
    print(f"calibration (SI units): {_calibration(truth['calibration'])}")
    print(f"noise, one sigma (SI units): {truth['noise']:.3g}")
    options.save_json(arguments, {"format": "softhand-truth/1", **truth})


def _calibration(entries: Mapping[str, Any]) -> str:
    """Numbers of a calibration, by name and batch or alone."""
    return ", ".join(
        f"{name} {_calibration(entry)}" if isinstance(entry, Mapping) else f"{name} {entry:.4g}"
        for name, entry in entries.items()
    )


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
                help="free_bending, blocked_tip or uniaxial (default: as the columns say)",
            ),
            argument(
                "--map",
                type=options.column_map,
                action="append",
                default=[],
                metavar="NAME=COLUMN[:UNIT]",
                help="which column is time, pressure, tip_angle, tip_force, stretch, strain or "
                "stress, and its unit (of time also a rate, 30Hz); may be given again. The "
                "tip angle may be made of what was tracked: quaternion(X,Y,Z,W), "
                "plane_markers(X1,Y1,X2,Y2), markers(...) in space, tip(X,Y) from the base, or "
                "chord(ANGLE)",
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
                help="hand by name or file, of which a finger was measured",
            ),
            argument(
                "--specimen",
                metavar="NAME",
                help="name of the specimen of all runs (default: as the names of the files say)",
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
            argument("--yes", action="store_true", help="ask nothing; take what is certain"),
            argument("--force", action="store_true", help="overwrite files that exist"),
        ),
        import_files,
    ),
    "compare": Command(
        "how far a model is off, and where",
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
        compare,
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
                help=f"folder in which to write {REPORT}; learns the missing curve for it where "
                "nothing known explains the error",
            ),
            *options.RESULTS,
            options.SEED,
            options.JOBS,
        ),
        diagnose,
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
        add,
    ),
    "learn": Command(
        "the curve that is missing, where no known effect fits",
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
                help=f"folder in which to write {LEARNED_PAGE}",
            ),
            *options.RESULTS,
        ),
        learn,
    ),
    "ladder": Command(
        "the errors of several models, side by side",
        "Compare several models with the same measurements: one rung for each, with the noise "
        "floor below which no model can go. Errors are shown in deg, kPa, mg or N mm; --json is in "
        "SI units.",
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
        ladder,
    ),
    "plan": Command(
        "the next experiment, which would separate what is still tied",
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
        plan,
    ),
    "synthesize": Command(
        "make measurements with a hidden effect, to try the lab on",
        "Make a measurement set with the model itself: two repeats of six protocols, with noise. "
        "EXPERIMENT is free_bending, blocked_tip, uniaxial, rubber, valve_pulse or base_torque. "
        "With --hide one effect acts in it that is sealed in the folder, and only `reveal` opens "
        "the seal. CSV files are in the units that experiment.yaml states, such as kPa and deg.",
        (
            "model-lab synthesize free_bending --hide --seed 3 --out trial",
            "model-lab diagnose trial && model-lab reveal trial",
        ),
        (
            argument("experiment", metavar="EXPERIMENT", help="such as free_bending"),
            argument("--hide", action="store_true", help="hide an effect in it"),
            argument("--out", type=Path, required=True, metavar="DIR", help="folder to write"),
            argument(
                "--noise",
                type=float,
                default=NOISE,
                metavar="SHARE",
                help="one sigma over the largest reading, and scatter of whole runs "
                "(default: %(default)s)",
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
        synthesize,
    ),
    "reveal": Command(
        "say what was hidden in synthesised measurements",
        "Open the seal of a set that `synthesize --hide` made, and say what acts in it, in SI "
        "units.",
        ("model-lab reveal trial",),
        (
            argument("folder", type=Path, metavar="DIR", help="folder of the set"),
            *options.RESULTS,
        ),
        reveal,
    ),
}
