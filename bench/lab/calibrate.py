"""Calibrate the confidence of verdicts: `python -m bench.lab.calibrate`.

Takes the sets that `bench.lab.gather` and `bench.lab.gather_others` have gathered: the model of
each verdict is fitted to five in seven of them, drawn by a checksum of their names, and what it
says is compared with what is right on the others, and so are the coefficients that are shipped.
Writes the coefficients into the lab (diagnosis/confidence.json), with where they come from, and the
reliability diagram (docs/figures/confidence.png); `--show` only prints. With `--on` it is fitted to
all gathered sets and shown on those of other files. Lines that `bench.lab` kept may be given, too;
families that are kept for blind runs are left out.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from scipy.optimize import minimize
from scipy.stats import spearmanr

from bench.hidden.reserved import is_reserved
from bench.kept import read
from bench.lab.gather import LINES
from bench.lab.reliability import (
    DRAWS,
    Bin,
    bins_of,
    calibration_error,
    error_by_chance,
    error_interval,
)
from bench.lab.scoring import REAL, SECOND_AUTHOR, right, wilson
from bench.lab.table import NOT_COUNTED
from model_lab.diagnosis import confidence
from model_lab.diagnosis.confidence import probability
from model_lab.diagnosis.result import UNEXPLAINED
from model_lab.rules import RULES

Array = np.ndarray
Record = Mapping[str, Any]
FORMAT = "softhand-confidence/1"
OUT = Path(confidence.__file__).with_name(confidence.FILE)
FIGURE = Path("docs/figures/confidence.png")
# Numbers of the evidence with the sign that the weight of each may have, 0 for either: the more
# error is left, the less sure is a verdict that the data are explained; what a calibration on its
# bound or an error as large as the outputs may be, is a slip that was not found.
TERMS: dict[str, dict[str, int]] = {
    "effects_missing": {
        "after": -1, "left": -1, "margin": 1, "lead": 1, "known": 1, "unusual": -1, "black_box": 1,
        "effects": -1, "ties": 0, "folds": 1, "repeats": 1, "at_bound": -1, "size": -1,
    },
    "adequate": {
        "before": -1, "proof": -1, "single": 0, "black_box_floor": 0, "folds": 1, "repeats": 1,
        "base_at_bound": -1,
    },
    "unexplained": {
        "before": 1, "after": 1, "single": 1, "black_box_floor": 0, "proven": 0, "folds": 1,
        "repeats": 1, "base_at_bound": -1, "size": -1,
    },
}  # fmt: skip
SHOWN, PARTS_OF_SETS = 2, 7  # parts that are not for the fit, of so many
RIDGES = (0.3, 1.0, 3.0, 10.0, 30.0)
PARTS = 5
FEWEST_RANKED = 5  # measurements
PRIOR = 1.0  # right and wrong verdicts more than were seen, half each
GUESSED = 0.2
REFUSED, LIMITS = 0.85, tuple(np.arange(0.5, 0.951, 0.05))


def for_the_fit(key: str) -> bool:
    """Whether a set, by its key, is for the fit."""
    return crc32(key.encode()) % PARTS_OF_SETS >= SHOWN


def answered(files: Sequence[Path]) -> list[Record]:
    """Gathered sets with one verdict each, in a fixed order."""
    kept = {key: record for lines in files for key, record in read(lines).items()}
    return [
        kept[key]
        for key in sorted(kept)
        if kept[key].get("answer")
        and kept[key]["row"] not in NOT_COUNTED
        and not is_reserved(kept[key].get("case", ""))
    ]


def verdict_of(record: Record) -> str:
    """The verdict that the confidence is of: where a slip is told, that on the data without it."""
    answer = record["answer"]
    return str(answer.get("verdict_mended") or answer["verdict"])


def _unexplained(record: Record) -> bool:
    """Whether a verdict says that nothing known explains the set. What was a guess by the
    coefficients of then tells nothing of new ones.
    """
    return verdict_of(record) == UNEXPLAINED


def model_of(records: Sequence[Record], terms: Mapping[str, int], ridge: float) -> dict[str, Any]:
    """Logistic model of the share right; the ridge is on the weights of scaled terms, whose signs
    are those of the terms.
    """
    seen = np.array([[r["answer"]["evidence"][name] for name in terms] for r in records], float)
    seen, true = seen.reshape(-1, len(terms)), np.array([right(r) for r in records], float)
    mean, scale = (
        (seen.mean(axis=0), seen.std(axis=0)) if len(seen) else (np.zeros(len(terms)),) * 2
    )
    scale = np.where(scale > 1e-6, scale, 1.0)
    weights = _fitted((seen - mean) / scale, true, ridge, list(terms.values()))
    low, high = (seen.min(axis=0), seen.max(axis=0)) if len(seen) else (mean, mean)
    columns = zip(terms, mean, scale, weights[1:], low, high, strict=True)
    return {
        "intercept": _short(weights[0]),
        "most": _short((len(true) + 1.0) / (len(true) + 2.0)),
        "terms": {
            name: dict(
                zip(("mean", "scale", "weight", "low", "high"), map(_short, rest), strict=True)
            )
            for name, *rest in columns
        },
    }


def _short(value: float) -> float:
    return round(float(value), 4)


def _fitted(scaled: Array, true: Array, ridge: float, signs: Sequence[int]) -> Array:
    """Intercept and weights of the greatest penalised likelihood; signs: of weights, 0 for any."""
    bounds = [(None, None), *((0 if sign > 0 else None, 0 if sign < 0 else None) for sign in signs)]
    design = np.hstack([np.ones((len(scaled), 1)), scaled])

    def loss(weights: Array) -> tuple[float, Array]:
        total = design @ weights
        more = PRIOR / 2 * (2 * np.logaddexp(0, weights[0]) - weights[0])
        value = np.sum(np.logaddexp(0, total) - true * total) + more
        slope = design.T @ (_share(total) - true) + ridge * np.append(0.0, weights[1:])
        slope[0] += PRIOR * (_share(weights[0]) - 0.5)
        return value + ridge / 2 * np.sum(weights[1:] ** 2), slope

    return minimize(loss, np.zeros(design.shape[1]), jac=True, method="L-BFGS-B", bounds=bounds).x


def _share(total: Array | float) -> Array:
    return 1.0 / (1.0 + np.exp(-np.asarray(total)))


def held_out(records: Sequence[Record], terms: Mapping[str, int], ridge: float) -> Array:
    """Probabilities (records,), each by a model that has not seen the set."""
    part = np.arange(len(records)) % PARTS
    said = np.zeros(len(records))
    for number in range(PARTS):
        others = [r for r, at in zip(records, part, strict=True) if at != number]
        model = model_of(others, terms, ridge)
        for index in np.flatnonzero(part == number):
            said[index] = probability(model, records[index]["answer"]["evidence"])
    return said


def best_ridge(records: Sequence[Record], terms: Mapping[str, int]) -> float:
    """The ridge of the least loss on sets that the model has not seen."""

    def loss(ridge: float) -> float:
        said = held_out(records, terms, ridge)
        true = np.array([right(r) for r in records], bool)
        return float(-np.sum(np.log(np.where(true, said, 1.0 - said))))

    return min(RIDGES, key=loss)


def limit_of(records: Sequence[Record], said: Array) -> float:
    """The least limit below which a verdict is a guess, so that of the wrong ones enough are
    refused: said as a guess, or as unexplained. It calls no more of the right ones guesses than
    are allowed.
    """
    pairs = list(zip(records, said, [right(record) for record in records], strict=True))
    wrong = [(record, p) for record, p, fine in pairs if not fine]
    found = LIMITS[0]
    for limit in LIMITS:
        if np.mean([p < limit for _, p, fine in pairs if fine] or [0.0]) > GUESSED:
            break
        found = limit
        if np.mean([p < limit or _unexplained(record) for record, p in wrong] or [1.0]) >= REFUSED:
            break
    return _short(found)


def fitted(records: Sequence[Record]) -> dict[str, Any]:
    """Models of all verdicts and the limit of guesses."""
    models, said = {}, {}
    for verdict, terms in TERMS.items():
        mine = [record for record in records if verdict_of(record) == verdict]
        ridge = best_ridge(mine, terms)
        models[verdict] = {"sets": len(mine), "right": sum(map(right, mine)), "ridge": ridge}
        models[verdict] |= model_of(mine, terms, ridge)
        for record, p in zip(mine, held_out(mine, terms, ridge), strict=True):
            said[record["key"]] = p
    order = np.array([said[record["key"]] for record in records])
    seen = dict(Counter(record["experiment"] for record in records))
    return {"limit": limit_of(records, order), "experiments": seen, "verdicts": models}


def author_of(record: Record) -> str:
    """Who made a set."""
    if record["row"].startswith(SECOND_AUTHOR):
        return SECOND_AUTHOR
    return "measurements" if record["row"] == REAL else "bench/hidden"


def shown(
    records: Sequence[Record], found: Mapping[str, Any], whole: bool = True
) -> dict[str, Any]:
    """What the models say of other sets, beside what is right; whole: with intervals and bins."""
    said = [_stated(record, found) for record in records]
    true = [right(record) for record in records]
    pairs = list(zip(records, said, true, strict=True))
    wrong = [p < found["limit"] or _unexplained(record) for record, p, fine in pairs if not fine]
    guessed = [p < found["limit"] for _, p, fine in pairs if fine]
    error, by_chance = _short(calibration_error(said, true)), _short(error_by_chance(said))
    head = {"sets": len(records), "right": sum(true), "error": error, "by_chance": by_chance}
    if not whole:
        return head
    return head | {
        "interval": [_short(end) for end in error_interval(said, true)],
        "refused_of_wrong": [sum(wrong), len(wrong)],
        "guesses_of_right": [sum(guessed), len(guessed)],
        "bins": [vars(each) for each in bins_of(said, true)],
    }


def compared(records: Sequence[Record], found: Mapping[str, Any]) -> str:
    """How well coefficients, with their limit of guesses, tell right verdicts from wrong ones."""
    said = np.array([_stated(record, found) for record in records])
    true = np.array([right(record) for record in records], bool)
    sure = [
        not fine and p >= found["limit"] and not _unexplained(record)
        for record, p, fine in zip(records, said, true, strict=True)
    ]
    return (
        f"Brier score {np.mean((said - true) ** 2):.4f}, calibration error "
        f"{calibration_error(said, true):.3f}, wrong and sure {sum(sure)} of {len(records)}, right "
        f"ones called a guess {np.sum(true & (said < found['limit']))} of {true.sum()}"
    )


def gain(records: Sequence[Record], new: Mapping[str, Any], old: Mapping[str, Any]) -> list[float]:
    """By how much new coefficients lower the Brier score of old ones, with the ends of its 95 %
    bootstrap interval over the sets.
    """
    true = np.array([right(record) for record in records], float)
    squares = [
        (np.array([_stated(record, found) for record in records]) - true) ** 2
        for found in (old, new)
    ]
    lower = squares[0] - squares[1]
    drawn = np.random.default_rng(0).integers(len(lower), size=(DRAWS, len(lower)))
    ends = np.quantile(lower[drawn].mean(axis=1), [0.025, 0.975])
    return [_short(value) for value in (lower.mean(), *ends)]


def _stated(record: Record, found: Mapping[str, Any]) -> float:
    return probability(found["verdicts"][verdict_of(record)], record["answer"]["evidence"])


def rank_of_measurements(records: Sequence[Record], found: Mapping[str, Any]) -> list[float]:
    """Rank correlation of confidence with error over floor over measurements by others and their
    parts that are said to be explained, and how many these are; above 0 the worst fits would be the
    surest.
    """
    real = [r for r in records if r["row"] == REAL and verdict_of(r) != UNEXPLAINED]
    said = [_stated(record, found) for record in real]
    left = [r["answer"]["evidence"][_judged_error(r)] for r in real]
    if len(real) < FEWEST_RANKED:
        return [0.0, len(real)]
    return [_short(spearmanr(said, left).statistic), len(real)]


def _judged_error(record: Record) -> str:
    """The evidence that holds the error which a verdict leaves."""
    return "after" if record["answer"]["effects"] else "before"


def words_of(document: Mapping[str, Any]) -> str:
    """Coefficients in words: what they were fitted to, and how they did on other sets."""
    fit, proof = document["fitted_to"], document["shown_on"]
    if min(fit["sets"], proof["sets"]) < RULES.confidence_sets:
        return "Too few sets are gathered yet: no confidence is stated."
    low, high = proof["interval"]
    refused_, wrong = proof["refused_of_wrong"]
    guessed, fine = proof["guesses_of_right"]
    seen = document["experiments"].items()
    experiments = ", ".join(f"{count} of {name}" for name, count in seen)
    rank, measured = proof["rank_of_measurements"]
    authors = "; ".join(
        f"{author} {one['error']:.3f} over {one['sets']} sets ({one['by_chance']:.3f} if exact)"
        for author, one in proof["authors"].items()
    )
    lines = ["| verdict | sets fitted to | of these right |", "| --- | --- | --- |"]
    for verdict, model in document["verdicts"].items():
        lines.append(f"| `{verdict}` | {model['sets']} | {model['right']} |")
    text = (
        f"Fitted to {fit['sets']} sets ({experiments}), shown on {proof['sets']} others: "
        f"expected calibration error {proof['error']:.3f} (95 % interval {low:.3f} to {high:.3f}; "
        f"so many sets would have {proof['by_chance']:.3f} if the confidence held exactly). Below "
        f"{document['limit']:.2f} it is a guess: {refused_} of {wrong} wrong verdicts were refused "
        "(as a guess, or since nothing known explained the set), and "
        f"{guessed} of {fine} right ones were called a guess too. Over {measured} measurements by "
        "others, and parts of them, that are said to be explained, confidence fitted without them "
        f"has a rank correlation of {rank:+.2f} with error over floor. Calibration error by "
        f"author: {authors}."
    )
    return "\n".join([*lines, "", text])


def draw(found: Mapping[str, Any], path: Path) -> None:
    """The reliability diagram."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    bins = [Bin(**each) for each in found["bins"]]
    figure, axes = pyplot.subplots(figsize=(4.2, 4.2), dpi=150, layout="constrained")
    axes.plot([0, 1], [0, 1], color="0.6", linewidth=1)
    for each in bins:
        low, high = wilson(each.hits, each.count)
        axes.plot([each.stated] * 2, [low, high], color="C0", linewidth=1.5)
        share = each.hits / each.count
        axes.plot(each.stated, share, "o", color="C0")
        side, align = (-6, "right") if each.stated > 0.5 else (6, "left")
        axes.annotate(f"{each.count}", (each.stated, share), (side, 4), ha=align,
                      textcoords="offset points", fontsize=8)  # fmt: skip
    low, high = found["interval"]
    axes.set_title(
        f"{found['sets']} other sets\ncalibration error {found['error']:.3f} "
        f"({low:.3f} to {high:.3f})",
        fontsize=9,
    )
    axes.set(
        xlim=(-0.03, 1.06),
        ylim=(-0.03, 1.06),
        xlabel="confidence stated",
        ylabel="share of verdicts right",
    )
    figure.savefig(path)
    pyplot.close(figure)


