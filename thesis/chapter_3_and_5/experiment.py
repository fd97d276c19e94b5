"""What an experiment is, its folder and its figure.

The folder of one experiment: results.json, verdict.txt and figure.png.

The figure of an experiment; needs matplotlib.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Results = dict[str, Any]
"""What was simulated: numbers, lists and dicts of them, as they go to JSON; SI units, angles in
radians, keys that say what they hold.
"""


@dataclass(frozen=True)
class Finding:
    """One row of a report: what is looked at, what the thesis found, what was found here, and
    whether it meets its target (None: there is no target).
    """

    what: str
    thesis: str
    ours: str
    met: bool | None = None

    @classmethod
    def at_most(cls, what: str, thesis: str, value: float, limit: float, unit: str) -> Finding:
        """A figure that must not exceed its limit, both in the unit.

        >>> Finding.at_most("tip angle", "-", 0.0421, 0.1, "%").ours
        '0.042 % (<= 0.1)'
        """
        return cls(what, thesis, f"{value:.2g} {unit} (<= {limit:g})", bool(value <= limit))


@dataclass(frozen=True)
class Experiment:
    """One experiment.

    name: of the command and of the folder; title: one line that says what is done, with the figures
    of the thesis. simulate makes the results, which are all that report and draw see; conclude says
    in one sentence what came out.
    """

    name: str
    title: str
    simulate: Callable[[], Results]
    report: Callable[[Results], list[Finding]]
    conclude: Callable[[Results], str]
    draw: Callable[[Figure, Results], None]
    size: tuple[float, float] = (8.0, 4.0)  # of the figure [in]


def table(findings: Sequence[Finding]) -> str:
    """A report as a table in Markdown.

    >>> print(table([Finding("tip angle", "143 deg", "143.5 deg", True)]))
    | what | thesis | here | met |
    | --- | --- | --- | --- |
    | tip angle | 143 deg | 143.5 deg | yes |
    """
    words = {True: "yes", False: "NO", None: "-"}
    rows = [(row.what, row.thesis, row.ours, words[row.met]) for row in findings]
    lines = [("what", "thesis", "here", "met"), ("---",) * 4, *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def verdict(findings: Sequence[Finding], conclusion: str) -> str:
    """One line: how many targets were met, and what came out.

    >>> verdict([Finding("a", "-", "1", True), Finding("b", "-", "2")], "It holds.")
    'holds (1 of 1 targets met). It holds.'
    """
    judged = [finding.met for finding in findings if finding.met is not None]
    word = "holds" if all(judged) else "falls short"
    return f"{word} ({sum(judged)} of {len(judged)} targets met). {conclusion}"


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


DPI = 130


def write_figure(experiment: Experiment, results: Results, path: Path) -> None:
    """Draw the results into a PNG file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure = Figure(figsize=experiment.size, layout="constrained")
    experiment.draw(figure, results)
    figure.savefig(path, dpi=DPI)
