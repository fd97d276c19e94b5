"""`python -m thesis.chapter_4 NAME`: one experiment."""

import sys

from thesis.chapter_4.command import main

if __name__ == "__main__":
    sys.exit(main())
