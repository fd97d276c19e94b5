"""Bench of `model-lab learn` on sets whose effect is outside of the catalogue, its place known.

`python -m bench.lab.learn [--seeds N N] [--only WORD ...]`: for every set the stage and axis that
were learned, held-out error over the floor, and in the end the shares that are right, with Wilson
intervals; written to out/bench/bench-learn.json. `bench.lab` does the same on seeds that nobody has
seen, as its row `learn`.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.hidden import make_set
from bench.hidden.case import seed_of
from bench.lab.scoring import wilson

OUT = Path("out/bench/bench-learn.json")
NEAR_FLOOR = 1.5  # held-out error over the floor
RATIO = 5.0  # error before over floor
NOISE = 0.006
WALLS, SHAPES = {"design": "walls"}, {"design": "shapes"}
WARM, TURN = {"design": "temperatures"}, {"adjacent": True}


@dataclass(frozen=True)
class Hidden:
    """What is hidden: a law, in which experiment and design, and at which stages it may be found
    against which axes.
    """

    law: str | None
    experiment: str
    stages: frozenset[str]
    axes: frozenset[str]
    options: dict[str, Any]

    row = "learn"
    noises = (NOISE,)

    @property
    def name(self) -> str:
        """Law, experiment and design."""
        design = self.options.get("design", "standard")
        return f"learn/{self.experiment}/{self.law or 'nothing'}/{design}"


def _case(law: str | None, experiment: str, stages: str, axes: str, **options: Any) -> Hidden:
    return Hidden(law, experiment, frozenset(stages.split()), frozenset(axes.split()), options)


BENDING, BLOCKED, TENSION = "free_bending", "blocked_tip", "uniaxial"
CASES = (
    _case("camera_gain", BENDING, "output", "output", **SHAPES),
    _case("arctan_saturation", BENDING, "output", "output", **SHAPES),
    _case("soft_saturation", BENDING, "output", "output"),
    _case("soft_saturation", BLOCKED, "output", "output"),
    _case("arctan_saturation", TENSION, "output", "output", **TURN),
    _case("rounded_band", BENDING, "input", "pressure", **WALLS),
    _case("rounded_band", BLOCKED, "input", "pressure"),
    _case("fading_gain", BENDING, "output", "run_order", **TURN),
    _case("fading_gain", TENSION, "output load", "run_order", **TURN),
    _case("square_warmth", BENDING, "load", "temperature", **WARM),
    _case("square_warmth", TENSION, "load output", "temperature", **WARM),
    _case("two_slopes", BENDING, "elastic structure", "output", **SHAPES),
    _case("two_slopes", TENSION, "elastic", "pressure output"),
    _case("tethered", BENDING, "structure elastic", "output", **SHAPES),
    _case("throttle", BENDING, "input", "pressure_rate direction"),
    _case("throttle", BLOCKED, "input", "pressure_rate direction"),
    _case("orifice_tube", BENDING, "input", "pressure_rate"),
    _case("creeping_reading", BENDING, "output", "time_since_step"),
    _case("warming_sensor", BENDING, "output", "time_since_step"),
    _case("gain_step", BENDING, "output structure", "pressure", **WALLS),
    _case(None, BENDING, "", ""),
    _case(None, BENDING, "", "", **WALLS),
    _case(None, TENSION, "", "", **WARM),
    _case(None, BLOCKED, "", ""),
)


def record_of(case: Hidden, seed: int) -> dict[str, Any]:
    """What is learned of one set, and what was hidden."""
    from model_lab.learning.learn import learn
    from model_lab.learning.result import learning_json
    from model_lab.measurements.load import load_measurements
    from softhand_model.model_file import load_model

    laws: list[tuple[str, dict[str, float]]] = [(case.law, {})] if case.law else []
    more = {"ratio": RATIO} if case.law else {}
    with tempfile.TemporaryDirectory(prefix="bench-learn-") as folder:
        number = seed_of(case.name.removeprefix("learn/"), seed)
        truth = make_set(
            Path(folder), case.experiment, laws, seed=number, noise=NOISE, **more, **case.options
        )
        data = load_measurements(Path(folder))
    started = time.perf_counter()
    answer = learning_json(learn(data, load_model("base")))
    seconds = time.perf_counter() - started
    return {"case": case.name, "seed": seed, "truth": truth, "answer": answer} | {
        "seconds": seconds,
        "right": right(case, answer),
        "tied": tied(case, answer),
        "near": near(case, answer),
    }


def right(case: Hidden, answer: dict[str, Any]) -> bool:
    """Whether stage and axis are those of the hidden law; none where nothing is hidden."""
    if case.law is None:
        return answer["stage"] is None
    return _is(case, answer)


def tied(case: Hidden, answer: dict[str, Any]) -> bool:
    """Whether it is right, or the right one is said to be tied with what is named."""
    others = [one for one in answer["alternatives"] if one["tied"]]
    return right(case, answer) or any(_is(case, one) for one in others)


def _is(case: Hidden, named: dict[str, Any]) -> bool:
    return named["stage"] in case.stages and named["against"] in case.axes


def near(case: Hidden, answer: dict[str, Any]) -> bool:
    """Whether the held-out error comes near the floor."""
    return bool(answer["rmse_after"] <= NEAR_FLOOR * answer["noise_floor"])


def records(only: list[str], seeds: range) -> Iterator[dict[str, Any]]:
    """Records of the cases whose names hold one of the words (all if none)."""
    for case in CASES:
        if not only or any(word in case.name for word in only):
            for seed in seeds:
                yield record_of(case, seed)


def line_of(record: dict[str, Any]) -> str:
    """One set in one line."""
    answer = record["answer"]
    floor = answer["noise_floor"]
    said = f"{answer['stage']} {answer.get('form')} {answer.get('against')}"
    errors = f"{answer['rmse_before'] / floor:.2f} -> {answer['rmse_after'] / floor:.2f} floors"
    ties = [f"{a['stage']}/{a['against']}" for a in answer["alternatives"] if a.get("tied")]
    return (
        f"{'ok ' if record['right'] else 'NO '} {record['case']:40s} seed {record['seed']} "
        f"{said:36s} {errors} {record['seconds']:.0f} s; tied: {', '.join(ties) or '-'}"
    )


def main(arguments: list[str] | None = None) -> int:
    """Learn from the sets, print, write."""
    parser = argparse.ArgumentParser(prog="bench.lab.learn", description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs=2, default=(0, 1), metavar=("FIRST", "END"))
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD")
    chose = parser.parse_args(arguments)
    found = []
    for record in records(chose.only, range(*chose.seeds)):
        found.append(record)
        print(line_of(record), flush=True)
    hidden = [r for r in found if r["truth"]["hidden"]]
    rows = []
    for name, hits in (
        ("stage and axis right", [r["right"] for r in hidden]),
        ("stage and axis right, or in the tie", [r["tied"] for r in hidden]),
        (f"held-out error <= {NEAR_FLOOR:g} floors", [r["near"] for r in hidden]),
        ("nothing hidden: nothing learned", [r["right"] for r in found if r not in hidden]),
    ):
        low, high = wilson(sum(hits), len(hits))
        rows.append({"name": name, "n": len(hits), "hits": sum(hits), "interval": [low, high]})
        print(f"{name}: {sum(hits)} of {len(hits)}, {100 * low:.0f} to {100 * high:.0f} %")
    OUT.parent.mkdir(parents=True, exist_ok=True)
    OUT.write_text(json.dumps({"rows": rows, "sets": found}, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
