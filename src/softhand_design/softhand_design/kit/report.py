"""A checked kit, its report, and the files it is written to."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from softhand_common.documents.output_file import json_text, write_files
from softhand_design.kit.bill import Item, bill_csv, bill_of, bill_text
from softhand_design.kit.checks import check_kit
from softhand_design.kit.kit import Kit
from softhand_design.kit.part import Part
from softhand_design.mould.checks import Check, check_lines, shown_failures

FORMAT = "softhand-parts/1"
PARTS_NOTE = (
    "Lengths in mm. Not covered: how the parts move against each other under pressure. All was "
    "measured on meshes; nothing was printed."
)


@dataclass(frozen=True)
class CheckedKit:
    """A kit with its bill and what was measured on its files."""

    kit: Kit
    bill: list[Item]
    checks: list[Check]

    @cached_property
    def failed(self) -> list[Check]:
        """The checks that were not passed."""
        return [check for check in self.checks if not check.passed]

    @property
    def moved(self) -> dict[str, float]:
        """How far [mm] parts lie from the places of the hand's file."""
        made = self.kit.scaffold
        return {
            "plate, to its back": made.plate_moved,
            "struts, to their back": made.struts_moved,
            "sheet, away from the palm": self.kit.lift,
        }

    def record(self) -> dict[str, Any]:
        """The report as plain data: lengths in mm, poses (3, 4) in the wrist frame."""
        parts = self.kit.in_hand
        return {
            "format": FORMAT,
            "hand": self.kit.hand.name,
            "parameters": asdict(self.kit.used),
            "moved": self.moved,
            "passed": not self.failed,
            "poses": {part.name: part.copies for part in parts},
            "checks": [check.record() for check in self.checks],
        }

    def text(self) -> str:
        """The report as text."""
        rows = [f"Parts of {self.kit.hand.name}", "", *check_lines(self.checks), ""]
        rows += [f"{name + ':':<28}{far:g} mm" for name, far in self.moved.items() if far]
        return "\n".join([*rows, PARTS_NOTE]) + "\n"


def checked_kit(kit: Kit) -> CheckedKit:
    """A kit with its bill and all checks."""
    return CheckedKit(kit, bill_of(kit), check_kit(kit))


def paths_of(kit: Kit, folder: Path) -> dict[str, Path]:
    """Where the files of a kit go, by the names of parts and cuts, and by kind."""
    printed: list[Part] = [*kit.in_hand, *kit.trays.values()]
    found = {part.name: folder / f"{part.name}.stl" for part in printed}
    found |= {f"{name}_mesh": folder / f"{name}_mesh.svg" for name in kit.cuts}
    name = kit.hand.name
    return found | {
        "text": folder / f"{name}_parts.txt",
        "json": folder / f"{name}_parts.json",
        "bill": folder / f"{name}_bill.csv",
        "picture": folder / f"{name}_assembled.png",
    }


def write_kit(made: CheckedKit, folder: Path) -> None:
    """Write report, bill and parts into a folder; of a kit that failed a check the report alone.

    Raises ValueError with what failed, or UnwritableFile.
    """
    paths, kit = paths_of(made.kit, folder), made.kit
    report: dict[Path, str | bytes] = {
        paths["text"]: made.text(),
        paths["json"]: json_text(made.record()),
    }
    if made.failed:
        write_files(report)
        for path in set(paths.values()) - set(report):
            path.unlink(missing_ok=True)
        raise ValueError(f"parts of {kit.hand.name}: {shown_failures(made.failed)}")
    parts = [*kit.in_hand, *kit.trays.values()]
    files = {paths[part.name]: part.file for part in parts}
    cuts = {paths[f"{name}_mesh"]: drawing for name, drawing in kit.cuts.items()}
    write_files(report | files | cuts | {paths["bill"]: bill_csv(made.bill)})


def terminal_text(made: CheckedKit) -> str:
    """The text for the terminal: the bill, parts that were moved from their places in the hand's
    file, and that all checks passed.
    """
    moved = [f"{name} {far:g} mm" for name, far in made.moved.items() if far]
    rows = [bill_text(made.kit, made.bill)]
    if moved:
        rows.append(f"moved from the places of the hand's file: {', '.join(moved)}")
    return "\n".join([*rows, f"{len(made.checks) - len(made.failed)} checks passed"])
