"""Cases beyond the catalogue's own equations: other forms, pairs, outside, one rate only."""

from __future__ import annotations

from itertools import product
from typing import Any

from hidden.case import Case, Expected
from hidden.cases_catalogue import VISIBLE, named
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
FORMS_BLOCKED: dict[str, tuple[tuple[str, ...], str]] = {
    "second_order_tube": (("tube_lag",), "standard"),
    "orifice_tube": (("tube_lag",), "standard"),
    "soft_dead_zone": (("dead_zone",), "standard"),
    "curved_zero": (("pressure_offset",), "standard"),
    "rational_rounding": (("section_rounding",), "standard"),
    "hardening_gauge": (("gauge_compliance",), "standard"),
    "smooth_tip_friction": (("tip_friction",), "standard"),
}
FORMS_UNIAXIAL: dict[str, tuple[tuple[str, ...], str]] = {
    "ogden": (STIFFENING, "standard"),
    "arruda_boyce": (STIFFENING, "standard"),
    "fung": (STIFFENING, "standard"),
    "gent_thomas": (("mooney_rivlin",), "standard"),
    "two_modes": (("viscoelasticity",), "standard"),
    "power_law": (("viscoelasticity",), "standard"),
    "bouc_wen": (("hysteresis",), "standard"),
    "plays": (("hysteresis",), "standard"),
    "ogden_roxburgh": (("mullins_softening",), "recovered"),
    "arrhenius": (("temperature_modulus",), "temperatures"),
}
ALL_FORMS = {"free_bending": FORMS, "blocked_tip": FORMS_BLOCKED, "uniaxial": FORMS_UNIAXIAL}
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
PAIRS_BLOCKED = (
    ("pressure_offset", "tip_friction"),
    ("tube_lag", "force_offset"),
    ("dead_zone", "tip_friction"),
    ("gauge_compliance", "tube_lag"),
)
PAIRS_UNIAXIAL = (
    ("gent_stiffening", "temperature_modulus"),
    ("viscoelasticity", "temperature_modulus"),
    ("hysteresis", "temperature_modulus"),
    ("yeoh_stiffening", "temperature_modulus"),
)
ALL_PAIRS = {"free_bending": PAIRS, "blocked_tip": PAIRS_BLOCKED, "uniaxial": PAIRS_UNIAXIAL}
FAULTS = (
    "hard_saturation",
    "soft_saturation",
    "clock_drift",
    "clamp_slip",
    "gain_step",
    "session_drift",
    "warming_sensor",
    "interference",
)
ALL_OUTSIDE = {
    "free_bending": ("snap_through", "two_leaks", *FAULTS),
    "blocked_tip": ("snap_through", "two_leaks", *FAULTS),
    "uniaxial": FAULTS,
}
RATIOS_OUTSIDE = {"free_bending": (3.0, 5.0, 10.0), "blocked_tip": (5.0,), "uniaxial": (5.0,)}
LOOPS: dict[str, dict[str, float]] = {  # memory too short for the samples to resolve
    "viscoelasticity": {"relaxation_time": 0.3},
    "tube_lag": {},
    "hysteresis": {"stretch_scale": 0.01},
}


def other_forms() -> list[Case]:
    """The same family in another functional form."""
    return [
        Case(
            f"form/{experiment}/{law}/{word}",
            "other form",
            experiment,
            ((law, {}),),
            named(*family),
            ratio,
            {"design": design},
        )
        for experiment, forms in ALL_FORMS.items()
        for (law, (family, design)), (word, ratio) in product(
            forms.items(), {"medium": 4.0, "strong": 8.0}.items()
        )
    ]


def pairs() -> list[Case]:
    """Two effects of different stages, each three times the floor alone."""
    return [
        Case(
            f"pair/{experiment}/{first}+{second}",
            "pairs",
            experiment,
            ((first, {}), (second, {})),
            Expected("effects_missing", (frozenset({first}), frozenset({second}))),
            3.0,
            _design_for(experiment, first, second),
            noises=(0.002, 0.006),
        )
        for experiment, both in ALL_PAIRS.items()
        for first, second in both
    ]


def _design_for(experiment: str, *effects: str) -> dict[str, Any]:
    special = {VISIBLE[experiment][effect] for effect in effects} - {"standard"}
    return {"design": special.pop() if special else "standard"}


def outside() -> list[Case]:
    """Nothing of the catalogue."""
    return [
        Case(
            f"outside/{experiment}/{law}/{ratio:g}",
            "outside",
            experiment,
            ((law, {}),),
            Expected("unexplained"),
            ratio,
            {"adjacent": law == "session_drift"},
            noises=(0.002, 0.006),
        )
        for experiment, laws in ALL_OUTSIDE.items()
        for law, ratio in product(laws, RATIOS_OUTSIDE[experiment])
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
