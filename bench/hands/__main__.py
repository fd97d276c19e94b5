"""Hidden effects of hands: `python -m bench.hands` makes the sets, diagnoses them, prints Markdown.

Criteria, fixed before the first run: a set is *right* if the verdict is effects_missing with one
effect, the hidden one at its place; *tied* if the hidden one is among what is tied with it; else
*wrong* if something is named. Nothing hidden must be adequate, what is outside of the catalogue
unexplained. In a negative control (markers or pressures shuffled, another hand's model) nothing
must be named, and the model must not be adequate. A verdict is *sure* if it has a confidence that
is no guess. Of a right one with a single parameter, the 95 % interval must hold the hidden value.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np

from bench.hands.cases import HIGHEST, PLAN, SEED, Hidden, hidden_in
from bench.hands.measure import HAND, measured
from model_lab.diagnosis.diagnose import diagnose
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import settled_hand
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model

SEGMENTS_COMPARED, FINE, CONVERGENCE_POSES = (5, 20), 80, 72


def main() -> None:
    """Run the whole plan, or the cases of the numbers given, and print a row for each and sums."""
    for segments in SEGMENTS_COMPARED:
        error = 1e3 * error_of_segments(segments)
        print(f"{segments} segments an actuator: tips {error:.2f} mm (rms) from those of {FINE}")
    chosen = [int(text) for text in sys.argv[1:]] or range(len(PLAN))
    print("| # | hidden | where | verdict | named | before, after, floor [mm] | s | score |")
    print("|---|---|---|---|---|---|---|---|")
    scores: dict[str, list[str]] = {}
    sure, holds = 0, []
    for number in chosen:
        random = np.random.default_rng(SEED + number)
        hidden = hidden_in(load_hand(HAND), *PLAN[number], random)
        data = measured(hidden, random)
        begun = time.monotonic()
        answer = diagnose(data, load_model()).diagnosis.as_json()
        took = time.monotonic() - begun
        score = scored(hidden, answer)
        sure += score == "wrong" and answer["confidence"] is not None and not answer["guess"]
        if score == "right" and hidden.value is not None:
            (parameter,) = answer["effects"][0]["parameters"].values()
            low, high = parameter["interval"]
            holds.append(low <= hidden.value <= high)
        scores.setdefault(_group(hidden), []).append(score)
        print(row_of(number, hidden, answer, took, score), flush=True)
    print("\n| group | sets | scores |\n|---|---|---|")
    for group, found in scores.items():
        counts = ", ".join(f"{found.count(one)} {one}" for one in sorted(set(found)))
        print(f"| {group} | {len(found)} | {counts} |")
    print(f"\nwrong and sure: {sure}; intervals that hold the truth: {sum(holds)} of {len(holds)}")


def error_of_segments(segments: int) -> float:
    """Distance [m], root mean square over drawn poses and tips, of the worst tip of the statics
    from that with FINE segments.
    """
    hand, random = load_hand(HAND), np.random.default_rng(SEED)
    pressures = random.uniform(0.0, 1.0, (CONVERGENCE_POSES, len(hand.channels))).T
    pressures *= np.array(HIGHEST)[:, None]
    down = random.standard_normal((CONVERGENCE_POSES, 3))
    pull = STANDARD_GRAVITY * down / np.linalg.norm(down, axis=1)[:, None]
    coarse, fine = (
        [
            body.point(shape, name, 1.0, np.zeros(3))
            for body, shape in settled_hand(hand, load_model(), count, pressures, pull)
            for name in body.joints
            if name in hand.tips
        ]
        for count in (segments, FINE)
    )
    square = np.sum(np.subtract(coarse, fine) ** 2, axis=2)
    return float(np.max(np.sqrt(np.mean(square, axis=1))))


def scored(hidden: Hidden, answer: dict[str, Any]) -> str:
    """Score of a verdict by the criteria above."""
    verdict, named = answer["verdict"], answer["effects"]
    if hidden.name == "nothing":
        return "right" if verdict == "adequate" else "wrong" if named else verdict
    if hidden.strength == "outside":
        return "right" if verdict == "unexplained" else "wrong" if named else verdict
    if hidden.strength == "control":
        return "wrong" if named else verdict if verdict == "adequate" else "right"
    if verdict != "effects_missing":
        return str(verdict)
    truth = hidden.name, hidden.where
    if len(named) == 1 and (named[0]["name"], named[0].get("where", {})) == truth:
        return "right"
    place = f"{hidden.name}[{'>'.join(hidden.where.values())}]" if hidden.where else hidden.name
    return "tied" if any(place in tied for tied in answer["tied"]) else "wrong"


def _group(hidden: Hidden) -> str:
    return hidden.strength or hidden.name


def row_of(number: int, hidden: Hidden, answer: dict[str, Any], took: float, score: str) -> str:
    """A row of the table: number, what is hidden, answer as JSON, time [s] and score."""
    named = "; ".join(
        f"{effect['name']} {'>'.join(effect.get('where', {}).values())} "
        + ", ".join(f"{key} {one['value']:.3g}" for key, one in effect["parameters"].items())
        for effect in answer["effects"]
    )
    errors = ", ".join(
        f"{1e3 * answer[key]:.2f}" for key in ("rmse_before", "rmse_after", "noise_floor")
    )
    cells = (
        number,
        f"{hidden.name} {hidden.strength}".strip(),
        ">".join(hidden.where.values()),
        answer["verdict"],
        named,
        errors,
        f"{took:.0f}",
        score,
    )
    return "| " + " | ".join(map(str, cells)) + " |"


if __name__ == "__main__":
    main()
