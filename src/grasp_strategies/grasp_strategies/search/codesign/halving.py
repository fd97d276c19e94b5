"""A search by successive halving: all of a generation at few places, the best of it at more.

The budget counts trials. Places of a later rung come on top of those of the rungs before, so that
none is run twice; what the sampler is told is the cost over all places that were run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grasp_strategies.search.codesign.success import INFEASIBLE, cost_of
from grasp_strategies.search.objective import COST
from grasp_strategies.search.problem import Evaluation, SearchProblem
from grasp_strategies.search.study import Study
from grasp_strategies.sweep.cluster import Cluster
from grasp_strategies.sweep.line import Record
from grasp_strategies.sweep.pool import Processes
from grasp_strategies.sweep.results import Results


@dataclass(frozen=True)
class Halving:
    """Rungs (places of each object, rising), how many of a generation one survivor stands for, and
    the budget of trials.
    """

    rungs: tuple[int, ...] = (2, 8, 40)
    one_in: int = 4
    budget: int = 1800

    def __post_init__(self) -> None:
        rising = all(a < b for a, b in zip(self.rungs, self.rungs[1:], strict=False))
        if not self.rungs or self.rungs[0] < 1 or not rising or self.one_in < 2:
            raise ValueError(
                f"halving: expected rising rungs and one in two or more, got {self.rungs} and "
                f"one in {self.one_in}"
            )


@dataclass(frozen=True)
class Tried:
    """One candidate: its number and values, successes by object over all its places, cost, and why
    it cannot be built ("" if it can).
    """

    number: int
    values: Mapping[str, float]
    successes: Mapping[str, Sequence[int]]
    cost: float
    infeasible: str

    @property
    def trials(self) -> int:
        """How many trials it took."""
        return sum(len(one) for one in self.successes.values())


def search_by_halving(
    crew: Processes | Cluster, problem: SearchProblem, halving: Halving, folder: Path
) -> list[Tried]:
    """All candidates in the order in which they were asked for, until the budget is spent; goes on
    from the lines in the folder.
    """
    study, found = Study(problem), list[Tried]()
    with Results(folder) as results:
        while sum(one.trials for one in found) < halving.budget:
            generation = study.ask()
            if not generation:
                break
            tried = _generation(crew, generation, halving, results)
            study.tell(generation, [{COST: tried[one.number].cost} for one in generation])
            found += [tried[one.number] for one in generation]
    study.write(folder)
    return found


def best_of(found: Sequence[Tried]) -> Tried:
    """The least cost among those that were tried at most places."""
    most = max(one.trials for one in found)
    return min((one for one in found if one.trials == most), key=lambda one: one.cost)


def _generation(
    crew: Processes | Cluster, generation: Sequence[Evaluation], halving: Halving, results: Results
) -> dict[int, Tried]:
    tried: dict[int, Tried] = {}
    alive, first = list(generation), 0
    for rung, last in enumerate(halving.rungs):
        lines = {one.number: lines_of(one, rung, first, last) for one in alive}
        everything = [line for some in lines.values() for line in some]
        for record in crew.run(results.left(everything, again=False)):
            results.append(record)
        for one in alive:
            records = [results.records[line.key] for line in lines[one.number]]
            tried[one.number] = _more(one, tried.get(one.number), records)
        feasible = [one for one in alive if not tried[one.number].infeasible]
        ranked = sorted(feasible, key=lambda one: tried[one.number].cost)
        alive, first = ranked[: max(1, len(generation) // halving.one_in ** (rung + 1))], last
    return tried


def lines_of(one: Evaluation, rung: int | str, first: int, last: int) -> list[Evaluation]:
    """A line for each object, so that all workers have something to do, at places [first, last)."""
    problem = one.problem
    return [
        replace(
            one,
            problem=replace(
                problem,
                name=f"{problem.name}_{rung}_{name}",
                settings={**problem.settings, "objects": [name], "places": [first, last]},
            ),
        )
        for name in problem.settings["objects"]
    ]


def _more(one: Evaluation, before: Tried | None, records: Sequence[Record]) -> Tried:
    """A candidate with the trials of more lines; one of which a line ended in an error fails."""
    for record in records:
        reason = str(record["error"]) if "error" in record else record["infeasible"]
        if reason:
            return Tried(one.number, one.values, {}, INFEASIBLE, reason)
    known: Mapping[str, Any] = before.successes if before else {}
    successes = {
        name: [*known.get(name, []), *new]
        for record in records
        for name, new in record["successes"].items()
    }
    return Tried(one.number, one.values, successes, cost_of(successes), "")
