"""Benchmarks: `python -m bench [module ...]`, or `make bench` for all.

Like the command `model-lab`, they use one thread for linear algebra.
"""

import os

for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
