"""One engine in a process of its own: reads `segments step` from each line of its input, runs the
grasp of six fingers, writes a line of JSON.

Run as `python -m bench.sim.engine_process ours`, or with the path of the prototype's file, which is
loaded from where it is. CPU time stands in for its clock.
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

Grasp = Callable[[int, float], dict[str, float]]


def ours() -> Grasp:
    """This project's simulator."""
    from bench.sim import six_fingers

    return six_fingers.grasp


def prototype(path: str) -> Grasp:
    """The prototype's grasp of the same scene."""
    time.perf_counter = time.thread_time  # type: ignore[assignment]
    sys.path.insert(0, str(Path(path).parent))
    module = importlib.import_module(Path(path).stem)
    module.p.connect(module.p.DIRECT)

    def grasp(segments: int, step: float) -> dict[str, float]:
        found = module.GraspScene(segments, step).grasp()
        return {
            "factor": float(found["rtf"]),
            "height": float(found["z"]) / 1e3,
            "contacts": float(found["contacts"]),
        }

    return grasp


def main(engine: str) -> None:
    """Answer lines until the input ends."""
    grasp = ours() if engine == "ours" else prototype(engine)
    for line in sys.stdin:
        segments, step = line.split()
        print("grasp", json.dumps(grasp(int(segments), float(step))), flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
