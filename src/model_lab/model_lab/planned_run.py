"""What `plan` says of the next experiment, and the run template that it writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from model_lab.diagnosis import ADEQUATE, Diagnosis
from model_lab.display import display_of
from model_lab.measurement import OUTPUTS, MeasurementSet, Run, Specimen
from model_lab.plan import BREAKS
from model_lab.report.sentence import listed, tie_sentences, verdict_sentence
from model_lab.set_writing import column_entries, run_entry, shown_as, specimen_entry, write_csv
from model_lab.text_table import text_table

FORMAT = "softhand-plan/1"
COURSE, PART = "next.csv", "experiment-part.yaml"
REPEATS = ("next_a", "next_b")


def plan_text(diagnosis: Diagnosis) -> str:
    """What is printed."""
    said = [verdict_sentence(diagnosis), *tie_sentences(diagnosis)]
    if diagnosis.next_experiment is None:
        return "\n".join([*said, _nothing(diagnosis)]) + "\n"
    return "\n".join([*said, "", proposal_text(diagnosis.next_experiment)]) + "\n"


def proposal_text(planned: Mapping[str, Any]) -> str:
    """A proposed experiment, as `Experiment.as_json` gives it, in the units of the bench."""
    rows = [["next experiment", ""], *(list(row) for row in _facts(planned))]
    return f"{text_table(rows, indent='')}\n\n{_promise(planned)}"


def plan_json(diagnosis: Diagnosis, files: list[Path]) -> dict[str, Any]:
    """What `--json` writes; all in SI units."""
    return {
        "format": FORMAT,
        "experiment": diagnosis.experiment,
        "verdict": diagnosis.verdict,
        "effects": [effect.name for effect in diagnosis.effects],
        "tied": [list(names) for names in diagnosis.tied],
        "next_experiment": diagnosis.next_experiment,
        "files": [str(path) for path in files],
    }


def write_template(planned: Mapping[str, Any], data: MeasurementSet, folder: Path) -> list[Path]:
    """Write the course of the inputs, and what experiment.yaml gets when it has been measured.

    planned: `next_experiment` of a diagnosis. The folder must exist. Returns the files.
    """
    specimen = _specimen(planned, data)
    columns = {name: np.array(values) for name, values in planned["inputs"].items()}
    run = Run("", specimen.name, planned["protocol"], planned["temperature"], columns)
    write_csv(run, folder / COURSE)
    outputs = OUTPUTS[data.experiment]
    entries = column_entries([*columns, *outputs])
    document: dict[str, Any] = {"columns": entries}
    if specimen.name not in data.specimens:
        document["specimens"] = {specimen.name: specimen_entry(specimen)}
    document["runs"] = {name: run_entry(replace(run, name=name)) for name in REPEATS}
    measured = [f"{name} [{entries[name]['unit']}]" for name in outputs]
    comment = [
        f"To be merged into experiment.yaml once {COURSE} has been played twice and recorded as",
        f"{listed([f'{name}.csv' for name in REPEATS])}, each with the measured columns besides:",
        f"{listed(measured)}.",
    ]
    text = "".join(f"# {line}\n" for line in comment)
    text += yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=120)
    (folder / PART).write_text(text, encoding="utf-8")
    return [folder / COURSE, folder / PART]


def _specimen(planned: Mapping[str, Any], data: MeasurementSet) -> Specimen:
    """The specimen of the set, or the new one that is like its first."""
    name = planned["specimen"]
    if name in data.specimens:
        return data.specimens[name]
    first = data.specimens[data.runs[0].specimen]
    values = {**first.values, "wall": planned["wall"]}
    return replace(first, name=name, mount=planned["mount"], values=values)


def _nothing(diagnosis: Diagnosis) -> str:
    if any(diagnosis.tied):
        return "No experiment of the bank can be done with these specimens."
    if diagnosis.verdict == ADEQUATE:
        return "Nothing is tied: more of the same runs would only show smaller effects."
    return "Nothing is tied: there is no experiment to propose."


def _facts(planned: Mapping[str, Any]) -> list[tuple[str, str]]:
    inputs = planned["inputs"]
    rows = [
        ("protocol", f"{planned['protocol']}: {planned['description']}"),
        ("specimen", planned["specimen"]),
        *([("mount", planned["mount"].replace("_", " "))] if "pressure" in inputs else []),
        ("temperature", display_of("K").shown(planned["temperature"])),
    ]
    if planned["duration"] is not None:
        rows.append(("duration", f"{planned['duration']:.3g} s"))
    if planned["peak"] is not None:
        driving = next(name for name in ("pressure", "stretch") if name in inputs)
        rows.append((f"peak {driving}", shown_as(driving).shown(planned["peak"])))
    return [*rows, ("what is new", "; ".join(planned["changes"]) or "the protocol alone")]


def _promise(planned: Mapping[str, Any]) -> str:
    groups = "; ".join(listed(names) for names in planned["separates"])
    apart = f"It keeps {groups} {planned['separation']:.2g} sigma of the noise of a run apart"
    if planned["breaks"]:
        return f"{apart}, and so breaks the tie. Do it twice."
    return (
        f"{apart}, which is too little to rely on ({BREAKS:g} break a tie): within these limits "
        "they do not differ more."
    )
