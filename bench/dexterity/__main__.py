"""Run the benchmark of dexterity, print its table, write out/bench/bench-dexterity.json."""

import sys

from bench.groups import main

if __name__ == "__main__":
    sys.exit(main("dexterity", "RBO Hand 2: the Kapandji test, the Feix taxonomy.", {}))
