"""Effects that are hidden in the sets: their random parameters and the names that are right."""

from collections.abc import Callable

import numpy as np

from .physics import Effects
from .rig import Rig, floor, outputs
from .truth import Truth

VISIBLE = 5.0  # error of the calibrated base model over the noise from which an effect is hidden
TRIALS = 12  # draws of the parameters until it is visible

Draw = Callable[[np.random.Generator, Rig], dict[str, float]]


def top(rig: Rig) -> float:
    """Largest input of the session [SI]."""
    return max(run.corners[:, 1].max() for run in rig.runs)


def _duration(rig: Rig) -> float:
    return float(np.median([run.corners[-1, 0] for run in rig.runs]))


def _either_side(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.choice([-1, 1]) * rng.uniform(low, high))


BENDING: dict[str, Draw] = {
    "pressure_offset": lambda r, g: {"offset": _either_side(r, 0.05, 0.15) * top(g)},
    "pressure_gain": lambda r, g: {"gain": r.choice([r.uniform(0.55, 0.7), r.uniform(1.4, 1.7)])},
    "tube_lag": lambda r, g: {"time_constant": r.uniform(0.02, 0.08) * _duration(g)},
    "clock_offset": lambda r, g: {"offset": r.uniform(0.02, 0.06) * _duration(g)},
    "dead_zone": lambda r, g: {"threshold": r.uniform(0.06, 0.2) * top(g)},
    "section_rounding": lambda r, g: {
        "gain": r.uniform(0.25, 0.6),
        "pressure_scale": r.uniform(0.15, 0.5) * top(g),
    },
    "ballooning": lambda r, g: {
        "gain": r.uniform(0.5, 2.0),
        "onset": r.uniform(0.55, 0.85) * top(g),
        "sharpness": r.uniform(8, 30),
    },
    "chamber_contact": lambda r, g: {
        "gain": r.uniform(0.8, 3.0),
        "onset": r.uniform(0.35, 0.7) * top(g),
    },
    "gent_stiffening": lambda r, g: {"jm": r.uniform(2, 8)},
    "yeoh_stiffening": lambda r, g: {"c2": r.uniform(0.05, 0.3)},
    "thick_wall": lambda r, g: {"gain": r.uniform(2, 8)},
    "mullins_softening": lambda r, g: {
        "softening": r.uniform(0.15, 0.4),
        "stretch_scale": r.uniform(0.05, 0.4),
    },
    "viscoelasticity": lambda r, g: {
        "relative_modulus": r.uniform(0.1, 0.5),
        "relaxation_time": r.uniform(0.05, 0.2) * _duration(g),
    },
    "hysteresis": lambda r, g: {
        "relative_pressure": r.uniform(0.06, 0.2),
        "stretch_scale": r.uniform(0.02, 0.15),
    },
    "side_wall_integral": lambda r, g: {},
    "camera_perspective": lambda r, g: {
        "foreshortening": r.choice([r.uniform(0.6, 0.8), r.uniform(1.25, 1.6)])
    },
    "angle_sensor_lag": lambda r, g: {"time_constant": r.uniform(0.02, 0.08) * _duration(g)},
    "angle_offset": lambda r, g: {"offset": _either_side(r, 0.05, 0.15)},
    "sensor_drift": lambda r, g: {
        "rate": _either_side(r, 0.05, 0.15) * g.largest / _duration(g),
        "settling_time": r.uniform(0.3, 1.5) * _duration(g),
        "per_run": 0.0,
    },
    "saturation": lambda r, g: {"limit": r.uniform(0.65, 0.9) * g.largest},
    "ageing": lambda r, g: {"per_run": r.uniform(0.015, 0.03)},
    "gravity": lambda r, g: {"mass_scale": r.uniform(0.7, 1.5)},
}
FORCE: dict[str, Draw] = {
    "gauge_compliance": lambda r, g: {"stiffness": r.uniform(0.5, 3) * g.largest / 0.01},
    "tip_friction": lambda r, g: {"coefficient": r.uniform(0.05, 0.2)},
    "force_offset": lambda r, g: {"offset": _either_side(r, 0.05, 0.15) * g.largest},
    "pressure_gain": BENDING["pressure_gain"],
    "dead_zone": BENDING["dead_zone"],
    "tube_lag": BENDING["tube_lag"],
    "ballooning": BENDING["ballooning"],
    "saturation": BENDING["saturation"],
}
TENSION: dict[str, Draw] = {
    "gent_stiffening": lambda r, g: {"jm": r.uniform(1.5, 4) * (top(g) ** 2 + 2 / top(g) - 3)},
    "yeoh_stiffening": lambda r, g: {"c2": r.uniform(0.03, 0.2)},
    "mooney_rivlin": lambda r, g: {"c01_ratio": r.uniform(0.5, 2.5)},
    "mullins_softening": BENDING["mullins_softening"],
    "viscoelasticity": BENDING["viscoelasticity"],
    "saturation": BENDING["saturation"],
}
CATALOGUE = {"free_bending": BENDING, "blocked_tip": FORCE, "uniaxial": TENSION}

