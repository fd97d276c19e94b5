"""The problem of a search, read from YAML, and its evaluations as tasks.

The file has the keys

* `format: softhand-search/1`, `name` (first part of every key), `objective: module:function`;
* `variables: {name: [low, high]}`;
* `evaluations`: the budget; `generation` (8): how many evaluations are chosen together, before any
  of them has a result; `seed` (0); `sampler`, which chooses them: `cma` (CMA-ES), `tpe` (tree of
  Parzen estimators) or `random`;
* `start: {name: value}`, or a list of such: what is tried first. With a single start, `spread` lets
  CMA-ES search around this start, after a first generation of the start alone; it is the standard
  deviation, as a share of each range;
* `enough`: a cost; the search ends after the first generation with a cost that is at most this;
* `settings`: what the objective is given besides the values. A text that is the path of a file
  relative to the problem's folder becomes an absolute path, and a change of the file's content
  makes it another evaluation.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from softhand_common.documents.yaml_document import Node, read_document
from softhand_trials.search.objective import COST, check_name, evaluate
from softhand_trials.sweep.task import DIGEST_DIGITS, Record

FORMAT = "softhand-search/1"
SAMPLERS = ("cma", "tpe", "random")
LARGEST_BUDGET = 1_000_000  # evaluations
LARGEST_GENERATION = 10_000
GENERATION = 8  # usual of CMA-ES with four variables


@dataclass(frozen=True)
class Variable:
    """One number that is searched for, from `low` to `high`, in the objective's unit."""

    name: str
    low: float
    high: float


@dataclass(frozen=True)
class SearchProblem:
    """A search, with the fields that the module's text describes.

    allow_any: whether the objective may be in any module.

    Raises ValueError for what cannot be searched.
    """

    name: str
    objective: str
    variables: tuple[Variable, ...]
    evaluations: int
    generation: int = GENERATION
    sampler: str = "cma"
    seed: int = 0
    start: Mapping[str, float] | Sequence[Mapping[str, float]] = ()
    settings: Mapping[str, Any] = field(default_factory=dict)
    allow_any: bool = False
    spread: float | None = None
    enough: float | None = None

    def __post_init__(self) -> None:
        check_name(self.objective, self.allow_any)
        if self.sampler not in SAMPLERS:
            raise ValueError(
                f"sampler: expected one of {', '.join(SAMPLERS)}, got {self.sampler!r}"
            )
        if self.sampler == "cma" and (len(self.variables) < 2 or self.generation < 4):
            raise ValueError(
                f"sampler: cma: expected 2 or more variables, got {len(self.variables)}, and "
                f"4 or more evaluations in a generation, got {self.generation}"
            )
        if self.spread is not None and (self.sampler != "cma" or len(self.starts) != 1):
            raise ValueError(
                "spread: expected sampler: cma and one start beside it, got sampler: "
                f"{self.sampler} and {len(self.starts)} starts; change them, or leave spread out"
            )
        by_name = {variable.name: variable for variable in self.variables}
        for name, value in (item for start in self.starts for item in start.items()):
            found = by_name.get(name)
            if found is None or not found.low <= value <= found.high:
                raise ValueError(
                    f"start: {name}: expected the name of a variable and a value within its "
                    f"range, got {value}"
                )
        if self.spread is not None and len(self.starts[0]) < len(by_name):
            lacking = next(name for name in by_name if name not in self.starts[0])
            raise ValueError(
                f"start: expected a value of every variable, around which spread searches, got "
                f"none of {lacking}"
            )

    @property
    def starts(self) -> tuple[Mapping[str, float], ...]:
        """Values that are evaluated first, in this order."""
        given = (self.start,) if isinstance(self.start, Mapping) else self.start
        return tuple(start for start in given if start)

    def is_enough(self, records: Sequence[Record]) -> bool:
        """Whether an evaluation of a generation is good enough to end the search."""
        costs = [record[COST] for record in records if COST in record]
        return self.enough is not None and min(costs, default=math.inf) <= self.enough

    def with_settings(self, **changed: Any) -> SearchProblem:
        """A copy with some of the objective's settings changed."""
        return replace(self, settings={**self.settings, **changed})


