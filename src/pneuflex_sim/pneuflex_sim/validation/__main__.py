"""`python -m pneuflex_sim.validation`, the same as `pneuflex-validate`."""

import sys

from pneuflex_sim.validation.command import main

sys.exit(main())
