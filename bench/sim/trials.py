"""How many trials a core does in an hour: the full strategy, air included, at 5 ms."""

from __future__ import annotations

import statistics
import time
from typing import Any

from bench.row import at_least, stated
from softhand_trials.trials import TrialSettings, run_trial

STEP = 0.005
TRIALS = 20
LEAST_DURATION = 7.0  # [s] simulated, as in the thesis
TARGET = 2000.0
THESIS = 21.0  # a million grasps a day on 2000 cores


def rows(small: bool) -> list[dict[str, Any]]:
    """Trials per core-hour by CPU time, with the scene built once and restored for each."""
    settings = TrialSettings(step=STEP, options=("lower_and_release",))
    run_trial(0, settings)  # compile
    trials, begin = [], time.process_time()
    for seed in range(4 if small else TRIALS):
        trials.append(run_trial(seed, settings))
    spent = time.process_time() - begin
    durations = [trial.result.duration for trial in trials]
    return [
        at_least(
            "trials per core-hour, full strategy, 5 ms", 3600 * len(trials) / spent, "", TARGET
        ),
        stated("trials per core-hour by the thesis", THESIS, ""),
        at_least("simulated time of a trial, shortest", min(durations), "s", LEAST_DURATION),
        stated("simulated time of a trial, median", statistics.median(durations), "s"),
        stated(
            "trials gripped", sum(trial.result.gripped for trial in trials), f"of {len(trials)}"
        ),
    ]
