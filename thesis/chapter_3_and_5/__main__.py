"""`python -m thesis.chapter_3_and_5`, the same as `pneuflex-validate`."""

import sys

from thesis.chapter_3_and_5.command import main

sys.exit(main())
