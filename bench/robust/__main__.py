"""Run the benchmark of robustness, print its table, write out/bench/bench-robust.json."""

import sys

from bench.groups import main

OPTIONS = {
    "minutes": (5.0, "of the long rows"),
    "seed": (0, "of what is drawn"),
    "rounds": (5, "of grasps whose speed is measured"),
    "demos": (10, "beside busy loops"),
}

if __name__ == "__main__":
    sys.exit(main("robust", "Attack the nodes and see what holds.", OPTIONS))
