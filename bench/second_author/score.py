"""What the lab says of a set, held against what is hidden in it."""

import json
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pint

from .truth import Truth

COMMAND = "import sys; from model_lab.cli.main import main; sys.exit(main())"
TIME_LIMIT = 900  # [s] for a diagnosis
DRIFTS = {"ageing", "sensor_drift"}
UNIT_TOLERANCE = 0.05
BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 1.0)  # of the confidence


@dataclass(frozen=True)
class Score:
    """One set: `outcome` is right, sure, guess (both wrong) or refused; the rest for shares.

    confidence: of the verdict, NaN if none was given. found: the slip or the run of a fault.
    false_alarm: a slip was told where none is. held: for each known value, whether the interval
    of the right effect holds it.
    """

    truth: Truth
    said: str
    outcome: str
    confidence: float
    adequate: bool
    found: bool
    false_alarm: bool
    held: tuple[bool, ...]


def diagnose(folder: Path) -> dict:
    """Diagnose the set by the command line; `{"verdict": "failed", "error": ...}` if it fails."""
    out = folder / "diagnosis.json"
    arguments = ["diagnose", str(folder), "--model", "base", "--json", str(out), "--force"]
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, *arguments, "--jobs", "1"],
        capture_output=True,
        text=True,
        timeout=TIME_LIMIT,
        check=False,
    )
    if done.returncode:
        lines = done.stderr.strip().splitlines() or ["no message"]
        return {"verdict": "failed", "error": lines[-1]}
    return json.loads(out.read_text())


def score(truth: Truth, answer: dict) -> Score:
    """Compare an answer of `diagnose` with the truth."""
    named = [{e["name"]} | tied for e, tied in zip(_effects(answer), _ties(answer), strict=True)]
    slips = answer.get("slips", [])
    found = found_slip(truth, slips) if truth.slip else found_run(truth, answer)
    right = _right(truth, answer, named, found)
    return Score(
        truth,
        _said(answer),
        "right" if right else _wrong(truth, answer),
        float(answer.get("confidence") or np.nan),
        answer["verdict"] == "adequate",
        found,
        bool(slips) and not truth.slip and not truth.event,
        _held(truth, answer),
    )


def _effects(answer: dict) -> list[dict]:
    return answer.get("effects", [])


def _ties(answer: dict) -> list[set[str]]:
    ties = [set(names) for names in answer.get("tied", [])]
    return ties + [set()] * (len(_effects(answer)) - len(ties))


def _right(truth: Truth, answer: dict, named: list[set[str]], found: bool) -> bool:
    verdict = answer["verdict"]
    told = bool(answer.get("slips")) or bool(answer.get("events"))
    if truth.event and not truth.slip:
        return found and verdict != "adequate"
    if truth.slip:
        return found and (not truth.effects or matches(truth.effects, named))
    if told:
        return False
    if truth.outside and verdict == "unexplained":
        return True
    if truth.effects:
        return verdict == "effects_missing" and matches(truth.effects, named)
    return verdict == "adequate"


def matches(hidden: Sequence[frozenset[str]], named: list[set[str]]) -> bool:
    """Whether the named effects (each with its ties) are the hidden ones, one for one."""
    if len(hidden) != len(named):
        return False
    if not hidden:
        return True
    return any(
        hidden[0] & one and matches(hidden[1:], named[:k] + named[k + 1 :])
        for k, one in enumerate(named)
    )


def _wrong(truth: Truth, answer: dict) -> str:
    if answer["verdict"] in ("unexplained", "failed"):
        return "refused"
    return "guess" if answer.get("guess", False) else "sure"


def found_slip(truth: Truth, slips: list[dict]) -> bool:
    """Whether the slip is told: the first one of the right name, unit and run."""
    first = slips[0] if slips else {}
    if first.get("name") != truth.slip:
        return False
    if truth.slip == "unit":
        said, fits = first.get("said"), first.get("fits")
        return abs(_size(fits) / _size(said) / truth.factor - 1) < UNIT_TOLERANCE
    return not truth.runs or _names_run(truth, [first])


def _size(unit: str) -> float:
    """Size of a unit in SI units, by pint as the file format has it."""
    registry = pint.get_application_registry()
    return float(registry.Quantity(1.0, unit).to_base_units().magnitude)


def found_run(truth: Truth, answer: dict) -> bool:
    """Whether the fault of a series is told: its run, or for a drift its kind."""
    events = answer.get("events", [])
    if truth.event == "drift":
        drifts = any(event.get("kind") == "drift" for event in events)
        return drifts or bool(DRIFTS & {effect["name"] for effect in _effects(answer)})
    kinds = {"odd_run", "exchanged"}
    slips = [slip for slip in answer.get("slips", []) if slip.get("name") in kinds]
    return bool(truth.event) and _names_run(truth, [*events, *slips])


def _names_run(truth: Truth, told: list[dict]) -> bool:
    """Whether the runs that are told are among the right ones, and at least one is.

    An event has a `run`; a slip of runs names them in the `column` that it is about, such as
    `specimen of run01 and run03`.
    """
    about = (one.get("run") or one.get("column", "") for one in told)
    runs = {name for text in about for name in re.findall(r"\br(?:un)?\d+\b", text)}
    return bool(runs) and runs <= set(truth.runs)


def _held(truth: Truth, answer: dict) -> tuple[bool, ...]:
    held = []
    for effect in _effects(answer):
        for name, value in truth.values.get(effect["name"], {}).items():
            told = effect["parameters"].get(name)
            if told and told.get("interval"):
                low, high = told["interval"]
                held.append(bool(low <= value <= high))
    return tuple(held)


def _said(answer: dict) -> str:
    parts = [slip["name"] for slip in answer.get("slips", [])]
    parts += [f"{e.get('kind')} at {e.get('run')}" for e in answer.get("events", [])]
    for effect, tied in zip(_effects(answer), _ties(answer), strict=True):
        parts.append("/".join([effect["name"], *sorted(tied)]))
    told = answer.get("error", " + ".join(parts))
    return f"{answer['verdict']}: {told}" if told else answer["verdict"]


def stated(scores: list[Score]) -> tuple[np.ndarray, np.ndarray]:
    """Confidences that were stated, and whether each verdict is right."""
    given = [s for s in scores if np.isfinite(s.confidence)]
    said = np.array([s.confidence for s in given], float)
    return said, np.array([s.outcome == "right" for s in given], bool)
