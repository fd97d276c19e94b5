"""Cases of the benchmark, row by row."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import product
from typing import Any

from bench.hidden.case import (
    ADEQUATE,
    DRIVEN,
    FINEST,
    LOW_NOISES,
    MIDDLE,
    NOISES,
    UNEXPLAINED,
    Case,
    hidden,
    named,
)
from bench.hidden.people import disturbed, scarce
from bench.hidden.reserved import reserved
from bench.hidden.ties import one_rate, tied

SLOW = MIDDLE  # where a diagnosis takes a minute
STRENGTHS = {"weak": 2.0, "light": 3.0, "medium": 4.0, "strong": 10.0}
FORM_STRENGTHS = {"medium": 4.0, "strong": 8.0}


# ---------------------------------------------------------------------- effects of the catalogue
# the design in which an effect shows, where it is not the standard one
DESIGN = {
    "mullins_softening": "recovered",
    "ogden_roxburgh": "recovered",
    "temperature_modulus": "temperatures",
    "arrhenius": "temperatures",
    "gravity": "mounts",
    "tip_heavy": "mounts",
    "tip_load": "mounts",
    "thick_wall": "walls",
    "rational_thick_wall": "walls",
}
CATALOGUE = {
    "free_bending": "gent_stiffening yeoh_stiffening viscoelasticity tube_lag hysteresis "
    "mullins_softening pressure_offset dead_zone section_rounding temperature_modulus gravity "
    "tip_load thick_wall actuation_nonlinearity angle_offset angle_sensor_lag clock_offset "
    "chamber_contact ballooning ageing creep camera_perspective sensor_drift saturation angle_gain "
    "permanent_set",
    "blocked_tip": "pressure_offset pressure_gain tube_lag dead_zone section_rounding "
    "gauge_compliance tip_friction force_offset clock_offset chamber_contact ballooning "
    "sensor_drift saturation",
    "uniaxial": "gent_stiffening yeoh_stiffening mooney_rivlin viscoelasticity hysteresis "
    "mullins_softening temperature_modulus ageing creep sensor_drift saturation stress_offset "
    "stretch_offset permanent_set machine_compliance",
    "valve_pulse": "line_friction switching_volume pulse_bias valve_delay leakage",
    "base_torque": "bend_twist_coupling passive_layer_slack",
}

THIN = {"design": "thin", "scatter": 0.002}  # in which a blocked finger bulges enough to show


def _designed(experiment: str, *laws: str) -> dict[str, Any]:
    """The design in which all of the laws show, for experiments that have designs."""
    special = [DESIGN[law] for law in laws if law in DESIGN]
    return {"design": special[0] if special else "standard"} if experiment in DRIVEN else {}


def catalogue(experiment: str, noises: tuple[float, ...] = NOISES) -> Iterator[Case]:
    """Every effect of the catalogue that is visible in an experiment, at three strengths."""
    for law, (word, ratio) in product(CATALOGUE[experiment].split(), STRENGTHS.items()):
        name, options = f"{experiment}/{law}/{word}", _designed(experiment, law)
        row, levels = ("weak", MIDDLE) if word == "light" else ("catalogue", noises)
        yield Case(name, row, experiment, hidden(law), named((law,)), ratio, options, levels)


def _fixed_strength(
    experiment: str, law: str, noises: tuple[float, ...], options: Mapping[str, Any]
) -> Case:
    """An effect without a strength of its own; it does not show above these noises."""
    name, laws = f"{experiment}/{law}", hidden(law)
    return Case(name, "catalogue", experiment, laws, named((law,)), 2.0, options, noises)


# ---------------------------------------------------------------------- the same in another form
STIFFENING = "gent_stiffening yeoh_stiffening arruda_boyce yeoh_third_order ogden"
SECOND_INVARIANT = "mooney_rivlin second_invariant"
FORMS = {  # law: its family
    "ogden": STIFFENING,
    "arruda_boyce": STIFFENING,
    "fung": STIFFENING,
    "gent_thomas": SECOND_INVARIANT,
    "two_modes": "viscoelasticity",
    "power_law": "viscoelasticity creep",
    "power_creep": "creep viscoelasticity",
    "clock_drift": "clock_offset",
    "log_chamber_contact": "chamber_contact ballooning",
    "balloon_series": "ballooning chamber_contact",
    "fatigue": "ageing",
    "near_camera": "camera_perspective",
    "session_creep": "sensor_drift",
    "warming_sensor": "sensor_drift",
    "soft_saturation": "saturation",
    "bouc_wen": "hysteresis",
    "plays": "hysteresis",
    "ogden_roxburgh": "mullins_softening",
    "second_order_tube": "tube_lag growing_chamber_lag",
    "orifice_tube": "tube_lag growing_chamber_lag",
    "soft_dead_zone": "dead_zone",
    "curved_zero": "pressure_offset",
    "arrhenius": "temperature_modulus",
    "rational_rounding": "section_rounding",
    "tip_heavy": "gravity tip_load",
    "rational_thick_wall": "thick_wall",
    "cascaded_sensor": "angle_sensor_lag",
    "hardening_gauge": "gauge_compliance",
    "smooth_tip_friction": "tip_friction",
    "compressible_line": "line_friction",
    "orifice_leak": "leakage",
    "pressed_valve": "valve_delay switching_volume",
    "warm_dead_volume": "switching_volume",
}
FORMS_IN = {
    "free_bending": "ogden arruda_boyce fung two_modes power_law bouc_wen plays ogden_roxburgh "
    "second_order_tube orifice_tube soft_dead_zone curved_zero arrhenius rational_rounding "
    "tip_heavy rational_thick_wall cascaded_sensor clock_drift log_chamber_contact "
    "balloon_series fatigue power_creep near_camera session_creep warming_sensor soft_saturation",
    "blocked_tip": "second_order_tube orifice_tube soft_dead_zone curved_zero rational_rounding "
    "hardening_gauge smooth_tip_friction clock_drift log_chamber_contact balloon_series "
    "warming_sensor soft_saturation",
    "uniaxial": "ogden arruda_boyce fung gent_thomas two_modes power_law bouc_wen plays "
    "ogden_roxburgh arrhenius fatigue power_creep soft_saturation",
    "valve_pulse": "compressible_line orifice_leak pressed_valve warm_dead_volume",
}


def other_forms(experiment: str) -> Iterator[Case]:
    """The same family in another functional form."""
    for law, (word, ratio) in product(FORMS_IN[experiment].split(), FORM_STRENGTHS.items()):
        name, family = f"form/{experiment}/{law}/{word}", named(tuple(FORMS[law].split()))
        options = _designed(experiment, law)
        yield Case(name, "other form", experiment, hidden(law), family, ratio, options)


# ---------------------------------------------------------------------- tests of the rubber
RUBBERS = {  # law: its family
    "exact_chains": STIFFENING,
    "knowles": STIFFENING,
    "three_terms": STIFFENING,
    "logarithm_of_the_second": f"{SECOND_INVARIANT} ogden",
    "carroll": f"{STIFFENING} {SECOND_INVARIANT}",
}
MEASURED: dict[str, dict[str, Any]] = {
    "repeats": {"samples": 60, "repeats": 2},
    "few_readings": {"samples": 16, "repeats": 1, "scatter": 0.02, "with_noise": False},
}


def tests_of_rubber() -> Iterator[Case]:
    """Laws of rubber in three modes, as a laboratory measures and as an old paper prints them."""
    for way, options in MEASURED.items():
        for law, family in RUBBERS.items():
            expected = named(tuple(family.split()))
            for word, ratio in FORM_STRENGTHS.items():
                name, laws = f"form/rubber/{law}/{way}/{word}", hidden(law)
                yield Case(name, "other form", "rubber", laws, expected, ratio, options, LOW_NOISES)
        yield Case(
            f"nothing/rubber/{way}", "nothing", "rubber", (), ADEQUATE, None, options, LOW_NOISES
        )


# ---------------------------------------------------------------------- two effects at once
PAIRS = {
    "free_bending": "gent_stiffening+tube_lag gent_stiffening+angle_offset "
    "gent_stiffening+dead_zone gent_stiffening+temperature_modulus gent_stiffening+gravity "
    "yeoh_stiffening+angle_sensor_lag yeoh_stiffening+pressure_offset "
    "viscoelasticity+pressure_offset viscoelasticity+dead_zone viscoelasticity+angle_offset "
    "viscoelasticity+temperature_modulus viscoelasticity+gravity viscoelasticity+section_rounding "
    "hysteresis+pressure_offset hysteresis+tube_lag hysteresis+angle_offset "
    "hysteresis+temperature_modulus mullins_softening+tube_lag mullins_softening+angle_offset "
    "thick_wall+tube_lag dead_zone+angle_sensor_lag temperature_modulus+tube_lag "
    "gravity+dead_zone",
    "blocked_tip": "pressure_offset+tip_friction tube_lag+force_offset dead_zone+tip_friction "
    "gauge_compliance+tube_lag",
    "uniaxial": "gent_stiffening+temperature_modulus viscoelasticity+temperature_modulus "
    "hysteresis+temperature_modulus yeoh_stiffening+temperature_modulus",
    "valve_pulse": "injector_flow+switching_volume injector_flow+pulse_bias",
}


def pairs(experiment: str, noises: tuple[float, ...] = LOW_NOISES) -> Iterator[Case]:
    """Two effects of different stages, each three times the floor alone."""
    for pair in PAIRS[experiment].split():
        laws = pair.split("+")
        name, both = f"pair/{experiment}/{pair}", named(*((law,) for law in laws))
        options = _designed(experiment, *laws)
        yield Case(name, "pairs", experiment, hidden(*laws), both, 3.0, options, noises)


# ---------------------------------------------------------------------- three and four at once
SEVERAL = {
    "free_bending": "gent_stiffening+temperature_modulus+tube_lag "
    "yeoh_stiffening+pressure_offset+angle_sensor_lag gent_stiffening+tube_lag+angle_offset "
    "hysteresis+temperature_modulus+pressure_offset viscoelasticity+temperature_modulus+dead_zone "
    "viscoelasticity+gravity+angle_offset hysteresis+gravity+tube_lag "
    "thick_wall+tube_lag+angle_offset mullins_softening+tube_lag+angle_offset "
    "gent_stiffening+temperature_modulus+tube_lag+angle_offset "
    "viscoelasticity+temperature_modulus+dead_zone+angle_offset "
    "hysteresis+gravity+tube_lag+angle_offset "
    "yeoh_stiffening+temperature_modulus+pressure_offset+angle_sensor_lag",
    "blocked_tip": "tube_lag+tip_friction+force_offset pressure_offset+tip_friction+tube_lag",
    "uniaxial": "gent_stiffening+temperature_modulus+viscoelasticity "
    "yeoh_stiffening+temperature_modulus+hysteresis "
    "gent_stiffening+temperature_modulus+viscoelasticity+hysteresis",
}
ROWS_OF_SEVERAL = {3: "triples", 4: "quadruples"}


def several(experiment: str, noises: tuple[float, ...] = LOW_NOISES) -> Iterator[Case]:
    """Three and four effects at once, each three times the floor alone."""
    for together in SEVERAL[experiment].split():
        laws = together.split("+")
        name, each = f"several/{experiment}/{together}", named(*((law,) for law in laws))
        options, row = _designed(experiment, *laws), ROWS_OF_SEVERAL[len(laws)]
        yield Case(name, row, experiment, hidden(*laws), each, 3.0, options, noises)


# ---------------------------------------------------------------------- nothing hidden
WAYS: dict[str, dict[str, Any]] = {
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


def nothing(
    experiment: str, ways: tuple[str, ...], noises: tuple[float, ...] = NOISES
) -> Iterator[Case]:
    """Nothing hidden, measured in several ways."""
    for way in ways:
        name = f"nothing/{experiment}/{way}"
        yield Case(name, "nothing", experiment, (), ADEQUATE, None, WAYS[way], noises)


# ---------------------------------------------------------------------- outside the catalogue
FAULTS = "clamp_slip gain_step interference dropped_frames stuck_encoder"
OUTSIDE = {  # laws, and error before over floor
    "free_bending": (f"snap_through two_leaks ringing {FAULTS}", (3.0, 5.0, 10.0)),
    "blocked_tip": (f"snap_through two_leaks ringing {FAULTS}", (5.0,)),
    "uniaxial": (FAULTS, (5.0,)),
    "valve_pulse": ("sticky_valve saturated_meter stepping_gain wearing_choke", (5.0,)),
    "base_torque": ("crosstalk", (5.0,)),
}
WEARING = ("wearing_choke",)  # shows where repeats follow one another at once


def outside(experiment: str, noises: tuple[float, ...] = LOW_NOISES) -> Iterator[Case]:
    """Nothing of the catalogue."""
    laws, ratios = OUTSIDE[experiment]
    for law, ratio in product(laws.split(), ratios):
        name = f"outside/{experiment}/{law}/{ratio:g}"
        options = {} if experiment == "base_torque" else {"adjacent": law in WEARING}
        yield Case(name, "outside", experiment, hidden(law), UNEXPLAINED, ratio, options, noises)


@lru_cache(maxsize=1)
def all_cases() -> tuple[Case, ...]:
    """Every case, by row."""
    few, choke = ("repeats", "no_repeats", "temperatures"), ("injector_flow",)
    form_of_choke = Case(
        "form/valve_pulse/iso_choke",
        "other form",
        "valve_pulse",
        hidden("iso_choke"),
        named(choke),
        2.0,
        {},
        FINEST,
    )
    return (
        *(case for experiment in DRIVEN for case in catalogue(experiment)),
        _fixed_strength("free_bending", "side_wall_integral", LOW_NOISES, {"design": "walls"}),
        _fixed_strength("blocked_tip", "finite_rotation", LOW_NOISES, THIN),
        *(case for experiment in DRIVEN for case in other_forms(experiment)),
        *tests_of_rubber(),
        *(case for experiment in DRIVEN for case in pairs(experiment)),
        *(case for experiment in DRIVEN for case in several(experiment)),
        *nothing("free_bending", tuple(WAYS)),
        *nothing("blocked_tip", few),
        *nothing("uniaxial", few),
        *(case for experiment in DRIVEN for case in outside(experiment)),
        *reserved(),
        *scarce(),
        *disturbed(),
        *one_rate(),
        *catalogue("valve_pulse"),
        _fixed_strength("valve_pulse", "injector_flow", FINEST, {}),  # the choke's bend
        *other_forms("valve_pulse"),
        form_of_choke,
        *pairs("valve_pulse", FINEST),
        *nothing("valve_pulse", ("repeats", "no_repeats")),
        *outside("valve_pulse"),
        *tied(),
        *catalogue("base_torque", SLOW),
        *nothing("base_torque", ("repeats",), SLOW),
        *outside("base_torque", SLOW),
    )
