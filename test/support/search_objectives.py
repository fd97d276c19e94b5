"""Objectives of the tests of searches; workers import them by name."""

import os
import time
from pathlib import Path

from softhand_trials.search import objective

LEAST = {"x": 0.3, "y": -0.2}


@objective
def bowl(values, settings):
    """A bowl with its least at LEAST; in the folder `runs` a note for each evaluation that was
    really run.
    """
    if "runs" in settings:
        with (Path(settings["runs"]) / "notes").open("a") as file:
            file.write(f"{values['x']!r} {values['y']!r}\n")
    time.sleep(settings.get("wait", 0.0))
    return {
        "cost": sum((values[name] - LEAST[name]) ** 2 for name in LEAST),
        "process": os.getpid(),
    }


@objective
def half_failing(values, settings):
    """The same, where half of the space has no result."""
    if values["x"] < 0:
        raise RuntimeError("nothing there")
    return bowl(values, settings)


@objective
def without_cost(values, settings):
    """No cost at all."""
    return {"cost": float("nan")}


def not_marked(values, settings):
    """A function that no problem may name."""
    raise AssertionError


@objective
def ledge(values, settings):
    """Falls towards x = 1, beyond which it is high; `draw`: x is moved by thousandths."""
    x = values["x"] + 1e-3 * sum(settings.get("draw", ()))
    return {"cost": 1.0 - x if x < 1.0 else 50.0}
