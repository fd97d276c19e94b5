"""Benchmark of the model lab on sets with hidden effects: `make bench NAME=lab`.

The sets come from `bench.hidden`, which shares no code with the lab. One thread a process: two
processes share the machine.
"""

import os

for _library in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
