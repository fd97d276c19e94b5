"""Make the second author's sets, let the lab diagnose them and count.

python -m bench.second_author --kind series --sets 80 --seed 100
"""

import argparse
import tempfile
from collections.abc import Iterable
from pathlib import Path

from bench.lab.reliability import calibration_error, error_by_chance, error_interval

from . import generator, series_faults, slip_sets
from .score import BINS, Score, diagnose, score, stated

LEVEL = 0.95
MAKERS = {"forms": generator.make, "series": series_faults.make, "slips": slip_sets.make}
OUTCOMES = {
    "right": "right",
    "sure": "wrong and sure",
    "guess": "wrong, said as a guess",
    "refused": "refused",
}


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.second_author", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--kind", choices=MAKERS, help="kind of sets (default: all)")
    parser.add_argument("--sets", type=int, default=10, help="of each kind (default: 10)")
    parser.add_argument("--seed", type=int, default=100, help="of the first set (default: 100)")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="folder in which the sets stay")
    options = parser.parse_args()
    for kind in [options.kind] if options.kind else MAKERS:
        with tempfile.TemporaryDirectory() as folder:
            seeds = range(options.seed, options.seed + options.sets)
            _report(kind, run(kind, seeds, options.keep or Path(folder)))


def run(kind: str, seeds: Iterable[int], folder: Path) -> list[Score]:
    """Make, diagnose and score the sets of a kind; one line is printed for each."""
    scores = []
    for seed in seeds:
        place = folder / f"{kind}_{seed}"
        truth = MAKERS[kind](seed, place)
        scores.append(score(truth, diagnose(place)))
        one = scores[-1]
        print(
            f"{kind} {seed:4d}  {one.outcome:8s} {one.confidence:5.2f}  "
            f"{truth.label} {' '.join(truth.runs)} <- {one.said}",
            flush=True,
        )
    return scores


def _report(kind: str, scores: list[Score]) -> None:
    print(f"\n{kind}: {len(scores)} sets")
    for outcome, words in OUTCOMES.items():
        _row(words, [s.outcome == outcome for s in scores], "<= 2 %" if outcome == "sure" else "")
    faults = [s for s in scores if s.truth.event and not s.truth.slip]
    slips = [s for s in scores if s.truth.slip]
    both = [s for s in slips if s.truth.effects]
    clean = [s for s in scores if not s.truth.slip and not s.truth.event]
    if kind == "series":
        _row("right run or event named", [s.found for s in faults], ">= 80 %")
        _row("adequate beside a fault", [s.adequate for s in faults], "none")
    if kind == "slips":
        _row("slip found", [s.found for s in slips], ">= 90 %")
        _row("slip and effect named", [s.outcome == "right" for s in both], ">= 75 %")
    _row("slip told where none is", [s.false_alarm for s in clean], "<= 1 %")
    _row("intervals that hold the truth", [held for s in scores for held in s.held], ">= 90 %")
    said, right = stated(scores)
    error, (low, high) = calibration_error(said, right, BINS), error_interval(said, right, BINS)
    chance, most = error_by_chance(said, BINS), error_by_chance(said, BINS, LEVEL)
    print(
        f"  {'calibration error':32s} {len(said):10d} {100 * error:7.1f} %   target <= 5 %; 95 % "
        f"interval {100 * low:.1f} to {100 * high:.1f}\n"
        f"  {'  if the confidence held exactly':43s} {100 * chance:7.1f} %   in 19 of 20 times "
        f"<= {100 * most:.1f} %; {len(scores) - len(said)} without one\n"
    )


def _row(words: str, hits: list[bool], target: str) -> None:
    if hits:
        told = f"   target {target}" if target else ""
        share = 100 * sum(hits) / len(hits)
        print(f"  {words:32s} {sum(hits):3d} of {len(hits):3d} {share:5.0f} %{told}")


if __name__ == "__main__":
    main()
