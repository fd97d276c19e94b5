"""Slips (mistakes in units, signs or names) that a measurement set may have, each with the
corrected set.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.at_rest import lowest
from model_lab.measurements.meanings import AMBIENT, ATMOSPHERE, MEANINGS, OF_LENGTH, air_pressure
from model_lab.measurements.measurement_set import (
    OUTPUTS,
    TIP_POSE,
    MeasurementSet,
    Run,
    Specimen,
)
from model_lab.measurements.units import COLUMN_UNITS, column_unit
from model_lab.slips.columns import (
    WITHOUT_UNIT,
    Candidate,
    column_mend,
    factors_of,
    is_rare,
    one_line,
    stated_unit,
    with_columns,
    with_meaning,
    with_renamed,
    with_units,
)
from model_lab.slips.of_hand import candidates_of_hand

NAMES = {"negative": "sign", "from_vertical": "complement", "gauge": "absolute"}
"""Name of the slip that is said by a word of `MEANINGS`, where it is not that word."""
PLAUSIBLE_SIZES = {
    "length": (5e-3, 2.0),
    "height": (2e-3, 0.2),
    "width": (2e-3, 0.2),
    "wall": (2e-4, 0.05),
    "side_wall": (2e-4, 0.05),
    "gauge_length": (2e-3, 1.0),
}  # [m]
SPECIMEN_SIZES = tuple(PLAUSIBLE_SIZES)
TOGETHER = (("p_in", "p_out"), TIP_POSE[:3], OUTPUTS["base_torque"])
"""Columns of one sensor, or of one kind of sensor, which are mistaken together."""
OF_ONE_SENSOR = TOGETHER[1:]  # which have one unit
QUATERNION = TIP_POSE[3:]
DOUBTED = ("stretch", "p_in", "p_out")
"""Columns of which impossible values are kept (`measurements.rows`)."""
MOST_SPECIMENS = 6  # of which any two may have been exchanged
SHEAR_OF_YOUNG = 1.0 / 3.0  # of an incompressible material
MEANING_WORDS = {
    "absolute": "absolute pressure",
    "gauge": "gauge pressure",
    "strain": "strain",
    "true_stress": "true stress",
    "negative": "minus {column}",
    "supplement": "180 deg less the tip angle",
    "complement": "90 deg less the tip angle",
    "from_vertical": "90 deg more than the tip angle",
    "curvature": "the curvature (angle per metre)",
    "chord": "the angle of the chord",
    "wrapped": "an angle that jumps by 360 deg",
    "wrapped_180": "an angle that jumps by 180 deg",
}
EXPECTED = {
    "absolute": "gauge pressure",
    "gauge": "absolute pressure",
    "strain": "stretch",
    "true_stress": "nominal stress",
    "negative": "{column}",
    "wrapped": "a continuous angle",
    "wrapped_180": "a continuous angle",
}


def candidates(data: MeasurementSet) -> Iterator[Candidate]:
    """All slips that the set may have. If a column has impossible values, only the slips that may
    explain these.
    """
    if data.of_hand:
        yield from candidates_of_hand(data)
        return
    for columns in _mistaken_together(data):
        if data.doubts and columns[0] not in DOUBTED:
            continue
        if columns not in [(name,) for group in OF_ONE_SENSOR for name in group]:
            yield from _units(data, columns)
        yield from _meanings(data, columns)
    if data.doubts:
        return
    yield from _exchanged_columns(data)
    yield from _scalar_first(data)
    yield from _exchanged_modes(data)
    yield from _moduli(data)
    yield from _sizes(data)
    yield from _exchanged_specimens(data)


# ---------------------------------------------------------------------- columns
def _mistaken_together(data: MeasurementSet) -> list[tuple[str, ...]]:
    """Each column alone, and those that may be stated wrongly together."""
    names = dict.fromkeys((*data.inputs, *data.outputs))
    groups = [
        group
        for group in TOGETHER
        if names.keys() >= set(group) and len({stated_unit(data, name) for name in group}) == 1
    ]
    return [*((name,) for name in names), *groups]


def _units(data: MeasurementSet, columns: tuple[str, ...]) -> Iterator[Candidate]:
    """Columns in each other usual unit of their quantity."""
    said = stated_unit(data, columns[0])
    for unit, factor in factors_of(data, columns[0]):
        yield Candidate(
            "percent" if unit == "percent" else "unit",
            ", ".join(columns),
            said,
            unit,
            column_mend(data, {column: {"unit": unit} for column in columns}),
            with_units(data, columns, unit, factor),
            rare=is_rare(columns[0], unit),
        )


def _meanings(data: MeasurementSet, columns: tuple[str, ...]) -> Iterator[Candidate]:
    """Columns that hold something else than is expected, in their own unit or another one."""
    first = columns[0]
    said = stated_unit(data, first)
    for word in MEANINGS.get(first, ()):
        units = [(said, 1.0)]
        if word in ("absolute", "strain"):  # which come in any unit
            units += factors_of(data, first)
        if word == "curvature":
            known = all(OF_LENGTH in specimen.values for specimen in _used(data).values())
            every = [*units, *factors_of(data, first)] if known else []
            units = [(unit, factor) for unit, factor in every if unit == "rad"]
        for unit, factor in units:
            scaled = with_units(data, columns, unit, factor)
            ambient = ATMOSPHERE if word == "gauge" else _ambient(scaled, first)
            mended = with_meaning(scaled, columns, word, ambient)
            if not _possible(mended, first) or _same(mended, scaled, first):
                continue
            entry: dict[str, Any] = {"unit": unit, "is": word}
            if word in ("absolute", "gauge"):
                entry[AMBIENT] = _written(ambient / column_unit(first, unit).scale)
            named = ", ".join(columns)
            yield Candidate(
                NAMES.get(word, word),
                named,
                EXPECTED.get(word, "the tip angle").format(column=named),
                MEANING_WORDS[word].format(column=named) + (f" in {unit}" if unit != said else ""),
                column_mend(data, {column: dict(entry) for column in columns}),
                replace(mended, units={**data.units, **dict.fromkeys(columns, unit)}),
                rare=word == "curvature",
            )


def _ambient(data: MeasurementSet, column: str) -> float:
    """Pressure of the air [Pa]: what absolute pressures are at rest, if that may be it."""
    return air_pressure([level for run in data.runs for level in lowest(run.columns[column])])


def _possible(data: MeasurementSet, column: str) -> bool:
    """Whether a column has values that it may have."""
    least = {"stretch": 0.1, "p_in": 1.0, "p_out": 1.0, "pressure": -2e4}.get(column, -np.inf)
    return all(float(np.nanmin(run.columns[column])) >= least for run in data.runs)


def _same(data: MeasurementSet, other: MeasurementSet, column: str) -> bool:
    """Whether a column is the same in two sets."""
    pairs = zip(data.runs, other.runs, strict=True)
    return all(np.array_equal(a.columns[column], b.columns[column]) for a, b in pairs)


def _exchanged_columns(data: MeasurementSet) -> Iterator[Candidate]:
    """Any two columns of one quantity, and input and output, exchanged."""
    names = [name for name in (*data.inputs, *data.outputs) if name not in WITHOUT_UNIT]
    for first, second in combinations(names, 2):
        alike = COLUMN_UNITS[first] == COLUMN_UNITS[second]
        if not alike and len(names) > 2:
            continue
        units = {first: stated_unit(data, first), second: stated_unit(data, second)}
        one, other = (column_unit(name, unit) for name, unit in units.items())
        ratio = 1.0 if alike else one.scale / other.scale

        def exchanged(run: Run, a: str = first, b: str = second, by: float = ratio) -> dict:
            return {a: by * run.columns[b], b: run.columns[a] / by}

        mended = with_columns(data, exchanged, (first, second))
        if _possible(mended, first) and _possible(mended, second):
            entries = {
                first: {"unit": units[first], "from": second},
                second: {"unit": units[second], "from": first},
            }
            yield Candidate(
                "exchanged",
                f"{first}, {second}",
                f"{first} and {second}",
                f"{second} and {first}, exchanged",
                column_mend(data, entries),
                mended,
            )


def _scalar_first(data: MeasurementSet) -> Iterator[Candidate]:
    """A quaternion written as w, x, y, z: the column of x holds w, and so on."""
    if set(QUATERNION) <= set(data.inputs):
        sources = dict(zip(QUATERNION, (*QUATERNION[1:], QUATERNION[0]), strict=True))
        entries = {name: {"unit": "", "from": source} for name, source in sources.items()}
        yield Candidate(
            "exchanged",
            ", ".join(QUATERNION),
            "x, y, z, w",
            "w, x, y, z, the scalar first",
            column_mend(data, entries),
            with_renamed(data, sources),
        )


def _exchanged_modes(data: MeasurementSet) -> Iterator[Candidate]:
    """Any two modes of tests of the rubber exchanged."""
    modes = dict.fromkeys(run.mode for run in data.runs if run.mode)
    for first, second in combinations(modes, 2):
        other = {first: second, second: first}
        runs = tuple(
            replace(run, mode=other.get(run.mode, run.mode)) if run.mode else run
            for run in data.runs
        )
        entries = {run.name: {"mode": other[run.mode]} for run in data.runs if run.mode in other}
        yield Candidate(
            "exchanged",
            "mode",
            f"{first} and {second}",
            f"{second} and {first}, exchanged",
            one_line({"runs": entries}),
            replace(data, runs=runs),
        )


# ---------------------------------------------------------------------- specimens
def _used(data: MeasurementSet) -> dict[str, Specimen]:
    """Specimens that runs have, by name."""
    return {run.specimen: data.specimens[run.specimen] for run in data.runs}


def _moduli(data: MeasurementSet) -> Iterator[Candidate]:
    """Young's modulus in the place of the shear modulus: not of a blocked tip, which barely shows
    it, nor where it is fitted freely.
    """
    if data.experiment == "blocked_tip" or data.free_modulus:
        return
    changes = {
        name: {"shear_modulus": SHEAR_OF_YOUNG * float(entry.values["shear_modulus"])}
        for name, entry in _used(data).items()
        if "shear_modulus" in entry.values
    }
    if changes:
        yield of_specimens(
            data, "youngs_modulus", "shear_modulus", ("shear modulus", "Young's modulus"), changes
        )


def _sizes(data: MeasurementSet) -> Iterator[Candidate]:
    """Sizes in another unit, the radius for the diameter, both walls for one."""
    present = [
        key
        for key in SPECIMEN_SIZES
        if any(key in specimen.values for specimen in _used(data).values())
    ]
    for unit, factor in (("mm", 1e-3), ("cm", 1e-2), ("inch", 0.0254)):
        for keys in dict.fromkeys([tuple(present), *((key,) for key in present)]):
            resized = _resized(data, "unit", keys, factor, ("m", unit))
            if _plausible(resized.mended):
                yield resized
    section = tuple(key for key in ("height", "width") if key in present)
    if len(section) == 2:
        yield _resized(data, "radius", section, 2.0, ("the whole", "half of it"))
    walls = [key for key in ("wall", "side_wall") if key in present]
    for keys in (tuple(walls), *((key,) for key in walls)) if len(walls) > 1 else ():
        yield _resized(data, "wall_total", keys, 0.5, ("a single wall", "both walls together"))


def _plausible(data: MeasurementSet) -> bool:
    """Whether the sizes of specimens may be those of a soft actuator or a strip of rubber."""
    for specimen in _used(data).values():
        for key, (low, high) in PLAUSIBLE_SIZES.items():
            sizes = np.asarray(specimen.values.get(key, low), float)
            sizes = sizes if sizes.ndim == 0 else sizes[:, 1]
            if not np.all((sizes >= low) & (sizes <= high)):
                return False
    return True


def _resized(
    data: MeasurementSet, name: str, keys: tuple[str, ...], factor: float, words: tuple[str, str]
) -> Candidate:
    changes = {
        specimen.name: {
            key: _resized_value(key, specimen.values[key], factor)
            for key in keys
            if key in specimen.values
        }
        for specimen in _used(data).values()
    }
    return of_specimens(data, name, ", ".join(keys), words, changes)


def _resized_value(key: str, value: float | Array, factor: float) -> float | Array:
    """A size [m] times a factor; of one that varies along x [m], the sizes alone."""
    if np.ndim(value) == 0:
        return float(value) * factor
    return np.asarray(value) * [1.0, factor]


def _exchanged_specimens(data: MeasurementSet) -> Iterator[Candidate]:
    """Any two specimens of different sizes exchanged."""
    used = _used(data)
    for first, second in combinations(used if len(used) <= MOST_SPECIMENS else (), 2):
        one, other = used[first].values, used[second].values
        differing = [
            key for key in one if key in other and not np.array_equal(one[key], other[key])
        ]
        if differing:
            yield of_specimens(
                data,
                "exchanged",
                f"{first}, {second}",
                (f"{first} and {second}", f"{second} and {first}, exchanged"),
                {
                    first: {key: other[key] for key in differing},
                    second: {key: one[key] for key in differing},
                },
            )


def of_specimens(
    data: MeasurementSet,
    name: str,
    column: str,
    words: tuple[str, str],
    changes: Mapping[str, Mapping[str, float | Array]],
) -> Candidate:
    """A slip in the entries of specimens; changes: their values without it, in SI units."""
    specimens = {
        key: replace(entry, values={**entry.values, **changes.get(key, {})})
        for key, entry in data.specimens.items()
    }
    entries = {
        key: {name: _written(value) for name, value in values.items()}
        for key, values in changes.items()
    }
    mended = replace(data, specimens=specimens)
    return Candidate(name, column, *words, one_line({"specimens": entries}), mended)


def _written(value: float | Array) -> Any:
    """A value to six digits, as a document holds it."""
    if np.ndim(value) == 0:
        return float(f"{float(value):.6g}")
    return [[float(f"{number:.6g}") for number in point] for point in np.asarray(value)]
