"""Grasps one after the other: what the processes hold does not grow."""

from __future__ import annotations

import time
from typing import Any

from bench.robust.rig import growth, started
from bench.row import at_least, at_most, stated
from softhand_bringup.processes import suite
from softhand_bringup.processes.suite import SuiteOptions

WARM = 2  # grasps before what is held counts
ALLOWED = 2.0  # growth [%]
MINUTE = 60.0  # [s]


def run(minutes: float = 5.0) -> list[dict[str, Any]]:
    """Rows on the grasps of so many minutes and on what the processes held before and after."""
    options = SuiteOptions()
    with started(options, [suite.monitor(options)]) as rig:
        for _ in range(WARM):
            rig.grasp()
            rig.begin_anew()
        before, begin = rig.usage(), time.monotonic()
        grasps, gripped = 0, 0
        while time.monotonic() - begin < minutes * MINUTE:
            answer = rig.grasp()
            grasps, gripped = grasps + 1, gripped + answer.success
            if not answer.success:
                print(f"  grasp {grasps}: {answer.message}", flush=True)
            rig.begin_anew()
        after = rig.usage()
        for name in before:
            print(f"  {name}: {before[name]}, then {after[name]}", flush=True)
        return [
            stated("grasps one after the other", grasps, f"in {minutes:g} min"),
            at_least("of them succeed", gripped, "", grasps),
            at_most("memory that grew", growth(before, after, "memory"), "%", ALLOWED),
            at_most("open files that grew", growth(before, after, "files"), "%", ALLOWED),
            at_most("threads that grew", growth(before, after, "threads"), "%", ALLOWED),
            at_most("nodes that ended", len(rig.nodes) - len(rig.alive()), "", 0),
        ]
