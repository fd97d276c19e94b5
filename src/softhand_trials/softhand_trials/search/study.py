"""Which values are evaluated next: Optuna's samplers, which get results by whole generations.

The values of a generation depend on the seed and on earlier generations alone. So a problem has the
same evaluations on any number of workers, and when it is taken up from stored results. This is the
only module that uses Optuna, by its public interface.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import optuna
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend

from softhand_common.documents.output_file import written_whole
from softhand_trials.search.objective import COST
from softhand_trials.search.problem import Evaluation, SearchProblem
from softhand_trials.sweep.task import Record

STUDY = "study.log"


class Study:
    """A problem's evaluations, generation by generation."""

    def __init__(self, problem: SearchProblem) -> None:
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        self._problem = problem
        self._ranges: dict[str, Any] = {
            v.name: optuna.distributions.FloatDistribution(v.low, v.high) for v in problem.variables
        }
        self._storage = optuna.storages.InMemoryStorage()
        self._study = optuna.create_study(
            storage=self._storage, sampler=_sampler(problem), study_name=problem.name
        )
        for start in problem.starts:
            self._study.enqueue_trial(dict(start))

    def ask(self, count: int | None = None) -> list[Evaluation]:
        """The next generation, or the next `count`; empty when all evaluations have been asked
        for.
        """
        problem, begun = self._problem, len(self._study.trials)
        queued = len(self._study.get_trials(False, (optuna.trial.TrialState.WAITING,)))
        wanted = problem.generation if count is None else count
        if problem.spread is not None and not begun - queued:
            wanted = 1  # the start, from whose result on CMA-ES samples around it
        count = min(wanted, problem.evaluations - begun + queued)
        trials = [self._study.ask(self._ranges) for _ in range(count)]
        return [Evaluation(problem, trial.number, trial.params) for trial in trials]

    def tell(self, generation: Sequence[Evaluation], records: Sequence[Record]) -> None:
        """Take the results of a generation, in its order; an evaluation that ended in an error has
        no cost.
        """
        for evaluation, record in zip(generation, records, strict=True):
            self.tell_cost(evaluation.number, None if "error" in record else record[COST])

    def tell_cost(self, number: int, cost: float | None) -> None:
        """Take the cost of an evaluation, given by its number; None: it has none."""
        failed = optuna.trial.TrialState.FAIL if cost is None else None
        self._study.tell(number, cost, state=failed)

    def write(self, folder: Path) -> Path:
        """Write the study as a journal for Optuna's own tools, such as its dashboard, and return
        its path; raises UnwritableFile.
        """
        path = folder / STUDY
        with written_whole(path) as file:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
                storage = JournalStorage(JournalFileBackend(str(file)))
            optuna.copy_study(
                from_study_name=self._study.study_name,
                from_storage=self._storage,
                to_storage=storage,
            )
        return path


def _sampler(problem: SearchProblem) -> optuna.samplers.BaseSampler:
    samplers = optuna.samplers
    if problem.sampler == "random":
        return samplers.RandomSampler(seed=problem.seed)
    if problem.sampler == "tpe":
        with warnings.catch_warnings():  # parts of it may still change, and its version is pinned
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            return samplers.TPESampler(seed=problem.seed, multivariate=True, constant_liar=True)
    given: dict[str, Any] = {}
    if problem.spread is not None:
        given = {"x0": dict(problem.starts[0]), "sigma0": problem.spread}
    with warnings.catch_warnings():  # x0 and sigma0 are to go, and the version is pinned
        warnings.simplefilter("ignore", FutureWarning)
        return samplers.CmaEsSampler(
            seed=problem.seed,
            popsize=problem.generation,
            independent_sampler=samplers.RandomSampler(seed=problem.seed),
            warn_independent_sampling=False,
            **given,
        )
