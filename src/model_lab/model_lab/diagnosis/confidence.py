"""How sure a verdict is: the share of verdicts on similar evidence that are right.

A logistic model for each verdict, over numbers of `diagnosis.evidence`. Its coefficients, and where
they come from, stand in confidence.json, which `python -m bench.lab.calibrate` writes from sets
with hidden effects; of a set it uses the evidence alone. Where too few sets of an experiment or
with a verdict were seen, nothing is said.
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
    """How sure a verdict is.

    value: probability (0 to 1) that the verdict is right; None where it is not known. guess:
    whether this probability is so low that the verdict counts as a guess. beyond: names of the
    evidence that lies beyond its range in all sets with known answers, so that the probability is
    not known.
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
    """Confidence in a verdict, from the evidence for it.

    most: upper limit. at_bound: whether the calibration lies on a bound; if the probability is then
    not known, the verdict counts as a guess: on seeds 500 to 545 and 700 to 745 of
    `bench.second_author --kind slips` all three such verdicts were wrong.
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
    """Names of the evidence whose numbers lie clearly beyond the range (low, high) in which the
    model was calibrated.

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
    """Probability by one logistic model: an intercept, and for each number of the evidence its
    mean, scale and weight, and the range (low, high) to which the number is clipped.

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
    """The coefficients of the logistic models, from confidence.json."""
    text = files("model_lab.diagnosis").joinpath(FILE).read_text()
    found: dict[str, Any] = json.loads(text)
    return found
