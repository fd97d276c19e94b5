"""Every effect of the catalogue where it is visible, weak to strong; and nothing hidden."""

from __future__ import annotations

from typing import Any

from hidden.case import Case, Expected

RATIOS = {"weak": 2.0, "medium": 4.0, "strong": 10.0}
BENDING: dict[str, str] = {  # effect: design in which it shows
    "gent_stiffening": "standard",
    "yeoh_stiffening": "standard",
    "viscoelasticity": "standard",
    "tube_lag": "standard",
    "hysteresis": "standard",
    "mullins_softening": "recovered",
    "pressure_offset": "standard",
    "dead_zone": "standard",
    "section_rounding": "standard",
    "temperature_modulus": "temperatures",
    "gravity": "mounts",
    "thick_wall": "walls",
    "actuation_nonlinearity": "standard",
    "angle_offset": "standard",
    "angle_sensor_lag": "standard",
}


BLOCKED = {
    "pressure_offset": "standard",
    "pressure_gain": "standard",
    "tube_lag": "standard",
    "dead_zone": "standard",
    "section_rounding": "standard",
    "gauge_compliance": "standard",
    "tip_friction": "standard",
    "force_offset": "standard",
}
UNIAXIAL = {
    "gent_stiffening": "standard",
    "yeoh_stiffening": "standard",
    "mooney_rivlin": "standard",
    "viscoelasticity": "standard",
    "hysteresis": "standard",
    "mullins_softening": "recovered",
    "temperature_modulus": "temperatures",
}
VISIBLE = {"free_bending": BENDING, "blocked_tip": BLOCKED, "uniaxial": UNIAXIAL}


def named(*names: str) -> Expected:
    """One effect of these must be named."""
    return Expected("effects_missing", (frozenset(names),))


def single(experiment: str, effect: str, design: str) -> list[Case]:
    """One effect at the three strengths."""
    return [
        Case(
            f"{experiment}/{effect}/{word}",
            "catalogue",
            experiment,
            ((effect, {}),),
            named(effect),
            ratio,
            {"design": design},
        )
        for word, ratio in RATIOS.items()
    ]


def catalogue() -> list[Case]:
    """Every effect of the catalogue in the experiments where it is visible."""
    made = [
        case
        for experiment, effects in VISIBLE.items()
        for effect, design in effects.items()
        for case in single(experiment, effect, design)
    ]
    return [*made, _side_walls()]


def _side_walls() -> Case:
    """It has no strength of its own; at the highest noise it does not show."""
    return Case(
        "free_bending/side_wall_integral",
        "catalogue",
        "free_bending",
        (("side_wall_integral", {}),),
        named("side_wall_integral"),
        2.0,
        {"design": "walls"},
        noises=(0.002, 0.006),
    )


def nothing() -> list[Case]:
    """Nothing hidden, measured in several ways."""
    ways: dict[str, dict[str, Any]] = {
        "repeats": {},
        "no_repeats": {"repeats": 1, "runs": 6},
        "no_noise_key": {"with_noise": False},
        "no_noise_key_no_repeats": {"with_noise": False, "repeats": 1, "runs": 6},
        "few_runs": {"runs": 4},
        "correlated": {"correlation": 0.9},
        "without_time": {"with_time": False},
        "walls": {"design": "walls"},
        "temperatures": {"design": "temperatures"},
        "mounts": {"design": "mounts"},
        "tapered": {"design": "tapered"},
        "jitter": {"jitter": 0.01},
    }
    bending = [_nothing("free_bending", word, way) for word, way in ways.items()]
    others = [
        _nothing(experiment, word, ways[word])
        for experiment in ("blocked_tip", "uniaxial")
        for word in ("repeats", "no_repeats", "temperatures")
    ]
    return [*bending, *others]


def _nothing(experiment: str, word: str, way: dict[str, Any]) -> Case:
    name = f"nothing/{experiment}/{word}"
    return Case(name, "nothing", experiment, (), Expected("adequate"), None, way)
