"""What an import does not know of its files, and the text to add to the command that says it."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence

from model_lab.importing.derived import OPEN_AREA, OPEN_LENGTH, displacements, suggestion
from model_lab.importing.many_columns import open_absolutes
from model_lab.importing.meaning import BY_COLUMNS, NEEDED, RUBBER_TEST, VALVE_PULSE, Meant
from model_lab.importing.runs import Source
from model_lab.importing.tables import Table
from softhand_common.documents.quoted import shortened

Questions = dict[str, str]
"""The text that answers it, by what is not known."""
UNKNOWN_EXPERIMENT = "what was measured"


def open_questions(
    every: Sequence[Source],
    sources: Sequence[Source],
    experiment: str | None,
    modes: Mapping[str, str],
) -> tuple[str | None, Questions]:
    """The experiment as given, or the one that the files suggest; and what the files leave unknown.

    Args:
        every: all files.
        sources: those of them with a column that was recognised.
        experiment: its name; None: not known.
        modes: of a test of rubber, the mode of each file by its name; "" if it is not known.
    """
    unsure = _unsure(sources, experiment) | _unsure_modes(modes)
    if experiment in (None, "uniaxial", RUBBER_TEST):
        pulled = next(filter(None, map(_of_machine, sources)), None)
        if pulled and set(unsure) & {UNKNOWN_EXPERIMENT, "the column of stretch"}:
            return experiment or "uniaxial", pulled
    if set(unsure) & {UNKNOWN_EXPERIMENT, "the column of tip_angle"}:
        return experiment, _of_tracker(every, unsure) or unsure
    return experiment, unsure


def _of_tracker(every: Sequence[Source], unsure: Questions) -> Questions | None:
    """What is not known of files with tracked quantities of which the tip angle can be computed;
    None for others.
    """
    calls = (suggestion([column.name for column in one.table.columns]) for one in every)
    call = next(filter(None, calls), None)
    if call is None:
        return None
    how = f"--map 'tip_angle={call}'"
    if "LENGTH" in call:
        how += ", LENGTH of the part that bends, such as 90mm"
    if call.startswith("tip("):
        how += ", if the coordinates are 0 at the base of the finger"
    units = {what: said for what, said in unsure.items() if what.startswith("the unit of ")}
    return {"the tip angle": how} | units


def _unsure_modes(modes: Mapping[str, str]) -> Questions:
    return {
        f"the mode of {name}": f"--mode {shlex.quote(f'{name}=uniaxial')}, or pure_shear or "
        "equibiaxial"
        for name, mode in modes.items()
        if not mode
    }


def _of_machine(source: Source) -> Questions | None:
    """What is not known of a file of a testing machine, with the text that says it; None for
    another file: one without force or displacement, or with a pressure.
    """
    names = [column.name for column in source.table.columns]
    forces = [one.column for one in source.meanings if one.quantity == "tip_force"]
    moved = [name for name in displacements(names) if name not in forces]
    if not forces or not moved or "pressure" in source.quantities:
        return None
    unsure = {
        "the stretch": f"--map 'stretch=elongation({moved[0]},{OPEN_LENGTH})', {OPEN_LENGTH} "
        "between the clamps, such as 50mm"
    }
    if "stress" not in source.quantities:
        unsure["the stress"] = (
            f"--map 'stress=per_area({forces[0]},{OPEN_AREA})', {OPEN_AREA} of the cross-section "
            "at rest, such as 30mm2 or 10mm x 3mm"
        )
    return unsure


def _unsure(sources: Sequence[Source], experiment: str | None) -> Questions:
    """What is not known, and the text that says it."""
    unsure = {}
    have: set[str] = set().union(*(one.quantities for one in sources))
    if experiment is None:
        likely = [name for name in BY_COLUMNS if have & set(NEEDED[name])]
        lacking = dict.fromkeys(one for name in likely for one in NEEDED[name] if one not in have)
        unsure[UNKNOWN_EXPERIMENT] = (
            " or ".join(f"--map {one}=COLUMN:UNIT" for one in lacking)
            or f"--experiment {' or '.join(NEEDED)}, and --map NAME=COLUMN:UNIT for its columns"
        )
    for name in NEEDED.get(experiment or "", ()):
        if name not in have:
            unsure[f"the column of {name}"] = f"--map {name}=COLUMN:UNIT"
    for source in sources:
        for meant in source.meanings:
            if not meant.is_sure and _matters(meant, experiment):
                unsure[_what(source.table, meant)] = _how(source.table, meant)
    return unsure | (open_absolutes(sources) if experiment == VALVE_PULSE else {})


def _what(table: Table, meant: Meant) -> str:
    column = table.column(meant.column)
    written = "" if column is None or column.is_clock else column.unit
    said = f", {shortened(written)} in the file" if written else ""
    return f"the unit of {meant.column}{said}"


def _how(table: Table, meant: Meant) -> str:
    """The text that says the unit of a column."""
    column, given = table.column(meant.column), f"--map '{meant.quantity}={meant.column}"
    if column is not None and column.is_clock:
        return f"{given}:h' if hours and minutes, {given}:min' if minutes and seconds"
    if column is not None and column.unit and meant.quantity != "time":
        sensor = f"{given.removesuffix(meant.column)}linear({meant.column},SLOPE,OFFSET):UNIT'"
        return f"{given}:UNIT', or of a sensor that is not calibrated {sensor}"
    frames = f", or of frames their rate, {given}:30Hz'" if meant.quantity == "time" else ""
    return f"{given}:UNIT'{frames}"


def _matters(meant: Meant, experiment: str | None) -> bool:
    needed = NEEDED.get(experiment or "", ())
    return meant.quantity in ("time", *needed, *(["strain"] if "stretch" in needed else []))
