"""Searches: the values of some variables with the least cost, by a budget fixed beforehand."""

from grasp_strategies.search.again import Tried, try_again
from grasp_strategies.search.objective import objective
from grasp_strategies.search.problem import SearchProblem, Variable, load_problem
from grasp_strategies.search.run import SearchResult, run_search, search_with

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
