"""How long the lab takes on large sets."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

from bench.hidden import make_set
from bench.lab.adapter import comparison_of, diagnosis_of


def measure_speed() -> list[dict[str, Any]]:
    """Seconds of `diagnose` on 36 runs of 800 samples and `compare` on a million samples."""
    with tempfile.TemporaryDirectory(prefix="bench-lab-") as folder:
        large, huge = Path(folder) / "large", Path(folder) / "huge"
        make_set(
            large,
            "free_bending",
            [("viscoelasticity", {})],
            seed=1,
            ratio=4.0,
            runs=36,
            repeats=6,
            samples=800,
        )
        make_set(huge, "free_bending", [], seed=1, samples=83334)
        return [
            _timed("diagnose, 36 runs x 800 samples", 60.0, lambda: diagnosis_of(large, 0, jobs=2)),
            _timed("compare, 1,000,008 samples", 10.0, lambda: comparison_of(huge)),
        ]


def _timed(name: str, target: float, call: Any) -> dict[str, Any]:
    started = time.perf_counter()
    call()
    return {"name": name, "seconds": time.perf_counter() - started, "target": target}
