"""Effects hidden in the simulator and found from its recordings: `python -m bench.hands.over_ros`.

Criteria, fixed before the first run: three kinds of effects with three seeds each, by the command
`softhand hand-story`; *right* if the verdict names the hidden effect at its place and nothing else.
Wanted: 9 of 9, and the error falls to a third or less.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from bench.command_line import command_line
from softhand_bringup.lab_story.hand_story import HIDDEN_SIZES

SEEDS = (1, 2, 3)


def main() -> None:
    """Run all stories and print a row for each."""
    parser = command_line("bench.hands.over_ros", __doc__)
    parser.add_argument("seeds", nargs="*", type=int, help="default: %(default)s", default=SEEDS)
    seeds = parser.parse_args().seeds
    print("| hidden | seed | where | right | before, after, floor, simulator again [mm] | falls |")
    print("|---|---|---|---|---|---|", flush=True)
    for kind in HIDDEN_SIZES:
        for seed in seeds:
            print(row(kind, seed), flush=True)


def row(kind: str, seed: int) -> str:
    """Run one story; returns its row."""
    with tempfile.TemporaryDirectory() as folder:
        command = ("softhand_bringup.ros.hand_story", "--hide", kind, "--seed", str(seed))
        done = subprocess.run(
            [sys.executable, "-m", *command, "--out", folder], capture_output=True, text=True
        )
        if done.returncode != 0:
            return f"| {kind} | {seed} | | failed: {done.stdout.splitlines()[-1:]} | | |"
        found = json.loads((Path(folder) / "hand-story" / "result.json").read_text())
    keys = ("error_before", "error_after", "noise_floor", "error_simulated")
    errors = [1e3 * found.get(key, float("nan")) for key in keys]
    cells = (
        kind,
        seed,
        ">".join(found["hidden"]["where"].values()),
        "yes" if found["right"] else f"no: {found['diagnosis']['verdict']}",
        ", ".join(f"{error:.2f}" for error in errors),
        f"{errors[0] / errors[1]:.1f}",
    )
    return "| " + " | ".join(map(str, cells)) + " |"


if __name__ == "__main__":
    main()
