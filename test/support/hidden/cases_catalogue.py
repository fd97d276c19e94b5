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
    "actuation_nonlinearity": "walls",
    "angle_offset": "standard",
    "angle_sensor_lag": "standard",
}


def named(*names: str) -> Expected:
    """One effect of these must be named."""
    return Expected("effects_missing", (frozenset(names),))


def single(experiment: str, effect: str, design: str, prefix: str = "") -> list[Case]:
    """One effect at the three strengths."""
    return [
        Case(
            f"{prefix or experiment}/{effect}/{word}",
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
        for effect, design in BENDING.items()
        for case in single("free_bending", effect, design)
    ]
    made.append(_side_walls())
    return made


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
    return [
        Case(
            f"nothing/free_bending/{word}",
            "nothing",
            "free_bending",
            (),
            Expected("adequate"),
            None,
            way,
        )
        for word, way in ways.items()
    ]
