"""`python -m model_lab` is `model-lab`."""

import sys

from model_lab.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
