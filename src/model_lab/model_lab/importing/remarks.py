"""What an import tells of files, specimens and repeats."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from model_lab.importing.clocks import pauses
from model_lab.importing.derived import derivation
from model_lab.importing.meaning import INPUT, VALVE_PULSE
from model_lab.importing.runs import Source
from model_lab.importing.specimens import Assigned
from softhand_common.documents.quoted import listed


def remarks_on_files(sources: Sequence[Source]) -> Iterable[str]:
    """What was computed from columns, and what was left out, once for all files alike."""
    alike: dict[str, list[str]] = {}
    for source in sources:
        for meant in source.meanings:
            call = derivation(meant.column)
            if call is not None:
                of_angle = (
                    "; 0 at the beginning, which should be at rest, and positive towards the "
                    "side of the largest angle"
                )
                told = of_angle if meant.quantity == "tip_angle" else ""
                yield f"{meant.quantity} is {meant.column}: {call[0].said}{told}"
            if meant.quantity == "time" and len(begins := pauses(source.values_of(meant))):
                yield (
                    f"{source.table.path.name}: its clock pauses before row {begins[0] + 1}; if "
                    "another run begins there, say --split-restarts"
                )
        for said in source.table.remarks:
            alike.setdefault(said, []).append(source.table.path.name)
    yield from (f"{listed(dict.fromkeys(files))}: {said}" for said, files in alike.items())


def remarks_on_specimens(
    found: Assigned, entry: Mapping[str, object], experiment: str, stated: bool
) -> Iterable[str]:
    """How runs were given to specimens, and what must be written into experiment.yaml by hand."""
    names = found.names
    every = " and ".join(names)
    if len(names) > 1:
        yield (
            f"by the names of the files, {every} are taken as {len(names)} specimens; if they are "
            "one, say --specimen NAME"
        )
    elif found.unsure and not stated:
        yield (
            f"all {len(found.specimens)} runs are taken as runs of one specimen, {names[0]}, "
            f"though {' and '.join(found.unsure)} may name another; give it an entry of its own "
            "under specimens in experiment.yaml and name it in its runs"
        )
    if entry and len(names) > 1 and INPUT.get(experiment) != "stretch":
        yield (
            f"{every} have the same dimensions, those of --hand: write those in which they differ "
            "into experiment.yaml"
        )
    if not entry and experiment != VALVE_PULSE:
        sizes = (
            "shear_modulus [Pa] and gauge_length [m]"
            if INPUT.get(experiment) == "stretch"
            else "length, height, width, wall, side_wall [m] and shear_modulus [Pa]"
        )
        has = "the specimen has" if len(names) == 1 else "the specimens have"
        yield (
            f"{has} no dimensions yet: write {sizes} of {every} into experiment.yaml, or import a "
            "finger with --hand HAND; without them, compare with --model linear"
        )


def remarks_on_repeats(
    found: Assigned, by_name: Assigned, modes: Mapping[str, str]
) -> Iterable[str]:
    """Which runs are taken as repeats of one another, as their names differ by a number alone, and
    which are not, as they were driven otherwise.
    """
    apart = [run for run, protocol in by_name.protocols.items() if protocol != found.protocols[run]]
    if apart:
        yield (
            f"{listed(apart)}: driven to another level or at another pace than a run of nearly "
            "the same name, so no repeat of it, and given a protocol of its own"
        )
    groups: dict[tuple[str, ...], list[str]] = {}
    for run, specimen in found.specimens.items():
        groups.setdefault((specimen, found.protocols[run], modes.get(run, "")), []).append(run)
    repeats = [" = ".join(group) for group in groups.values() if len(group) > 1]
    if repeats:
        yield (
            f"taken as repeats, whose differences are noise: {listed(repeats)}; if they are of "
            "several specimens, say --specimen FILE=NAME"
        )


def remarks_on_new(runs: Sequence[str]) -> Iterable[str]:
    """That each run is of a new specimen."""
    if runs:
        yield (
            f"each a new specimen (virgin: true), as their names number it: {listed(runs)}; if one "
            "was pulled again and again, take virgin out of experiment.yaml"
        )
