"""Run the benchmark of design, print its table, write out/bench/bench-design.json."""

import sys

from bench.groups import main

OPTIONS = {"count": (20, "random requests"), "seed": (0, "of what is drawn")}

if __name__ == "__main__":
    sys.exit(main("design", "From materials to actuators that do what was wanted.", OPTIONS))
