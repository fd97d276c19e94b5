"""`python -m pneumaticbox_driver.experiments NAME`: one experiment."""

import sys

from pneumaticbox_driver.experiments.main import main

if __name__ == "__main__":
    sys.exit(main())
