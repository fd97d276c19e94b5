"""How sure a verdict is: the share of such verdicts that are right, by what they rest on.

A logistic model for each verdict, over numbers of `diagnosis.evidence`. Its coefficients, and where
they come from, stand in confidence.json, which `python -m bench.lab.calibrate` writes from sets
with hidden effects; of a set it uses the evidence alone. Where too few sets of an experiment
or with a verdict were seen, nothing is said.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

import numpy as np

from model_lab.rules import RULES

FILE = "confidence.json"


@dataclass(frozen=True)
class Confidence:
    """Probability (0 to 1) that a verdict is right, None where it is not known; a guess where it is
    below the limit. beyond: numbers of the evidence that lie beyond those of all sets that were
    seen: then the probability is not known.
    """

    value: float | None
    guess: bool = False
    beyond: tuple[str, ...] = ()


def confidence_of(
    experiment: str,
    verdict: str,
    evidence: Mapping[str, float],
    most: float = 1.0,
    at_bound: bool = False,
) -> Confidence:
    """Confidence in a verdict, at most `most`; where it is not known and the calibration stays on a
    bound, a guess: on seeds 500 to 545 and 700 to 745 of `bench.second_author --kind slips` all
    three such verdicts were wrong.
    """
    known = calibration()
    model = known["verdicts"][verdict]
    if min(model["sets"], known["experiments"].get(experiment, 0)) < RULES.confidence_sets:
        return Confidence(None)
    value = min(probability(model, evidence), most)
    guess = value < known["limit"]
    outside = beyond(model, evidence)
    return (
        Confidence(None, guess or at_bound, outside)
        if outside
        else Confidence(round(value, 3), guess)
    )


def beyond(model: Mapping[str, Any], evidence: Mapping[str, float]) -> tuple[str, ...]:
    """Numbers of the evidence that lie clearly beyond the ends between which they were seen.

    >>> term = {"scale": 0.1, "low": 0.0, "high": 1.0}
    >>> beyond({"terms": {"left": term, "after": term}}, {"left": 1.5, "after": 1.05})
    ('left',)
    """
    return tuple(
        name
        for name, term in model["terms"].items()
        if max(term["low"] - evidence[name], evidence[name] - term["high"])
        > RULES.confidence_beyond * term["scale"]
    )


def probability(model: Mapping[str, Any], evidence: Mapping[str, float]) -> float:
    """Probability by one logistic model: intercept, and of each number of the evidence its mean,
    scale and weight, and the ends (low, high) between which it was seen; nothing beyond counts.

    >>> term = {"mean": 1.0, "scale": 2.0, "weight": 3.0, "low": 0.0, "high": 1.0}
    >>> probability({"intercept": 0.0, "terms": {"left": term}, "most": 0.99}, {"left": 7.0})
    0.5
    """
    total = float(model["intercept"])
    for name, term in model["terms"].items():
        seen = np.clip(evidence[name], term["low"], term["high"])
        total += term["weight"] * (seen - term["mean"]) / term["scale"]
    value = 1.0 / (1.0 + np.exp(-total))
    return float(np.clip(value, 1.0 - model["most"], model["most"]))


@lru_cache(maxsize=1)
def calibration() -> dict[str, Any]:
    """The shipped coefficients."""
    text = files("model_lab.diagnosis").joinpath(FILE).read_text()
    found: dict[str, Any] = json.loads(text)
    return found
