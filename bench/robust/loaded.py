"""The demo beside busy loops: does it end as on an idle machine?

Each demo is that of `make demo` but for the pictures, with nodes and a recorder of its own.
"""

from __future__ import annotations

import json
import math
import tempfile
import time
from pathlib import Path
from typing import Any

from bench.robust.same_run import busy
from bench.row import at_least, stated
from softhand_bringup.processes.launcher import NodeDied
from softhand_bringup.processes.suite import SuiteOptions
from softhand_bringup.processes.waiting import RunFailed
from softhand_bringup.ros.demo import Demo
from softhand_trials.trials import draw_placement

TAKES = "ten minutes"
LOOPS = 4
ENDS = ("gripped", "phase", "cause")  # how it ends, in result.json
HEIGHT = "lift_height"  # [m]


def run(demos: int = 10, seed: int = 0) -> list[dict[str, Any]]:
    """Row on so many demos of one seed."""
    with tempfile.TemporaryDirectory() as folder:
        idle = _demo(seed, Path(folder) / "idle")
        if not idle:
            raise RunFailed("no demo on an idle machine to compare with")
        with busy(LOOPS):
            loaded = [_demo(seed, Path(folder) / f"loaded_{k}") for k in range(demos)]
    alike = [result for result in loaded if _end(result) == _end(idle)]
    apart = max((abs(result[HEIGHT] - idle[HEIGHT]) for result in alike), default=math.nan)
    name = f"demos beside {LOOPS} busy loops"
    return [
        at_least(f"{name} that end as on an idle machine", len(alike), "", demos),
        stated(f"{name}: lift height apart from the idle one", 1e3 * apart, "mm, at most"),
    ]


def _demo(seed: int, folder: Path) -> dict[str, Any]:
    """The result of a demo; empty where it came to none, and why is printed."""
    offset, mass_scale = draw_placement(seed)
    options = SuiteOptions(object_offset=offset, object_mass_scale=mass_scale, seed=seed)
    folder.mkdir()
    begin = time.monotonic()
    try:
        verdict = Demo(options, folder, lambda line: None).run()
    except (RunFailed, NodeDied) as error:
        print(f"  failed: {error}", flush=True)
        return {}
    print(f"  {verdict.line(folder).split(';')[0]}; {time.monotonic() - begin:.0f} s", flush=True)
    result: dict[str, Any] = json.loads((folder / "result.json").read_text())
    return result


def _end(result: dict[str, Any]) -> list[Any]:
    return [result.get(key, "no result") for key in ENDS]
