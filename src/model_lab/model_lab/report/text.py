"""Text and JSON of a diagnosis, of an addition and of a proposed experiment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from model_lab.bench.pose_strategy import PosedRun, pose_strategy
from model_lab.comparison.add import NOT_PHYSICS, Addition
from model_lab.diagnosis.result import ADEQUATE, Diagnosis
from model_lab.measurements.hands import OF_HANDS, PRESSURE_OF, HandSpecimen
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from model_lab.measurements.save import (
    column_entries,
    csv_text,
    run_entry,
    shown_as,
    specimen_entry,
)
from model_lab.measurements.units import display_of
from model_lab.report.floor_sentences import floor_sentence
from model_lab.report.sentences import (
    driving_name,
    effect_words,
    listed,
    notice_sentence,
    story_sentence,
    tie_sentences,
    verdict_sentence,
)
from model_lab.rules import RULES
from softhand_common.documents.output_file import write_files
from softhand_model.effects import effect_classes

ADDITION_FORMAT, PLAN_FORMAT = "softhand-addition/1", "softhand-plan/1"
MOST_RANKED = 8
COURSE, PART, GESTURE = "next.csv", "experiment-part.yaml", "gesture.yaml"
RUN_NAMES, NOT_TURNED = ("next_a", "next_b"), (0.0, 0.0, 0.0)


def text_table(rows: Sequence[Sequence[str]], indent: str = "  ") -> str:
    """A table as text, from rows of cells with the header first. Columns of numbers are aligned to
    the right.

    >>> print(text_table([["run", "error"], ["a", "1.5"], ["b", "10"]]))
      run  error
      a      1.5
      b       10
    """
    columns = [[row[place] for row in rows] for place in range(len(rows[0]))]
    padded = [_padded(column) for column in columns]
    return "\n".join(indent + "  ".join(cells).rstrip() for cells in zip(*padded, strict=True))


def _padded(column: Sequence[str]) -> list[str]:
    width = max(len(cell) for cell in column)
    numbers = all(_is_number(cell) for cell in column[1:]) and len(column) > 1
    return [cell.rjust(width) if numbers else cell.ljust(width) for cell in column]


def _is_number(cell: str) -> bool:
    text = cell.removesuffix("%").strip()
    return (
        not text or text.lstrip("-").replace(".", "", 1).replace("e-", "").isdigit() or text == "-"
    )


def diagnosis_text(diagnosis: Diagnosis) -> str:
    """The text that `diagnose` prints."""
    sections = [
        "\n".join(
            filter(None, [*_said(diagnosis), story_sentence(diagnosis), floor_sentence(diagnosis)])
        ),
        notice_sentence([notice["text"] for notice in diagnosis.notices]),
        _effects(diagnosis),
        detectable_sentence(diagnosis),
        _failures(diagnosis),
        _ranking(diagnosis),
        _not_visible(diagnosis),
        _next_experiment(diagnosis),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def _said(diagnosis: Diagnosis) -> list[str]:
    return [verdict_sentence(diagnosis), *tie_sentences(diagnosis)]


def _effects(diagnosis: Diagnosis) -> str:
    rows = [
        [
            effect.name,
            name,
            f"{e.value:.4g}",
            f"{e.std:.2g}",
            *(f"{end:.4g}" for end in e.interval),
            e.unit,
        ]
        for effect in diagnosis.effects
        for name, e in effect.parameters.items()
    ]
    rows += [
        [
            f"modulus {batch}",
            "G",
            *(f"{1e-3 * number:.4g}" for number in (e.value, e.std, *e.interval)),
            "kPa",
        ]
        for batch, e in (diagnosis.modulus or {}).items()
    ]
    head = ["effect", "parameter", "value", "std", "95 % from", "to", "unit"]
    return text_table([head, *rows]) if rows else ""


def _failures(diagnosis: Diagnosis) -> str:
    rows = [
        [
            f"{100.0 * f.share_of_error:.0f} %",
            f"{f.p_value:.2g}",
            driving_name(f.against, diagnosis.experiment),
            f.where,
        ]
        for f in diagnosis.failures
    ]
    head = ["share of error", "p", "against", "where"]
    return f"Where it fails\n{text_table([head, *rows])}" if rows else ""


def detectable_sentence(diagnosis: Diagnosis) -> str:
    """Which effects of a hand that is adequate would have been found at each place where these data
    can show them: the value of the first parameter at the place where it shows least.
    """
    if (diagnosis.verdict_mended or diagnosis.verdict) != ADEQUATE:
        return ""
    classes = effect_classes()
    least: dict[str, tuple[float, str]] = {}
    for one in diagnosis.detectable:
        kind = classes.get(one.name.partition("[")[0])
        if diagnosis.experiment not in OF_HANDS or kind is None or kind.stage != "hand":
            continue
        parameter = kind.parameters[0]
        idle = parameter.neutral or 0.0
        away = abs(np.log(one.smallest / idle)) if parameter.logarithmic else one.smallest - idle
        found = abs(float(away)), f"{one.smallest:.3g} {parameter.unit}".rstrip()
        least[kind.name] = max(least.get(kind.name, found), found)
    said = [f"{kind} from {shown}" for kind, (_, shown) in least.items()]
    return f"Would have been found: {listed(said)}." if said else ""


def _ranking(diagnosis: Diagnosis) -> str:
    display = diagnosis.display
    rows = [
        [
            entry.name,
            display.number(entry.rmse_heldout),
            f"{entry.delta_bic:.0f}",
            f"{entry.p_value:.2g}",
            "" if entry.plausible else "parameters at a limit, or not known",
        ]
        for entry in diagnosis.ranking[:MOST_RANKED]
    ]
    head = ["effect alone", f"held out [{display.unit}]", "delta BIC", "p", ""]
    return text_table([head, *rows]) if rows else ""


def _not_visible(diagnosis: Diagnosis) -> str:
    rows = [[entry.name, entry.reason] for entry in diagnosis.not_visible]
    return text_table([["not visible", "because"], *rows]) if rows else ""


def _next_experiment(diagnosis: Diagnosis) -> str:
    planned = diagnosis.next_experiment
    return "" if planned is None else proposal_text(planned)


def addition_text(addition: Addition, path: Path) -> str:
    """The text that `add` prints; path: of the model file."""
    display = addition.problem.data.output_display
    before, after = addition.before.held_out.rmse, addition.after.held_out.rmse
    floor = display.shown(addition.problem.floor.total)
    if after < before:
        error = (
            f"The held-out error falls from {display.shown(before)} to {display.shown(after)}; "
            f"the noise floor is {floor}."
        )
    else:
        error = (
            f"The held-out error does not fall: {display.shown(before)} before, "
            f"{display.shown(after)} after; the noise floor is {floor}."
        )
    return f"{path}: added {_added(addition)}\n{error}\n"


def _added(addition: Addition) -> str:
    """The effect with its values; without them for a generic term, where they have no meaning."""
    name = addition.effect.name
    if addition.problem.classes[name].physical:
        return effect_words(addition.effect)
    return f"{name}, {NOT_PHYSICS}: it describes the error of the model, not its cause"


def addition_json(addition: Addition, path: str) -> dict[str, Any]:
    """The dictionary that `add --json` writes, all in SI units; path: of the model file."""
    return {
        "format": ADDITION_FORMAT,
        "model": path,
        "effect": asdict(addition.effect),
        "physical": addition.problem.classes[addition.effect.name].physical,
        "calibration": addition.model.calibration,
        "rmse_before": addition.before.held_out.rmse,
        "rmse_after": addition.after.held_out.rmse,
        "noise_floor": addition.problem.floor.total,
        "unit": addition.problem.data.unit,
    }


def diagnosis_json(diagnosis: Diagnosis, fingerprint: str) -> dict[str, Any]:
    """The dictionary that `diagnose --json` writes, all in SI units, with the verdict in sentences
    under `said`. fingerprint: hash of what was diagnosed.
    """
    return {**diagnosis.as_json(), "said": _said(diagnosis), "fingerprint": fingerprint}


def plan_text(answer: Mapping[str, Any]) -> str:
    """The text that `plan` prints for an answer of `diagnosis_json`."""
    planned = answer["next_experiment"]
    if planned is None:
        return "\n".join([*answer["said"], _nothing(answer)]) + "\n"
    return "\n".join([*answer["said"], "", proposal_text(planned)]) + "\n"


def proposal_text(planned: Mapping[str, Any]) -> str:
    """A proposed experiment (see `Experiment.as_json`) in words, in units of daily use."""
    rows = [["next experiment", ""], *(list(row) for row in _facts(planned))]
    return f"{text_table(rows, indent='')}\n\n{_promise(planned)}"


def plan_json(answer: Mapping[str, Any], files: list[Path]) -> dict[str, Any]:
    """The dictionary that `plan --json` writes for an answer of `diagnosis_json`, all in SI units.
    files: the templates that were written.
    """
    same = ("experiment", "verdict", "next_experiment")
    return {
        "format": PLAN_FORMAT,
        **{name: answer[name] for name in same},
        "tied": [list(names) for names in answer["tied"]],
        "effects": [effect["name"] for effect in answer["effects"]],
        "files": [str(path) for path in files],
    }


def write_template(planned: Mapping[str, Any], data: MeasurementSet, folder: Path) -> list[Path]:
    """Write the input of a proposed experiment as CSV, and the lines for experiment.yaml once it
    has been measured; for a hand also a strategy that plays the experiment twice. Returns the
    paths.

    planned: `next_experiment` of a diagnosis. data: the set that was diagnosed.
    """
    specimen = _specimen(planned, data)
    columns = {name: np.array(values) for name, values in planned["inputs"].items()}
    mode = planned.get("mode", "")
    run = Run(
        "",
        specimen.name,
        planned["protocol"],
        planned["temperature"],
        columns,
        mode=mode,
        wrist_rpy=tuple(planned.get("wrist_rpy", NOT_TURNED)),
    )
    outputs = data.outputs
    entries = column_entries([*columns, *outputs], data.units)
    document: dict[str, Any] = {"columns": entries}
    if specimen.name not in data.specimens:
        document["specimens"] = {specimen.name: specimen_entry(specimen)}
    document["runs"] = {name: run_entry(replace(run, name=name)) for name in RUN_NAMES}
    measured = [f"{name} [{entries[name]['unit']}]" for name in outputs]
    comment = [
        f"To be merged into experiment.yaml once {COURSE} has been played twice and recorded as",
        f"{listed([f'{name}.csv' for name in RUN_NAMES])}, each with the measured columns besides:",
        f"{listed(measured)}.",
    ]
    text = "".join(f"# {line}\n" for line in comment)
    text += yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=120)
    files = {folder / COURSE: csv_text(run, data.units), folder / PART: text}
    if specimen.hand is not None:
        files[folder / GESTURE] = _strategy(run, specimen.hand, data)
    write_files(files)
    return list(files)


def _strategy(run: Run, hand: HandSpecimen, data: MeasurementSet) -> str:
    poses = np.array([run.columns[name] for name in data.pressures]).T
    runs = [PosedRun(name, run.wrist_rpy, list(poses[1:])) for name in RUN_NAMES]  # begins empty
    return pose_strategy(hand.description, hand.stated, "gesture", run.protocol, runs)


def _specimen(planned: Mapping[str, Any], data: MeasurementSet) -> Specimen:
    """The specimen of the set, or the new one that is like its first."""
    name = planned["specimen"]
    if name in data.specimens:
        return data.specimens[name]
    first = data.specimens[data.runs[0].specimen]
    new = {key: planned[key] for key in ("wall", "length") if planned.get(key) is not None}
    values = {**first.values, **new}
    return replace(first, name=name, mount=planned["mount"], values=values)


def _nothing(answer: Mapping[str, Any]) -> str:
    if any(answer["tied"]):
        return "No experiment of the bank can be done with these specimens."
    if answer["verdict"] == ADEQUATE:
        return "No effects are tied: more runs of this kind would only show smaller effects."
    return "No effects are tied: there is no experiment to propose."


def _facts(planned: Mapping[str, Any]) -> list[tuple[str, str]]:
    inputs = planned["inputs"]
    rows = [
        ("protocol", f"{planned['protocol']}: {planned['description']}"),
        ("specimen", planned["specimen"]),
        *([("mount", planned["mount"].replace("_", " "))] if "pressure" in inputs else []),
        ("temperature", display_of("K").shown(planned["temperature"])),
    ]
    if "wrist_rpy" in planned:
        turned = ", ".join(f"{angle:.0f}" for angle in np.degrees(planned["wrist_rpy"]))
        rows.append(("wrist", f"roll, pitch, yaw {turned} deg"))
        peaks = (
            f"{name.removeprefix(PRESSURE_OF)} {shown_as('pressure').shown(max(course))}"
            for name, course in inputs.items()
            if max(course) > 0.0
        )
        rows.append(("peak pressures", listed(list(peaks))))
    if planned["duration"] is not None:
        rows.append(("duration", f"{planned['duration']:.3g} s"))
    if planned["peak"] is not None:
        driving = next(name for name in ("pressure", "stretch") if name in inputs)
        rows.append((f"peak {driving}", shown_as(driving).shown(planned["peak"])))
    if planned["at_rest"]:
        reads = (
            f"{shown_as('pressure').shown(value)} if {name}"
            for name, value in planned["at_rest"].items()
        )
        rows.append(("begin", f"with the chamber open: the gauge reads {listed(list(reads))}"))
    return [*rows, ("what is new", "; ".join(planned["changes"]) or "the protocol alone")]


def _promise(planned: Mapping[str, Any]) -> str:
    groups = "; ".join(listed(names) for names in planned["separates"])
    apart = f"It keeps {groups} {planned['separation']:.2g} sigma of the noise of a run apart"
    apart += f" ({planned['floors']:.2g} noise floors)"
    if planned["breaks"]:
        return f"{apart}, and so tells them apart. Repeat this run once."
    if planned["separation"] >= RULES.separation_breaks:
        return (
            f"{apart}. Yet they may stay tied: the true equation may be of a form near to all "
            "of them."
        )
    return (
        f"{apart}, which is too little to tell them apart reliably ({RULES.separation_breaks:g} "
        "break a tie): within these limits they do not differ more."
    )
