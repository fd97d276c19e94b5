"""Frame of the thesis's experiments: parameters, run, report, figure and result folder.

An experiment is one module NAME.py in the folder of a chapter. It has

    its docstring         the first line is its title
    Parameters            frozen dataclass of `option`s, each with its unit; with a method
                          `continued(folder)` a run adds to what is in its folder
    SMALL                 those of a run of seconds, where Parameters() takes longer; None: none is
    run(parameters, job)  -> Results, all that is simulated
    report(results, parameters) -> Report, all that is said of them
    draw(figure, results, report), and SIZE [in] of the figure

and is found by its place. A chapter's package may have a STYLE of its figures (matplotlib's rc).
"""

from __future__ import annotations

import importlib.util
import json
import pkgutil
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import thesis
from softhand_common.documents import output_file
from thesis.tables import tables

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
else:  # experiments name them in signatures, and need no plotting library to run
    Axes = Figure = Any

__all__ = ["Axes", "Figure"]

Array = NDArray[np.float64]
Results = dict[str, Any]
"""What was simulated: arrays, and numbers, lists and dicts of them; SI units, angles in radians,
keys that say what they hold.
"""
Progress = Callable[[str, float], None]  # what is going on, and the share of it that is done
PACKAGES = ("softhand_model", "pneuflex_sim", "pneumaticbox_driver", "numpy", "scipy")
RESULT, SERIES, FIGURE = "result.json", "series.npz", "figure.png"
LOOK = {"figure.figsize": (8.0, 4.0), "savefig.dpi": 130}


def option(default: Any, help: str) -> Any:
    """A field of an experiment's parameters, with its help and unit; an option of the command."""
    return field(default=default, metadata={"help": help})


@dataclass(frozen=True)
class NoParameters:
    """Parameters of an experiment that has none."""


@dataclass(frozen=True)
class Job:
    """What a run gets besides its parameters.

    Args:
        folder: of the result; a run may keep files of its own in it.
        progress: called with the current activity and the share done.
    """

    folder: Path
    progress: Progress


@dataclass(frozen=True)
class Finding:
    """One row of a report.

    Attributes:
        what: the quantity.
        thesis, ours: the result of the thesis and of this run, as text.
        met: whether the target is met; None where there is no target.
        value, unit: of a numerical result.
    """

    what: str
    thesis: str
    ours: str
    met: bool | None = None
    value: float | None = None
    unit: str = ""


def number(what: str, value: float, unit: str = "", thesis: str = "-") -> Finding:
    """A value in a unit, without a target.

    >>> number("drift", 1.25, "mg", "< 2.5").ours
    '1.25 mg'
    """
    return Finding(what, thesis, f"{value:.3g} {unit}".rstrip(), None, value, unit)


def at_most(what: str, thesis: str, value: float, limit: float, unit: str) -> Finding:
    """A value that must not exceed its limit, both in the unit.

    >>> at_most("tip angle", "-", 0.0421, 0.1, "%").ours
    '0.042 % (<= 0.1)'
    """
    ours = f"{value:.2g} {unit} (<= {limit:g})"
    return Finding(what, thesis, ours, bool(value <= limit), float(value), unit)


@dataclass(frozen=True)
class Report:
    """Findings of an experiment, and its conclusion in one sentence."""

    findings: Sequence[Finding]
    conclusion: str

    def __getitem__(self, what: str) -> float:
        """Value of the finding of that name; raises KeyError."""
        return {f.what: f.value for f in self.findings if f.value is not None}[what]

    @property
    def judged(self) -> list[bool]:
        """Whether each target is met."""
        return [found.met for found in self.findings if found.met is not None]

    @property
    def verdict(self) -> str:
        """One line: how many targets were met, if there are any, and what came out.

        >>> Report([Finding("a", "-", "1", True), Finding("b", "-", "2")], "It is so.").verdict
        'holds (1 of 1 targets met). It is so.'
        """
        judged = self.judged
        word = "holds" if all(judged) else "falls short"
        head = f"{word} ({sum(judged)} of {len(judged)} targets met). " if judged else ""
        return head + self.conclusion

    @property
    def table(self) -> str:
        """The findings in Markdown (`thesis.tables`), with a column of targets if there are any.

        >>> print(Report([number("drift", 1.25, "mg", "< 2.5")], "").table)
        | what | thesis | here |
        | --- | --- | --- |
        | drift | < 2.5 | 1.25 mg |
        """
        words = {True: "yes", False: "NO", None: "-"}
        rows = [(row.what, row.thesis, row.ours, words[row.met]) for row in self.findings]
        return tables(rows, bool(self.judged))


def chapters() -> list[str]:
    """Names of the chapters' folders."""
    return [found.name for found in pkgutil.iter_modules(thesis.__path__) if found.ispkg]


