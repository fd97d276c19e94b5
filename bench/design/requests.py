"""Random requests to an actuator: profiles of actuation ratio and stiffness."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from softhand_design.commands.design import USUAL_RUBBER, chosen_rubber
from softhand_design.requirements import RequirementError, Requirements
from softhand_design.sizing import Design, design_actuator
from softhand_model.hand.profile import TableProfile

LOW = (0.5e-3, 2e-3, 0.07)  # actuation ratio [1/(m Pa)], stiffness [N m2] at the base, length [m]
HIGH = (1.2e-3, 8e-3, 0.11)
MIDDLE = 0.15  # by which the ratio in the middle may lie off the line through its ends


def requests(seed: int) -> Iterator[Requirements]:
    """Requests without end, some of which nothing fulfils; about every second has a section of a
    chosen aspect, which varies along it, the others taper as P10.
    """
    random = np.random.default_rng(seed)
    rubber = chosen_rubber(USUAL_RUBBER, None, None, None)
    while True:
        ratio, stiffness, length = random.uniform(LOW, HIGH)
        tip, middle = random.uniform(0.6, 1.6), random.uniform(-MIDDLE, MIDDLE)
        x = (0.0, length / 2.0, length)
        ratios = ratio * np.array([1.0, (1.0 + tip) / 2.0 * (1.0 + middle), tip])
        softer = stiffness * random.uniform(0.15, 0.8)
        aspect = TableProfile((0.0, length), tuple(random.uniform(0.92, 1.08, 2).tolist()))
        yield Requirements(
            TableProfile(x, tuple(ratios.tolist())),
            TableProfile((0.0, length), (float(stiffness), float(softer))),
            float(length),
            rubber,
            aspect if random.random() < 0.5 else None,
        )


def feasible(count: int, seed: int) -> Iterator[Design]:
    """Designs of the first `count` requests that can be fulfilled."""
    found = 0
    for wanted in requests(seed):
        try:
            design = design_actuator(wanted, f"random_{found}")
        except RequirementError:
            continue
        yield design
        found += 1
        if found == count:
            return
