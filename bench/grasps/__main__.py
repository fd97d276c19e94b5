"""Run the benchmark of grasps, print its table, write out/bench/bench-grasps.json."""

import sys

from bench.groups import main

OPTIONS = {
    "seed": (0, "of what is drawn"),
    "jobs": (2, "processes of a sweep"),
    "minutes": (120.0, "after which a long group stops; started again, it goes on"),
}

if __name__ == "__main__":
    sys.exit(main("grasps", "Grasps that use the environment: maps, steps, rates.", OPTIONS))
