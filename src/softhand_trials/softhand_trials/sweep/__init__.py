"""Sweeps: all trials of a plan, on processes or a cluster, with results that can be continued."""

from softhand_trials.sweep.plan import Jitter, SweepPlan, load_plan
from softhand_trials.sweep.results import read_results
from softhand_trials.sweep.run import run_sweep, run_tasks
from softhand_trials.sweep.task import run_task
from softhand_trials.sweep.trial_task import TrialTask

__all__ = [
    "Jitter",
    "SweepPlan",
    "TrialTask",
    "load_plan",
    "read_results",
    "run_sweep",
    "run_task",
    "run_tasks",
]