def main(arguments: list[str] | None = None) -> int:
    """Fit, show, write."""
    parser = argparse.ArgumentParser(
        prog="bench.lab.calibrate", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--lines", type=Path, nargs="+", default=[LINES], help="gathered sets")
    parser.add_argument("--show", action="store_true", help="print, write nothing")
    parser.add_argument("--shipped", action="store_true", help="only tell of what is shipped")
    parser.add_argument("--on", type=Path, nargs="+", default=[], help="sets to show it on")
    chose = parser.parse_args(arguments)
    if chose.shipped:
        print(words_of(json.loads(OUT.read_text())))
        return 0
    records = answered(chose.lines)
    used = [r for r in records if chose.on or for_the_fit(r["key"])]
    others = answered(chose.on) if chose.on else [r for r in records if not for_the_fit(r["key"])]
    found = fitted(used)
    without = fitted([record for record in used if record["row"] != REAL])
    proof = shown(others, found) | {
        "authors": {
            author: shown([r for r in others if author_of(r) == author], found, False)
            for author in sorted(set(map(author_of, others)))
        },
        "rank_of_measurements": rank_of_measurements(records, without),
    }
    head = {
        "format": FORMAT,
        "made_by": "python -m bench.lab.gather and gather_others, then bench.lab.calibrate",
        "fitted_to": _rows(used),
        "shown_on": _rows(others) | proof,
        "revisions": dict(Counter(record["revision"] for record in records)),
    }
    for name, value in (proof | {"limit": found["limit"]}).items():
        print(f"{name}: {value}")
    for name, document in (("fitted", found), ("shipped", confidence.calibration())):
        print(f"{name}, on the others: {compared(others, document)}")
    print(f"gain in Brier score, with interval: {gain(others, found, confidence.calibration())}")
    for author in sorted(set(map(author_of, records))):
        mine = [record for record in records if author_of(record) == author]
        fine = f"{sum(map(right, mine))} right"
        print(f"shipped, all of {author}: {fine}, {compared(mine, confidence.calibration())}")
    if not chose.show:
        OUT.write_text(json.dumps({**head, **found}, indent=1) + "\n")
        draw(proof, FIGURE)
        print(f"bench.lab.calibrate: written to {OUT} and {FIGURE}")
    return 0


def _rows(records: Sequence[Record]) -> dict[str, Any]:
    rows = Counter(record["row"] for record in records)
    return {"sets": len(records), "rows": dict(sorted(rows.items()))}


if __name__ == "__main__":
    sys.exit(main())
