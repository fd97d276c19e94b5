"""Benchmark of robustness: `python -m bench.robust`, `make bench NAME=robust`.

Real nodes under hostile messages, wrong calls, signals, faults and long work; one file a group of
rows. It uses the free ROS domain that the tests' support finds.
"""

import os
import sys
from pathlib import Path

for _library in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
_SUPPORT = str(Path(__file__).resolve().parents[2] / "test" / "support")
if _SUPPORT not in sys.path:
    sys.path.append(_SUPPORT)
