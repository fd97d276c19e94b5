"""The command `model-lab`: its subcommands and the options that they share.

The matrices of a fit are small: several threads of linear algebra would cost more than they gain.
"""

import os

for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
