"""Sets with a hidden effect, in its own form or another, with two, with none or a stranger."""

from pathlib import Path

import numpy as np

from . import pulses
from .hidden import hide
from .rig import Rig, new_rig, record, scarce, write
from .truth import Truth

KINDS = ("effect", "form", "two", "none", "outside")
SHARES = (0.42, 0.22, 0.1, 0.16, 0.1)
EXPERIMENTS = ("free_bending", "blocked_tip", "uniaxial", "valve_pulse")
EXPERIMENT_SHARES = (0.7, 0.1, 0.1, 0.1)


def make(seed: int, folder: Path) -> Truth:
    """Write the set of a seed into the folder and return its truth."""
    rng = np.random.default_rng([seed, 1])
    kind = str(rng.choice(KINDS, p=SHARES))
    experiment = str(rng.choice(EXPERIMENTS, p=EXPERIMENT_SHARES))
    if experiment == "valve_pulse":
        return pulses.make(rng, folder, hidden=kind != "none")
    if experiment != "free_bending" and kind != "none":
        kind = "effect"
    rig, truth = with_hidden(rng, experiment, kind)
    record(rig, rng)
    write(rig, folder)
    return truth


def with_hidden(
    rng: np.random.Generator, experiment: str, kind: str, **choices: int
) -> tuple[Rig, Truth]:
    """A rig that shows a hidden effect of the kind; `choices` go to `new_rig`."""
    while True:
        rig = new_rig(rng, experiment, **choices)
        if kind == "none" and not choices and rng.random() < 0.2:
            rig = scarce(rig, int(rng.integers(1, 3)))
        try:
            return rig, hide(rng, rig, kind)
        except ValueError:  # it does not show in this one
            continue
