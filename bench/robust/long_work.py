"""Grasps one after the other: what the processes hold does not grow."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from bench.robust.rig import Rig, RigError, Usage, growth, started
from bench.row import at_least, at_most
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
        return rows_of(rig, minutes)


def rows_of(rig: Rig, minutes: float) -> list[dict[str, Any]]:
    """The same with nodes that run. Every minute says how it goes; after Ctrl-C, a node that ended
    or a call without an answer, the rows are those of the time until then.
    """
    before, begin, shown = rig.usage(), time.monotonic(), 0.0
    grasps = failed = 0
    try:
        while (spent := time.monotonic() - begin) < minutes * MINUTE and _all_run(rig):
            if spent >= shown + MINUTE:
                shown = spent
                print(f"  {_course(spent, grasps, failed, before, rig.usage())}", flush=True)
            answer = rig.grasp()
            grasps += 1
            if not answer.success:
                failed += 1
                print(f"  grasp {grasps}: {answer.message}", flush=True)
            rig.begin_anew()
    except KeyboardInterrupt:
        print("  stopped: the rows are of the time until now", flush=True)
    except RigError as reason:
        failed += 1
        print(f"  after grasp {grasps}: {reason}", flush=True)
    spent = time.monotonic() - begin
    after = rig.usage()
    rig.tell_ended()
    print(f"  {_course(spent, grasps, failed, before, after)}", flush=True)
    return [
        at_least("grasps one after the other", grasps, f"in {spent / MINUTE:.1f} min", 1),
        at_most("grasps, or calls between them, that failed", failed, "", 0),
        at_most("memory that grew", growth(before, after, "memory"), "%", ALLOWED),
        at_most("open files that grew", growth(before, after, "files"), "%", ALLOWED),
        at_most("threads that grew", growth(before, after, "threads"), "%", ALLOWED),
        at_most("nodes that ended", len(rig.nodes) - len(rig.alive()), "", 0),
    ]


def _all_run(rig: Rig) -> bool:
    return len(rig.alive()) == len(rig.nodes)


def _course(
    spent: float,
    grasps: int,
    failed: int,
    before: Mapping[str, Usage],
    now: Mapping[str, Usage],
) -> str:
    """How it goes, in a line: grasps, failures, memory of each node [MB] and its growth [%]."""
    held = [
        f"{name} {usage.memory:.1f} MB ({growth(before, {name: usage}, 'memory'):+.2f} %)"
        for name, usage in now.items()
    ]
    return f"{spent / MINUTE:.1f} min: {grasps} grasps, {failed} failed; {', '.join(held)}"