STIFFENING = frozenset({"gent_stiffening", "yeoh_stiffening", "arruda_boyce", "ogden"})
OTHER_FORMS: dict[str, tuple[frozenset[str], Draw]] = {
    "exponential_stiffening": (STIFFENING, lambda r, g: {"b": r.uniform(0.1, 0.4)}),
    "two_lags": (frozenset({"tube_lag", "growing_chamber_lag"}), BENDING["tube_lag"]),
    "soft_dead_zone": (
        frozenset({"dead_zone", "section_rounding"}),
        lambda r, g: {"threshold": r.uniform(0.08, 0.2) * top(g)},
    ),
    "rational_rounding": (frozenset({"section_rounding"}), BENDING["section_rounding"]),
    "logistic_ballooning": (
        frozenset({"ballooning"}),
        lambda r, g: {
            "gain": r.uniform(0.5, 2.0),
            "onset": r.uniform(0.55, 0.8) * top(g),
            "width": r.uniform(0.02, 0.08) * top(g),
        },
    ),
    "two_branches": (frozenset({"viscoelasticity", "creep"}), BENDING["viscoelasticity"]),
    "log_compliance": (
        frozenset({"creep", "viscoelasticity"}),
        lambda r, g: {"rate": r.uniform(0.05, 0.12), "onset_time": r.uniform(0.1, 1.0)},
    ),
    "stack_of_plays": (
        frozenset({"hysteresis"}),
        lambda r, g: {"share": r.uniform(0.3, 0.6), "width": r.uniform(0.05, 0.15)},
    ),
    "tanh_softening": (frozenset({"mullins_softening"}), BENDING["mullins_softening"]),
    "moving_average": (frozenset({"angle_sensor_lag"}), BENDING["angle_sensor_lag"]),
}
OUTSIDE: dict[str, tuple[frozenset[str], Draw]] = {
    "kink": (
        frozenset(),
        lambda r, g: {"loss": r.uniform(0.4, 0.8), "onset": r.uniform(0.45, 0.65) * top(g)},
    ),
    "mount_backlash": (
        frozenset({"hysteresis"}),
        lambda r, g: {"half_width": r.uniform(0.03, 0.08) * g.largest},
    ),
    "distorting_lens": (
        frozenset(),
        lambda r, g: {"height": r.uniform(0.04, 0.08), "period": r.uniform(0.6, 1.0)},
    ),
}
PAIRS = (
    ("gent_stiffening", "tube_lag"),
    ("angle_offset", "viscoelasticity"),
    ("dead_zone", "hysteresis"),
    ("ballooning", "angle_sensor_lag"),
    ("yeoh_stiffening", "mullins_softening"),
    ("section_rounding", "tube_lag"),
    ("chamber_contact", "hysteresis"),
)


