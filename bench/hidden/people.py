"""Sets as people have them: few runs, wild samples, coarse sensors, a video beside a gauge."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from bench.hidden.case import ADEQUATE, DRIVEN, MIDDLE, UNEXPLAINED, Case, Expected, hidden, named

# ---------------------------------------------------------------------- scarce sets
SCARCE: dict[str, dict[str, Any]] = {
    "two_runs": {"runs": 2, "repeats": 1, "with_noise": False},
    "three_runs": {"runs": 3, "repeats": 1, "with_noise": False},
}
FEW = {  # laws that two runs of one finger can show
    "free_bending": "gent_stiffening viscoelasticity tube_lag hysteresis pressure_offset dead_zone "
    "angle_offset clock_offset chamber_contact sensor_drift",
    "blocked_tip": "pressure_offset tube_lag tip_friction force_offset dead_zone saturation",
    "uniaxial": "gent_stiffening viscoelasticity hysteresis creep",
}
STRANGE = {"free_bending": "snap_through clamp_slip", "uniaxial": "interference"}
SCARCE_RATIO = 5.0


def scarce() -> Iterator[Case]:
    """One finger, two or three runs, no repeats, no stated noise."""
    for way, options in SCARCE.items():
        for experiment in DRIVEN:
            known = [(law, named((law,))) for law in FEW[experiment].split()]
            strange = [(law, UNEXPLAINED) for law in STRANGE.get(experiment, "").split()]
            for law, expected in [*known, *strange]:
                yield _case("scarce", way, experiment, law, expected, SCARCE_RATIO, options)
            yield _case("scarce", way, experiment, None, ADEQUATE, None, options)


# ---------------------------------------------------------------------- disturbed sets
DISTURBED: dict[str, dict[str, Any]] = {
    "wild 1 %": {"wild": 0.01},
    "wild 3 %": {"wild": 0.03},
    "quantised": {"output_steps": 100, "drive_steps": 256},
    "two rates": {"samples": 600, "runs": 8, "drive_rate": 100.0 / 30.0},
}
COMMON = {
    "free_bending": "gent_stiffening viscoelasticity tube_lag hysteresis pressure_offset dead_zone "
    "angle_offset angle_sensor_lag chamber_contact",
    "blocked_tip": "pressure_offset tube_lag tip_friction force_offset",
    "uniaxial": "gent_stiffening viscoelasticity hysteresis",
}
DISTURBED_RATIO = 4.0  # as `medium` of the catalogue, with which these sets are compared


def disturbed() -> Iterator[Case]:
    """Effects of the catalogue, and nothing, in sets that are disturbed in one way."""
    for way, options in DISTURBED.items():
        for experiment in DRIVEN:
            for law in COMMON[experiment].split():
                yield _case(way, way, experiment, law, named((law,)), DISTURBED_RATIO, options)
            yield _case(way, way, experiment, None, ADEQUATE, None, options)


def undisturbed() -> frozenset[str]:
    """Names of the cases of the catalogue, and without anything, that are the same but clean."""
    return frozenset(
        name
        for experiment in DRIVEN
        for name in (
            f"nothing/{experiment}/repeats",
            *(f"{experiment}/{law}/medium" for law in COMMON[experiment].split()),
        )
    )


def _case(
    row: str,
    way: str,
    experiment: str,
    law: str | None,
    expected: Expected,
    ratio: float | None,
    options: dict[str, Any],
) -> Case:
    name = f"{way.replace(' ', '_')}/{experiment}/{law or 'nothing'}"
    laws = hidden(law) if law else ()
    return Case(name, row, experiment, laws, expected, ratio, options, MIDDLE)
