"""Benchmark of the pneumatic box: `python -m bench.pneumatics`, `make bench NAME=pneumatics`.

A seed is a box: other tolerances, other noise, a calibration of its own. One thread a process:
two processes share the machine.
"""

import os
import sys
from pathlib import Path

for _library in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
_SUPPORT = str(Path(__file__).resolve().parents[2] / "test" / "support")
if _SUPPORT not in sys.path:
    sys.path.append(_SUPPORT)