def hide(rng: np.random.Generator, rig: Rig, kind: str, name: str | None = None) -> Truth:
    """Put a hidden effect of a kind into the rig, visibly, and say what is right.

    kind: `none`, `effect` (the catalogue's equation), `form` (another form of one), `two` or
    `outside`; name: of the effect, else drawn. Raises ValueError if no draw is visible.
    """
    if kind == "none":
        return Truth("nothing")
    catalogue = CATALOGUE[rig.experiment]
    if kind == "effect":
        name = name or str(rng.choice(_possible(rig, catalogue)))
        parameters = _visible(rng, rig, {name: catalogue[name]})
        return Truth(name, (frozenset({name}),), parameters)
    if kind == "two":
        pair = PAIRS[int(rng.integers(len(PAIRS)))]
        parameters = _visible(rng, rig, {one: BENDING[one] for one in pair})
        return Truth(" + ".join(pair), tuple(frozenset({one}) for one in pair), parameters)
    forms = OTHER_FORMS if kind == "form" else OUTSIDE
    name = name or str(rng.choice(list(forms)))
    names, draw = forms[name]
    _visible(rng, rig, {name: draw})
    return Truth(name, (names,) if names else (), outside=kind == "outside")


def _possible(rig: Rig, catalogue: dict[str, Draw]) -> list[str]:
    """Effects that these specimens and runs can show."""
    missing = set()
    if len(rig.true) < 2:
        missing.add("thick_wall")
    if all(finger.mount == "bending_plane_level" for finger in rig.true.values()):
        missing.add("gravity")
    if len(rig.runs) < 4:
        missing |= {"ageing", "mullins_softening"}
    return [name for name in catalogue if name not in missing]


def _visible(rng: np.random.Generator, rig: Rig, draws: dict[str, Draw]) -> Effects:
    """Draw the parameters until each effect shows beyond noise and calibration; set them."""
    for _ in range(TRIALS):
        effects = {
            name: {k: float(v) for k, v in draw(rng, rig).items()} for name, draw in draws.items()
        }
        full = outputs(rig, effects)
        rest = [{k: v for k, v in effects.items() if k != name} for name in effects]
        if all(left_over(rig, full, effects, less) > VISIBLE * floor(rig) for less in rest):
            rig.effects = effects
            return effects
    raise ValueError(f"{' + '.join(draws)}: expected it to show in {TRIALS} draws; draw a new rig")


def left_over(rig: Rig, full: list[np.ndarray], effects: Effects, less: Effects) -> float:
    """RMS [SI] between the outputs of all effects and those of fewer with the modulus refitted.

    What an effect on the pressure's reading does to the output is taken to first order.
    """
    errors = []
    for scale in np.linspace(0.8, 1.25, 10):
        pieces = outputs(rig, less, scale)
        gaps = [
            y - z - _reading_error(rig, effects, less, run, z)
            for y, z, run in zip(full, pieces, rig.runs, strict=True)
        ]
        errors.append(np.sqrt(np.mean(np.concatenate(gaps) ** 2)))
    return float(min(errors))


def _reading_error(rig: Rig, effects: Effects, less: Effects, run, y: np.ndarray) -> np.ndarray:
    """By how much the output is mistaken where the pressure's reading is believed."""
    only = {k: v for k, v in effects.items() if k not in less}
    if not {"pressure_gain", "pressure_offset"} & set(only):
        return np.zeros_like(y)
    gain = only.get("pressure_gain", {}).get("gain", 1.0)
    offset = only.get("pressure_offset", {}).get("offset", 0.0)
    drive = np.interp(np.linspace(0, run.corners[-1, 0], len(y)), *run.corners.T)
    slope = rig.largest / top(rig)
    return ((gain - 1) * drive + offset) * slope
