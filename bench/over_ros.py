"""The demo's grasp over ROS at 2 ms, for ten seeds."""

from __future__ import annotations

import statistics
import tempfile
from pathlib import Path
from typing import Any

from bench.row import at_least, at_most
from softhand_bringup.grasp_verdict import Verdict
from softhand_bringup.processes.launcher import NodeDied
from softhand_bringup.processes.suite import SuiteOptions
from softhand_bringup.processes.waiting import RunFailed
from softhand_bringup.ros.demo import Demo
from softhand_trials.trials import draw_placement

SEEDS = range(10)


def run() -> list[dict[str, Any]]:
    """Real-time factor over ROS, grasps that succeed, and drift while held."""
    with tempfile.TemporaryDirectory() as folder:
        runs = [grasp(seed, Path(folder) / str(seed)) for seed in SEEDS]
    verdicts = [verdict for verdict in runs if verdict is not None]
    factors = [verdict.real_time_factor for verdict in verdicts]
    factor = statistics.median(factors) if factors else 0.0
    slips = [verdict.slip for verdict in verdicts if verdict.slip is not None]
    gripped = sum(verdict.gripped for verdict in verdicts)
    return [
        at_least("grasp over ROS, 2 ms: real-time factor", factor, "", 1),
        at_least("grasps over ROS that succeed, of 10 seeds", gripped, "", len(SEEDS)),
        at_most(
            "drift of the held object in 1 s, worst of the seeds",
            1e3 * max(slips, default=float("inf")),
            "mm",
            1,
        ),
    ]


def grasp(seed: int, folder: Path) -> Verdict | None:
    """One grasp without a recorder, as fast as it goes; None if it did not come to a verdict."""
    offset, mass_scale = draw_placement(seed)
    options = SuiteOptions(
        object_offset=offset, object_mass_scale=mass_scale, seed=seed, real_time_factor=0.0
    )
    folder.mkdir(parents=True)
    try:
        verdict = Demo(options, folder, lambda line: None, record=False).run()
    except (RunFailed, NodeDied) as error:
        print(f"  seed {seed}: {error}", flush=True)
        return None
    print(f"  seed {seed}: {verdict.line(folder).split(';')[0]}", flush=True)
    return verdict
