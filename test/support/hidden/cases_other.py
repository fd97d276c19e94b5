"""Cases beyond the catalogue's own equations: other forms, pairs, outside, one rate only."""

from __future__ import annotations

from itertools import product
from typing import Any

from hidden.case import Case, Expected
from hidden.cases_catalogue import BENDING, named
from hidden.protocols import ONE_RATE_SAMPLES

STIFFENING = ("gent_stiffening", "yeoh_stiffening")
FORMS: dict[str, tuple[tuple[str, ...], str]] = {  # in free bending: family, design
    "ogden": (STIFFENING, "standard"),
    "arruda_boyce": (STIFFENING, "standard"),
    "fung": (STIFFENING, "standard"),
    "two_modes": (("viscoelasticity",), "standard"),
    "power_law": (("viscoelasticity",), "standard"),
    "bouc_wen": (("hysteresis",), "standard"),
    "plays": (("hysteresis",), "standard"),
    "ogden_roxburgh": (("mullins_softening",), "recovered"),
    "second_order_tube": (("tube_lag",), "standard"),
    "orifice_tube": (("tube_lag",), "standard"),
    "soft_dead_zone": (("dead_zone",), "standard"),
    "curved_zero": (("pressure_offset",), "standard"),
    "arrhenius": (("temperature_modulus",), "temperatures"),
    "rational_rounding": (("section_rounding",), "standard"),
    "tip_heavy": (("gravity",), "mounts"),
    "rational_thick_wall": (("thick_wall",), "walls"),
    "cascaded_sensor": (("angle_sensor_lag",), "standard"),
}
PAIRS = (
    ("gent_stiffening", "tube_lag"),
    ("gent_stiffening", "angle_offset"),
    ("gent_stiffening", "dead_zone"),
    ("gent_stiffening", "temperature_modulus"),
    ("gent_stiffening", "gravity"),
    ("yeoh_stiffening", "angle_sensor_lag"),
    ("yeoh_stiffening", "pressure_offset"),
    ("viscoelasticity", "pressure_offset"),
    ("viscoelasticity", "dead_zone"),
    ("viscoelasticity", "angle_offset"),
    ("viscoelasticity", "temperature_modulus"),
    ("viscoelasticity", "gravity"),
    ("viscoelasticity", "section_rounding"),
    ("hysteresis", "pressure_offset"),
    ("hysteresis", "tube_lag"),
    ("hysteresis", "angle_offset"),
    ("hysteresis", "temperature_modulus"),
    ("mullins_softening", "tube_lag"),
    ("mullins_softening", "angle_offset"),
    ("thick_wall", "tube_lag"),
    ("dead_zone", "angle_sensor_lag"),
    ("temperature_modulus", "tube_lag"),
    ("gravity", "dead_zone"),
)
OUTSIDE = (
    "snap_through",
    "hard_saturation",
    "soft_saturation",
    "clock_drift",
    "clamp_slip",
    "gain_step",
    "two_leaks",
    "session_drift",
    "warming_sensor",
    "interference",
)
LOOPS: dict[str, dict[str, float]] = {  # memory too short for the samples to resolve
    "viscoelasticity": {"relaxation_time": 0.3},
    "tube_lag": {},
    "hysteresis": {"stretch_scale": 0.01},
}


def other_forms() -> list[Case]:
    """The same family in another functional form."""
    return [
        Case(
            f"form/free_bending/{law}/{word}",
            "other form",
            "free_bending",
            ((law, {}),),
            named(*family),
            ratio,
            {"design": design},
        )
        for (law, (family, design)), (word, ratio) in product(
            FORMS.items(), {"medium": 4.0, "strong": 8.0}.items()
        )
    ]


def pairs() -> list[Case]:
    """Two effects of different stages, each three times the floor alone."""
    return [
        Case(
            f"pair/free_bending/{first}+{second}",
            "pairs",
            "free_bending",
            ((first, {}), (second, {})),
            Expected("effects_missing", (frozenset({first}), frozenset({second}))),
            3.0,
            _design_for(first, second),
            noises=(0.002, 0.006),
        )
        for first, second in PAIRS
    ]


def _design_for(*effects: str) -> dict[str, Any]:
    special = {BENDING[effect] for effect in effects} - {"standard"}
    return {"design": special.pop() if special else "standard"}


def outside() -> list[Case]:
    """Nothing of the catalogue."""
    return [
        Case(
            f"outside/free_bending/{law}/{ratio:g}",
            "outside",
            "free_bending",
            ((law, {}),),
            Expected("unexplained"),
            ratio,
            {"adjacent": law == "session_drift"},
            noises=(0.002, 0.006),
        )
        for law, ratio in product(OUTSIDE, (3.0, 5.0, 10.0))
    ]


def one_rate() -> list[Case]:
    """Triangles of one rate: loops of different causes look alike (so does a sensor's lag)."""
    return [
        Case(
            f"one_rate/free_bending/{law}",
            "one rate",
            "free_bending",
            ((law, parameters),),
            Expected("effects_missing", (frozenset(LOOPS),), frozenset(LOOPS)),
            2.0,
            {"drives": "one_rate", "samples": ONE_RATE_SAMPLES},
            noises=(0.002, 0.006),
        )
        for law, parameters in LOOPS.items()
    ]