def entries(chapter: str) -> list[pkgutil.ModuleInfo]:
    """Modules of a chapter's folder, not imported: experiments and modules that they share."""
    package = importlib.import_module(f"thesis.{chapter}")
    return [entry for entry in pkgutil.iter_modules(package.__path__) if not entry.ispkg]


def experiments(chapter: str | None = None) -> dict[str, ModuleType]:
    """All experiments, or those of one chapter, by name."""
    found = {}
    for folder in [chapter] if chapter else chapters():
        for entry in entries(folder):
            module = _loaded(f"thesis.{folder}.{entry.name}")
            if module:
                found[entry.name] = module
    return found


def experiment(name: str) -> ModuleType:
    """The experiment of that name; imports no other.

    Raises:
        ValueError: there is none; the message lists them.
    """
    if name.isidentifier():
        for folder in chapters():
            place = f"thesis.{folder}.{name}"
            if importlib.util.find_spec(place) and (module := _loaded(place)):
                return module
    raise ValueError(f"experiment: expected one of {', '.join(experiments())}, got {name}")


def _loaded(place: str) -> ModuleType | None:
    """The module if it is an experiment; None for a module that experiments share."""
    module = importlib.import_module(place)
    return module if hasattr(module, "run") and hasattr(module, "report") else None


def name_of(module: ModuleType) -> str:
    """Name of an experiment."""
    return module.__name__.rpartition(".")[2]


def title_of(module: ModuleType) -> str:
    """What an experiment does, and where in the thesis."""
    return (module.__doc__ or "").strip().partition("\n")[0].rstrip(".")


def parameters_of(module: ModuleType, given: dict[str, Any] | None = None) -> Any:
    """Parameters of an experiment with these in place of its own.

    Raises:
        ValueError: one of them is unusable.
    """
    if given and given.get("seed", 0) < 0:
        raise ValueError(f"seed: expected a whole number from 0, got {given['seed']}")
    made = getattr(module, "Parameters", NoParameters)
    named = {name: tuple(v) if isinstance(v, list) else v for name, v in (given or {}).items()}
    return made(**named)


def check_free(folder: Path) -> None:
    """Refuse a folder that has a result; raises ValueError."""
    if (folder / RESULT).exists():
        raise ValueError(f"{folder}: expected no earlier run, got one; --force replaces its result")


def write_result(
    folder: Path, module: ModuleType, parameters: Any, results: Results, report: Report
) -> None:
    """Write what was simulated (arrays apart, as they are) and what is said of it."""
    arrays = {key: v for key, v in results.items() if isinstance(v, np.ndarray)}
    if arrays:
        with output_file.written_whole(folder / SERIES) as file:
            np.savez_compressed(file, **arrays)
    content = {
        "experiment": name_of(module),
        "title": title_of(module),
        "versions": {name: version(name) for name in PACKAGES} | _engines(),
        "parameters": asdict(parameters),
        "findings": [asdict(found) for found in report.findings],
        "verdict": report.verdict,
        "results": {key: v for key, v in results.items() if key not in arrays},
    }
    output_file.write_file(folder / RESULT, json.dumps(content, indent=1) + "\n")


def _engines() -> dict[str, str]:
    """Versions of the physics engines that are installed."""
    found = {}
    for name in ("pybullet", "mujoco-core"):
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def read_result(folder: Path, module: ModuleType) -> tuple[Any, Results]:
    """Parameters and results of an earlier run.

    Raises:
        ValueError: there is none, or it is of another experiment.
    """
    path = folder / RESULT
    if not path.exists():
        raise ValueError(f"{path}: expected the result of an earlier run, got no such file")
    content = json.loads(path.read_text(encoding="utf-8"))
    if content.get("experiment") != name_of(module):
        raise ValueError(
            f"{path}: experiment: expected {name_of(module)}, got {content.get('experiment')}"
        )
    results = content["results"]
    if (folder / SERIES).exists():
        with np.load(folder / SERIES) as kept:
            results |= {key: kept[key] for key in kept.files}
    return parameters_of(module, content["parameters"]), results


def save_figure(module: ModuleType, results: Results, report: Report, path: Path) -> None:
    """Draw the figure of an experiment into a PNG file; needs matplotlib."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    chapter = importlib.import_module(module.__package__ or "")
    with mpl.rc_context(LOOK | getattr(chapter, "STYLE", {})):
        figure = Figure(figsize=getattr(module, "SIZE", None), layout="constrained")
        FigureCanvasAgg(figure)
        module.draw(figure, results, report)
        # no program in the file: the same results give the same bytes
        output_file.save_figure(figure, path, metadata={"Software": None})
