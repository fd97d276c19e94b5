"""Proposals of `plan`, played with each of the two effects that they are to part as the truth.

    .venv/bin/python -m bench.lab.played

Per set of `bench.hidden` that ends in a tie: the first two names of it are fitted to the set, each
predicts the proposed run, and with noise and scatter that prediction, twice, is what was measured.
Old and new runs are diagnosed together; the pair is parted if the truth is named and the other no
longer tied with it. Control: the first run of the set, measured again as often, must part fewer.

Stated before the first run: the sets (CASES, SEEDS) and the target (PARTED) that aim `plan` of
`bench.lab` has; nothing in the lab was set by these seeds.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from bench.command_line import command_line
from bench.hidden.ties import tied
from bench.lab.planning import REPEATS, group_with

if TYPE_CHECKING:
    from model_lab.measurements.measurement_set import MeasurementSet

CASES = tuple(case for case in tied() if case.ratio == 4.0)
SEEDS = (7311, 7312)
NOISE = 0.006  # of a sample over the largest reading, and scatter of whole runs, relative
PARTED = 0.9  # of the plays, at least
OUT = Path("out/bench/bench-played.json")
NEW = "again_"  # name of a repeated run


@dataclass(frozen=True)
class Played:
    """One proposal with one truth: whether it parts the pair, and whether repeats do."""

    case: str
    seed: int
    truth: str
    other: str
    planned: bool
    repeated: bool


def played(folder: Path, case: str, seed: int) -> Iterator[Played]:
    """Plays of the set in a folder; none if nothing is tied or nothing is said to part it."""
    import model_lab as lab
    from model_lab.report.text import write_template

    data = lab.load(folder).set
    answer = lab.diagnose(data).outcome.diagnosis.as_json()
    plan = answer["next_experiment"]
    if plan is None or not plan["breaks"]:
        return
    pair = plan["separates"][0][:2]
    rest = [effect["name"] for effect in answer["effects"] if effect["name"] not in pair]
    with tempfile.TemporaryDirectory(prefix="bench-lab-") as place:
        files = write_template(plan, data, Path(place))
        longer = _with_template(folder, files[0], files[1], Path(place) / "longer")
    for place_in_pair, (truth, other) in enumerate((pair, pair[::-1])):
        model = lab.add([*rest, truth], data)
        parts = []
        for new in (longer, _repeated(data)):
            random = np.random.default_rng([seed, place_in_pair])
            both = measured(data, lab.predict(new, model).set, random)
            parts.append(parted(lab.diagnose(both).outcome.diagnosis.as_json(), truth, other))
        yield Played(case, seed, truth, other, *parts)


def _with_template(folder: Path, course: Path, part: Path, longer: Path) -> MeasurementSet:
    """The set with the runs of a template, without outputs, as a user puts them into it."""
    import pandas as pd

    import model_lab as lab

    shutil.copytree(folder, longer)
    path = longer / "experiment.yaml"
    document, more = yaml.safe_load(path.read_text()), yaml.safe_load(part.read_text())
    document["specimens"] |= more.get("specimens", {})
    document["runs"] |= more["runs"]
    path.write_text(yaml.safe_dump(document, sort_keys=False))
    inputs = pd.read_csv(course)
    outputs = dict.fromkeys(set(more["columns"]) - set(inputs), 0.0)
    for entry in more["runs"].values():
        inputs.assign(**outputs).to_csv(longer / entry["file"], index=False)
    return lab.load(longer).set


def _repeated(data: MeasurementSet) -> MeasurementSet:
    """The set with its first run again."""
    again = [replace(data.runs[0], name=f"{NEW}{k}", virgin=False) for k in range(REPEATS)]
    return replace(data, runs=(*data.runs, *again))


def measured(
    data: MeasurementSet, predicted: MeasurementSet, random: np.random.Generator
) -> MeasurementSet:
    """The set, and behind it what was predicted of further runs, with scatter and noise."""
    new = []
    for run in predicted.runs[len(data.runs) :]:
        gain = 1.0 + NOISE * random.standard_normal()
        columns = dict(run.columns)
        for output in data.outputs:
            sigma = NOISE * max(float(np.abs(one.columns[output]).max()) for one in data.runs)
            columns[output] = gain * columns[output] + sigma * random.standard_normal(run.samples)
        new.append(replace(run, columns=columns))
    return replace(data, specimens=predicted.specimens, runs=(*data.runs, *new))


def parted(answer: Mapping[str, Any], truth: str, other: str) -> bool:
    """Whether an answer names the truth, and no longer ties the other with it."""
    group = group_with(answer, [truth])
    return group is not None and other not in group


def summary(plays: list[Played], sets: int) -> str:
    """Counts, with target and control as met or missed."""
    planned, repeated = sum(one.planned for one in plays), sum(one.repeated for one in plays)
    proposals = len({(one.case, one.seed) for one in plays})
    met = "met" if planned >= PARTED * len(plays) and plays else "MISSED"
    control = "met" if repeated < planned else "MISSED"
    return (
        f"played: {proposals} of {sets} sets with a proposal that is said to part a pair; parted "
        f"for the right side {planned} of {len(plays)} (target {PARTED:.0%}: {met}); by repeats of "
        f"an old run {repeated} (target fewer: {control})"
    )


def main() -> int:
    """Play, print each play and the summary, write."""
    command_line("bench.lab.played", __doc__).parse_args()
    plays: list[Played] = []
    for seed in SEEDS:
        for case in CASES:
            with tempfile.TemporaryDirectory(prefix="bench-lab-") as folder:
                case.make(Path(folder), seed, NOISE)
                found = list(played(Path(folder), case.name, seed))
            print(*(found or [f"{case.name}, seed {seed}: nothing proposed"]), sep="\n", flush=True)
            plays += found
    print(summary(plays, len(SEEDS) * len(CASES)))
    OUT.parent.mkdir(parents=True, exist_ok=True)
    OUT.write_text(json.dumps([vars(one) for one in plays], indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
