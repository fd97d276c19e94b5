"""Real-time factor against the prototype's, on its own scene: both in turn, in one run."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from pathlib import Path
from types import TracebackType
from typing import Any

from bench.row import at_least, stated

PROTOTYPE = Path(__file__).parents[3] / "shared" / "prototypes" / "implicit_chain.py"
STEPS, SEGMENTS = (0.001, 0.005), (5, 15)
ROUNDS = 3
TARGET = 1.2
LIFTED = 0.12  # height of the object's centre [m]


class Engine:
    """An engine in a process of its own, see `engine_process`."""

    def __init__(self, name: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "bench.sim.engine_process", name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"NUMBA_CACHE_DIR": os.environ.get("NUMBA_CACHE_DIR", _cache())},
        )

    def __enter__(self) -> Engine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait(timeout=60)

    def grasp(self, segments: int, step: float) -> dict[str, float]:
        """Run one grasp; raises RuntimeError when the process has ended."""
        stdin, stdout = self._process.stdin, self._process.stdout
        if stdin is None or stdout is None:
            raise RuntimeError("the engine has no pipes")
        stdin.write(f"{segments} {step}\n")
        stdin.flush()
        for line in stdout:
            if line.startswith("grasp "):
                return dict(json.loads(line.removeprefix("grasp ")))
        raise RuntimeError(f"the engine ended with status {self._process.wait()}")


def _cache() -> str:
    """Where numba keeps what it compiled of a file in a folder that cannot be written."""
    return str(Path("out/bench/numba").absolute())


def rows(small: bool) -> list[dict[str, Any]]:
    """Ratios of the factors, and the factors themselves."""
    if not PROTOTYPE.exists():
        raise FileNotFoundError(f"prototype: expected {PROTOTYPE}")
    found = []
    with Engine("ours") as ours, Engine(str(PROTOTYPE)) as prototype:
        for engine in (ours, prototype):
            engine.grasp(5, 0.01)  # compile
        for segments in SEGMENTS:
            for step in STEPS:
                found += _compare(ours, prototype, segments, step, 1 if small else ROUNDS)
    return found


def _compare(
    ours: Engine, prototype: Engine, segments: int, step: float, rounds: int
) -> list[dict[str, Any]]:
    pairs = [(ours.grasp(segments, step), prototype.grasp(segments, step)) for _ in range(rounds)]
    ratio = statistics.median(a["factor"] / b["factor"] for a, b in pairs)
    name = f"six fingers, {6 * segments} segments, {1e3 * step:g} ms"
    lifted = min(a["height"] for a, _ in pairs)
    return [
        at_least(f"{name}: real-time factor over the prototype's", ratio, "", TARGET),
        stated(f"{name}: real-time factor", max(a["factor"] for a, _ in pairs), ""),
        stated(f"{name}: the prototype's", max(b["factor"] for _, b in pairs), ""),
        at_least(f"{name}: height of the object", lifted, "m", LIFTED),
    ]
