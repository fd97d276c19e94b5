"""Benchmark of the model lab on sets with hidden effects: `python -m bench.lab`, `make bench-lab`.

The sets come from `test/support/hidden`, which shares no code with the lab. One thread a process:
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
