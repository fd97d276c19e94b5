"""Cases whose sets cannot tell some effects apart, so that an experiment has to be proposed."""

from __future__ import annotations

from itertools import product

from hidden.case import Case, Expected
from hidden.cases_other import LOOPS
from hidden.laws import Parameters
from hidden.protocols import ONE_RATE_SAMPLES

RATES = {"drives": "one_rate", "samples": ONE_RATE_SAMPLES}
TIED: tuple[tuple[str, str, str, Parameters, dict[str, object]], ...] = (
    *(("one_rate", "free_bending", law, given, RATES) for law, given in LOOPS.items()),
    ("above", "free_bending", "pressure_offset", {}, {"drives": "above"}),
    ("above", "free_bending", "dead_zone", {}, {"drives": "above"}),
    ("above", "blocked_tip", "pressure_offset", {}, {"drives": "above"}),
    ("above", "blocked_tip", "dead_zone", {}, {"drives": "above"}),
    ("slow", "free_bending", "thick_wall", {}, {"drives": "slow"}),
    ("slow", "free_bending", "tube_lag", {}, {"drives": "slow"}),
    ("slow", "free_bending", "angle_sensor_lag", {}, {"drives": "slow"}),
)


def tied() -> list[Case]:
    """One effect, seen by too few kinds of runs."""
    return [
        Case(
            f"plan/{experiment}/{word}/{law}/{ratio:g}",
            "plan",
            experiment,
            ((law, dict(given)),),
            Expected("effects_missing", (frozenset({law}),)),
            ratio,
            options,
            noises=(0.002, 0.006),
        )
        for (word, experiment, law, given, options), ratio in product(TIED, (2.0, 4.0))
    ]
