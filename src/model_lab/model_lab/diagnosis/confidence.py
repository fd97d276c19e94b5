"""How sure a verdict is: the share of such verdicts that are right, by what they rest on.

A logistic model for each verdict, over numbers of `diagnosis.evidence`. Its coefficients, and where
they come from, stand in confidence.json, which `python -m bench.lab.calibrate` writes from sets
with hidden effects; it knows nothing of a set but its evidence. Where too few sets of an experiment
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

FILE = "confidence.json"
FEWEST = 10  # sets of an experiment, and of a verdict, below which nothing is said


@dataclass(frozen=True)
class Confidence:
    """Probability (0 to 1) that a verdict is right, None where it is not known; a guess where it is
    below the limit.
    """

    value: float | None
    guess: bool = False


def confidence_of(
    experiment: str, verdict: str, evidence: Mapping[str, float], most: float = 1.0
) -> Confidence:
    """How sure a verdict is, `most` at the most."""
    known = calibration()
    model = known["verdicts"][verdict]
    if min(model["sets"], known["experiments"].get(experiment, 0)) < FEWEST:
        return Confidence(None)
    value = min(probability(model, evidence), most)
    return Confidence(round(value, 3), value < known["limit"])


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
