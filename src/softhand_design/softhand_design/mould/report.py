"""A mould with its files, its checks and a report of what was measured."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import manifold3d

from softhand_common.documents.output_file import json_text, write_files
from softhand_design.mould.checks import (
    Check,
    Volumes,
    check_lines,
    check_mould,
    rubber_volumes,
    shown_failures,
    table_row,
)
from softhand_design.mould.measure import Finished, finished, stl_of
from softhand_design.mould.parameters import MouldParameters
from softhand_design.mould.parts import Mould, build_mould, kind_name, sided
from softhand_model.hand.actuator import Actuator

FORMAT = "softhand-mould/1"
PARTS = ("shell", "core")
CHAMBER_P5 = 1.6  # stated in section 7.2 [cm3]
NOTE = (
    "Passive layer (1 to 2 mm of rubber with mesh) and tube are later steps of the work. The mould "
    "was measured as a mesh; no printed one was tried."
)


@dataclass(frozen=True)
class CheckedMould:
    """A mould, the content of its files, and what was measured on them.

    turn is -1 for an arc that turns towards -y: its files are mirrored after they were checked.
    """

    actuator: Actuator
    mould: Mould
    files: dict[str, bytes]
    found: Finished
    volumes: Volumes
    checks: list[Check]
    turn: int = 0

    @property
    def name(self) -> str:
        """The name of its files."""
        return kind_name(self.actuator, self.turn)

    def part(self, name: str) -> manifold3d.Manifold:
        """Shell or core as in its file."""
        return sided(getattr(self.found, name), self.turn)

    @cached_property
    def failed(self) -> list[Check]:
        """The checks that were not passed."""
        return [check for check in self.checks if not check.passed]

    def record(self) -> dict[str, Any]:
        """The report as plain data: lengths in mm, volumes in mm3."""
        return {
            "format": FORMAT,
            "actuator": self.actuator.name,
            "turn": self.turn,
            "parameters": asdict(self.mould.parameters),
            "chambers": [list(ends) for ends in self.mould.chambers],
            "passed": not self.failed,
            "checks": [check.record() for check in self.checks],
            "volumes": asdict(self.volumes) | {"expected": self.volumes.expected},
        }

    def text(self) -> str:
        """The report as text."""
        rows = [f"Mould of {self.name}", "", *check_lines(self.checks)]
        rows += ["", "Rubber [cm3]", *_volume_rows(self.volumes)]
        rows += ["", "Chamber [cm3]", *_chamber_rows(self.actuator, self.volumes), "", NOTE]
        return "\n".join(rows) + "\n"


def _volume_rows(volumes: Volumes) -> list[str]:
    named = {"top and side walls of the model": volumes.model, **volumes.corrections}
    named |= {"sum": volumes.expected, "measured between the closed parts": volumes.measured}
    return [table_row(name, f"{volume / 1e3:.3f}", "", "", "") for name, volume in named.items()]


def _chamber_rows(actuator: Actuator, volumes: Volumes) -> list[str]:
    named = {"of the model": volumes.chamber_model / 1e3}
    named["with plugs, draft and round edges, measured"] = volumes.chamber / 1e3
    if actuator.name == "P5":
        named["stated in section 7.2"] = CHAMBER_P5
    return [table_row(name, f"{volume:.3f}", "", "", "") for name, volume in named.items()]


def make_mould(
    actuator: Actuator,
    parameters: MouldParameters | None = None,
    split: float | None = None,
    turn: int = 0,
) -> CheckedMould:
    """Build and check the mould of an actuator; `split` [mm] is where its chamber is parted, `turn`
    -1 asks for an arc that turns towards -y.

    Raises ValueError for actuators that leave no room for chamber, edges or rim.
    """
    mould = build_mould(actuator, parameters, split)
    files = {name: stl_of(getattr(mould, name)) for name in PARTS}
    found = finished(mould, files)
    volumes = rubber_volumes(found, actuator)
    if turn < 0:
        files = {name: stl_of(sided(getattr(found, name), turn)) for name in PARTS}
    return CheckedMould(actuator, mould, files, found, volumes, check_mould(found, volumes), turn)


def paths_of(name: str, folder: Path) -> dict[str, Path]:
    """Paths of the files of a mould, by their kind."""
    endings = {part: f"{part}.stl" for part in PARTS}
    endings |= {"text": "mould.txt", "json": "mould.json", "drawing": "mould.png"}
    return {kind: folder / f"{name}_{ending}" for kind, ending in endings.items()}


def write_mould(made: CheckedMould, folder: Path) -> None:
    """Write report and parts into a folder; for a mould that failed a check only the report.

    Raises ValueError that names the failed checks, or UnwritableFile.
    """
    paths = paths_of(made.name, folder)
    report = {paths["text"]: made.text(), paths["json"]: json_text(made.record())}
    if made.failed:
        write_files(report)
        for kind in (*PARTS, "drawing"):
            paths[kind].unlink(missing_ok=True)
        raise ValueError(refusal(made))
    write_files(report | {paths[part]: made.files[part] for part in PARTS})


def refusal(made: CheckedMould) -> str:
    """A sentence on why a mould was not written: its failed checks."""
    return f"mould of {made.name}: {shown_failures(made.failed)}"
