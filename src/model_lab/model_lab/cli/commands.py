"""What each command of `model-lab` does; `catalogue` has their arguments and help.

What a command computes with is imported when it runs, so that `--help` comes at once.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from model_lab.cli import options
from model_lab.own_effects import file_of_each, own_classes
from softhand_common.documents.yaml_document import DocumentError
from softhand_common.progress import Progress

if TYPE_CHECKING:
    from model_lab.importing.importing import ImportedSet
    from model_lab.importing.told import Said

REPORT, LEARNED_PAGE = "report.html", "learned.html"


def import_files(arguments: argparse.Namespace) -> None:
    """Propose what each column means, ask the user what is still open, and write the measurement
    set.
    """
    import sys

    from model_lab.importing import told
    from model_lab.importing.hand_sets import set_of_hand
    from model_lab.importing.importing import make_set, propose
    from model_lab.measurements.save import check_folder
    from model_lab.report.text import text_table

    check_folder(arguments.out, arguments.force)
    maps, shifts, sheets, specimens = (
        _once(f"--{name}", getattr(arguments, name))
        for name in ("map", "shift", "sheet", "specimen")
    )
    given = (arguments.msgs, options.DECIMAL_SIGNS.get(arguments.decimal, ""), sheets)
    stretched_to, held, modes = (
        _once(f"--{name}", getattr(arguments, name.replace("-", "_")))
        for name in ("stretched-to", "wrist", "mode")
    )
    parting = (modes, arguments.split_restarts)
    touched = options.touched(arguments)
    files, experiment, hand = arguments.files, arguments.experiment, arguments.hand
    said = told.Said(
        experiment,
        maps,
        hand,
        shifts,
        arguments.msgs,
        arguments.decimal,
        specimens,
        stretched_to,
        sheets,
        held,
        *parting,
        touched,
    )
    with Progress("reading") as progress:
        progress("the files", 0, 0)
        of_hand = set_of_hand(files, hand, experiment, maps, shifts, *given, held, touched)
        proposal = of_hand[1] if of_hand else propose(files, experiment, maps, *given, *parting)
    if of_hand and any(parting):
        raise DocumentError(
            "--mode, --split-restarts: expected measurements of one actuator or of rubber, got "
            f"those of a whole hand (--hand {hand}); leave the option out"
        )
    if proposal.sources:
        print(text_table(told.table_rows(proposal)))
    if of_hand:
        _write_imported(of_hand[0], str(proposal.experiment), arguments, said)
        return
    if proposal.unsure and not arguments.yes and sys.stdin.isatty():
        maps = told.asked(proposal, maps, input)
        proposal = propose(arguments.files, arguments.experiment, maps, *given, *parting)
    found = make_set(proposal, hand, shifts, "", specimens, stretched_to)
    said = replace(said, maps=maps)
    _write_imported(found, str(proposal.experiment), arguments, said)


def _once(option: str, pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """What an option says of files or quantities; raises DocumentError if it is said twice of one
    ("": of all).
    """
    said: dict[str, Any] = {}
    for name, value in pairs:
        if name in said:
            raise DocumentError(
                f"{option}: expected {name or 'all files'} once, got this twice; remove one"
            )
        said[name] = value
    return said


def _write_imported(
    found: ImportedSet, experiment: str, arguments: argparse.Namespace, said: Said
) -> None:
    from model_lab.importing.told import again
    from model_lab.report.sentences import counted

    found.write(arguments.out)
    print(f"\n{experiment}, {counted(len(found.runs), 'run')}; written: {arguments.out}")
    for remark in found.remarks:
        print(f"note: {remark}")
    print(f"\nThe same again:\n  {again(arguments.files, arguments.out, said)}")
    linear = "" if found.sized else " --model linear"
    _print_next([f"model-lab {what} {arguments.out}{linear}" for what in ("compare", "diagnose")])


def compare(arguments: argparse.Namespace) -> None:
    """Compare the model with the measurements, print the result, and write JSON if asked for."""
    from model_lab.comparison.compare import compare
    from model_lab.report.comparison_text import comparison_json, comparison_text

    options.check_json(arguments)
    model, data = options.of_set(arguments)
    with Progress("comparing") as progress:
        found = compare(data, model, arguments.seed, progress)
    print(comparison_text(found, arguments.model), end="")
    options.save_json(arguments, comparison_json(found, arguments.model))


def diagnose(arguments: argparse.Namespace) -> None:
    """Diagnose the model, print the verdict, and write JSON and report if asked for."""
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
    single = len(data.outputs) == 1  # from which a curve can be learned
    following = lines.after_diagnosis(arguments, outcome.diagnosis, single)
    _print_next(following)
    answer = diagnosis_json(outcome.diagnosis, answers.fingerprint(arguments, model, data))
    answers.keep(answer)
    options.save_json(arguments, answer)
    if arguments.report is not None:
        from model_lab.report.page import write_report

        write_json(arguments.report / answers.ANSWER, answer, arguments.force)

        learned = None
        if outcome.diagnosis.verdict == UNEXPLAINED and single:
            from model_lab.learning.learn import learn as learn_curve

            with Progress("learning") as progress:
                learned = learn_curve(data, model, classes, progress)
        commands = [lines.diagnosed_again(arguments), *following]
        write_report(outcome, arguments.report / REPORT, commands, learned)


def _print_next(following: Sequence[str]) -> None:
    if following:
        print("\nNext:", *following, sep="\n  ")


def add(arguments: argparse.Namespace) -> None:
    """Fit the model with the effect, print the result, and write the model file, and JSON if asked
    for.
    """
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
    """Learn the missing curve, print it, and write the effect file, and JSON and report if asked
    for.
    """
    from model_lab.cli import lines
    from model_lab.learning import effect_file, words
    from model_lab.learning.learn import learn
    from model_lab.learning.result import learning_json
    from model_lab.report.sentences import learned_sentences
    from model_lab.report.text import text_table
    from softhand_common.documents.output_file import check_new, write_new

    options.check_json(arguments)
    effect_file.check_name(arguments.out, arguments.force)
    if arguments.report is not None:
        check_new(arguments.report / LEARNED_PAGE, arguments.force)
    model, classes, data = options.given(arguments)
    with Progress("learning") as progress:
        found = learn(data, model, classes, progress)
    print(f"{learned_sentences(found)}\n\n{text_table(words.alternative_rows(found))}")
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
        from model_lab.report.page import write_learned

        write_learned(found, arguments.report, lines.learned_again(arguments))


def ladder(arguments: argparse.Namespace) -> None:
    """Compare the models, print their errors, and write JSON if asked for."""
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
    """Take the kept answer of `diagnose`, or diagnose; print which experiment to do next, and write
    a template for it, and JSON if asked for.
    """
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
    """Simulate a measurement set and write it."""
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
    print(f"{arguments.out}: {made.data.title}, {runs} runs; `reveal` tells what is hidden")
    content = {"format": "softhand-synthesis/1", "experiment": experiment}
    options.save_json(arguments, {**content, "folder": str(arguments.out), "runs": runs})


def reveal(arguments: argparse.Namespace) -> None:
    """Print which effect was hidden in a synthesised set."""
    from model_lab.bench.synthesize import open_seal

    options.check_json(arguments)
    truth = open_seal(arguments.folder)
    for effect in truth["effects"]:
        values = ", ".join(f"{name} = {value:.4g}" for name, value in effect["parameters"].items())
        place = ", ".join(f"{key} {name}" for key, name in effect.get("where", {}).items())
        name = f"{effect['name']}, {place}" if place else effect["name"]
        print(f"hidden: {name} ({values})" if values else f"hidden: {name}")
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
