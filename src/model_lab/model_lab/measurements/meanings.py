"""Quantities that a column may contain instead of the expected one, and their conversion."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.hands import PRESSURE_OF
from model_lab.measurements.units import MARKER_COLUMN
from model_lab.rules import RULES

ATMOSPHERE = 101_325.0  # [Pa] of the air, where the set states none
AMBIENT = "ambient"  # name of the pressure of the air among columns
OF_LENGTH = "length"  # of the specimen [m], among columns

Columns = Mapping[str, Array]
"""Columns (samples,) of a run by name, in SI units."""
Meaning = Callable[[Array, Columns], Array]
"""From what was read and all columns, among them AMBIENT for pressures."""

_OPPOSITE: Mapping[str, Meaning] = {"negative": lambda values, _: -values}
_TURNED = {"supplement": np.pi, "complement": 0.5 * np.pi}


def _of_angle() -> dict[str, Meaning]:
    """A tip angle [rad] that was read as another angle of the finger."""
    return {
        **_OPPOSITE,
        "supplement": lambda values, _: _TURNED["supplement"] - values,
        "complement": lambda values, _: _TURNED["complement"] - values,
        "from_vertical": lambda values, _: values - _TURNED["complement"],
        "curvature": lambda values, columns: values * columns[OF_LENGTH],
        "chord": lambda values, _: 2.0 * values,
        "wrapped": lambda values, _: np.unwrap(values),
        "wrapped_180": lambda values, _: np.unwrap(values, period=np.pi),
    }


MEANINGS: Mapping[str, Mapping[str, Meaning]] = {
    "stretch": {"strain": lambda values, _: 1.0 + values},
    "pressure": {"absolute": lambda values, columns: values - columns[AMBIENT], **_OPPOSITE},
    "p_in": {"gauge": lambda values, columns: values + columns[AMBIENT]},
    "p_out": {"gauge": lambda values, columns: values + columns[AMBIENT]},
    "stress": {"true_stress": lambda values, columns: values / columns["stretch"], **_OPPOSITE},
    "tip_angle": _of_angle(),
    "tip_force": _OPPOSITE,
    **dict.fromkeys(("torque_x", "torque_y", "torque_z"), _OPPOSITE),
}
"""By column and word: the expected column (samples,) from the one that was read, in SI units.

    negative: its negative. absolute: of the pressure of the air too. gauge: without it.
    strain: the stretch less 1. true_stress: force over the area as it is then.
    supplement: 180 deg less the angle. complement: 90 deg less the angle. from_vertical: 90 deg
    more than the angle. curvature: the angle per metre of the arc, times the specimen's length.
    chord: the angle of the chord from base to tip, half of the tip's. wrapped:
    it jumps by 360 deg. wrapped_180: by 180 deg, as the arc tangent of a quotient does.
"""


def meanings_of(column: str) -> Mapping[str, Meaning]:
    """Quantities that a column may hold, by the words for them. Columns of the channels and markers
    of a hand may hold those of a pressure and of a position.

    >>> list(meanings_of("pressure.a")), list(meanings_of("index_tip.x"))
    (['absolute', 'negative'], ['negative'])
    """
    if column in MEANINGS:
        return MEANINGS[column]
    if column.startswith(PRESSURE_OF):
        return MEANINGS["pressure"]
    return _OPPOSITE if MARKER_COLUMN.fullmatch(column) else {}


def air_pressure(least: Sequence[float]) -> float:
    """Pressure of the air [Pa]: the absolute pressure at rest, if that can be an air pressure; else
    the standard one.

    least: lowest pressures of all runs [Pa].

    >>> air_pressure([98.2e3, 98.1e3, 98.3e3]), air_pressure([0.0])
    (98200.0, 101325.0)
    """
    usual = float(np.median(least))
    low, high = RULES.atmosphere
    return usual if low <= usual <= high else ATMOSPHERE


def as_expected(
    columns: Columns,
    meanings: Mapping[str, str],
    ambient: float = ATMOSPHERE,
    length: float = float("nan"),
) -> dict[str, Array]:
    """The columns of a run, converted to what the lab expects.

    meanings: words of `MEANINGS`, by column. ambient: pressure of the air [Pa]. length: length of
    the specimen [m], which only a curvature needs.
    """
    result = dict(columns)
    known_to_all = {AMBIENT: np.array(ambient), OF_LENGTH: np.array(length)}
    for name in dict.fromkeys([*MEANINGS, *meanings]):  # the stretch first: the stress needs it
        if name in meanings and name in result:
            known = meanings_of(name)[meanings[name]]
            result[name] = known(result[name], {**result, **known_to_all})
    return result
