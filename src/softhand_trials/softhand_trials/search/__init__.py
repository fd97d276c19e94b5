"""Searches: values of variables that minimise a cost, within a fixed number of evaluations."""

from softhand_trials.search.again import Tried, try_again
from softhand_trials.search.objective import objective
from softhand_trials.search.problem import SearchProblem, Variable, load_problem
from softhand_trials.search.run import SearchResult, run_search, search_with

__all__ = [
    "SearchProblem",
    "SearchResult",
    "Tried",
    "Variable",
    "load_problem",
    "objective",
    "run_search",
    "search_with",
    "try_again",
]
