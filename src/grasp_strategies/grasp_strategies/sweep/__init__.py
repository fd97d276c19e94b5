"""Sweeps: many trials of a plan, on processes or a cluster, results as lines to go on from."""

from grasp_strategies.sweep.line import run_line
from grasp_strategies.sweep.plan import Jitter, SweepPlan, load_plan
from grasp_strategies.sweep.results import read_results
from grasp_strategies.sweep.run import run_lines, run_sweep
from grasp_strategies.sweep.trial_line import TrialLine

__all__ = [
    "Jitter",
    "SweepPlan",
    "TrialLine",
    "load_plan",
    "read_results",
    "run_line",
    "run_lines",
    "run_sweep",
]