@dataclass(frozen=True)
class Evaluation:
    """One evaluation of a problem, which depends on these fields alone."""

    problem: SearchProblem
    number: int
    values: Mapping[str, float]

    @property
    def key(self) -> str:
        """Name of the evaluation, such as `kapandji_3/0012`."""
        return f"{self.problem.name}/{self.number:04d}"

    @property
    def settings(self) -> SearchProblem:
        """The problem, which all evaluations share and a worker loads once."""
        return self.problem

    @property
    def digest(self) -> str:
        """Hash of the objective, the settings with the files they name, and the values tried."""
        problem = self.problem
        plain = [problem.objective, problem.settings, self.values]
        texts = [json.dumps(plain, sort_keys=True), *_contents(problem.settings)]
        return hashlib.sha256("".join(texts).encode()).hexdigest()[:DIGEST_DIGITS]

    def describe(self) -> Record:
        """Description of the evaluation in its record: key, digest, objective, values and
        settings."""
        return {
            "key": self.key,
            "digest": self.digest,
            "objective": self.problem.objective,
            "values": dict(self.values),
            "settings": dict(self.problem.settings),
        }

    def result(self) -> Record:
        """What the objective returns."""
        problem = self.problem
        return evaluate(problem.objective, self.values, problem.settings, problem.allow_any)


def _contents(settings: Mapping[str, Any]) -> list[str]:
    """Digests of the files that settings name."""
    named = [Path(value) for value in settings.values() if isinstance(value, str) and value]
    return [hashlib.sha256(p.read_bytes()).hexdigest() for p in named if p.is_file()]


# ---------------------------------------------------------------- reading
def load_problem(path: str | Path, allow_any: bool = False) -> SearchProblem:
    """Read a problem; the objective's module is not imported yet.

    Raises ValueError naming file, key, expected and got.
    """
    document = read_document(Path(path), FORMAT)
    required = ("format", "name", "objective", "variables", "evaluations", "sampler")
    top = document.fields(required, ("generation", "seed", "start", "spread", "enough", "settings"))
    variables = tuple(_variable(*item) for item in top["variables"].mapping().items())
    if not variables:
        raise top["variables"].error("at least one variable")
    given: dict[str, Any] = {
        "generation": top["generation"].whole(1, LARGEST_GENERATION)
        if "generation" in top
        else GENERATION,
        "seed": top["seed"].whole(0, 2**32 - 1) if "seed" in top else 0,
        "start": _starts(top["start"]) if "start" in top else (),
        "spread": top["spread"].number(above=0.0, high=1.0) if "spread" in top else None,
        "enough": top["enough"].number() if "enough" in top else None,
        "settings": _settings(top["settings"]) if "settings" in top else {},
    }
    name, function = top["name"].name(), top["objective"].text()
    budget, sampler = top["evaluations"].whole(1, LARGEST_BUDGET), top["sampler"].choice(SAMPLERS)
    try:
        return SearchProblem(
            name, function, variables, budget, sampler=sampler, allow_any=allow_any, **given
        )
    except ValueError as reason:
        raise ValueError(f"{path}: {reason}") from None


def _variable(name: str, node: Node) -> Variable:
    low, high = node.vector(2)
    if not low < high:
        raise node.error("low and high, with low below high")
    return Variable(name, low, high)


def _numbers(node: Node) -> dict[str, float]:
    return {name: child.number() for name, child in node.mapping().items()}


def _starts(node: Node) -> tuple[dict[str, float], ...]:
    many = node.items() if isinstance(node.value, list) else [node]
    return tuple(_numbers(start) for start in many)


def _settings(node: Node) -> dict[str, Any]:
    return {name: _setting(child) for name, child in node.mapping().items()}


def _setting(node: Node) -> Any:
    """Plain data as it stands, or the whole path of a file."""
    if not isinstance(node.value, str) or not Path(node.value).suffix:
        return node.value
    path = Path(node.file).parent / node.value
    return str(path.resolve()) if path.is_file() else node.value
