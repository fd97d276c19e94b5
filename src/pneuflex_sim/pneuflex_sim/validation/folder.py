"""The folder of one experiment: results.json, verdict.txt and figure.png."""

from __future__ import annotations

import json
from pathlib import Path

from pneuflex_sim.validation.experiment import Experiment, Results, table, verdict

RESULTS, VERDICT, FIGURE = "results.json", "verdict.txt", "figure.png"


class EarlierRunError(ValueError):
    """A folder lacks the earlier run that is asked for, or holds one that must not be lost."""


def write_results(experiment: Experiment, results: Results, folder: Path) -> None:
    """Write what was simulated."""
    folder.mkdir(parents=True, exist_ok=True)
    content = {"experiment": experiment.name, "title": experiment.title, "results": results}
    (folder / RESULTS).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def read_results(experiment: Experiment, folder: Path) -> Results:
    """What was simulated before; raises EarlierRunError naming the file, expected
    and got."""
    path = folder / RESULTS
    if not path.exists():
        raise EarlierRunError(f"{path}: expected the results of an earlier run, got no such file")
    content = json.loads(path.read_text(encoding="utf-8"))
    if content.get("experiment") != experiment.name:
        raise EarlierRunError(
            f"{path}: experiment: expected {experiment.name}, got {content.get('experiment')}"
        )
    return content["results"]


def write_report(experiment: Experiment, results: Results, folder: Path) -> str:
    """Write the verdict; the table of findings and the verdict as text."""
    findings = experiment.report(results)
    line = verdict(findings, experiment.conclude(results))
    (folder / VERDICT).write_text(line + "\n", encoding="utf-8")
    return f"{table(findings)}\n\nVerdict: {line}"
