"""Report of a sweep as files: tables in Markdown, pictures, and all of it as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from softhand_common.documents.output_file import check_new, save_figure, write_json, write_new
from softhand_trials.agreement import Agreement
from softhand_trials.sweep.drawing import maps_figure, shares_figure
from softhand_trials.sweep.report import Group, agreements, codes_of, groups_of
from softhand_trials.sweep.results import RESULTS_FILE, read_results
from softhand_trials.sweep.success_map import SuccessMap, largest_hole, largest_share
from softhand_trials.sweep.task import Record

FORMAT = "softhand-sweep-report/1"
PAGE, REPORT_DATA, SHARES, MAPS = "report.md", "report.json", "shares.png", "maps.png"
FIGURE_DPI = 120  # of pictures [dots an inch]


def write_report(folder: Path, out: Path | None = None, force: bool = False) -> list[Path]:
    """Write the report of the results in a folder, finished or not.

    Args:
        folder: folder of `results.jsonl`, or that file.
        out: folder of the report; None: the folder of the results.
        force: whether to overwrite an earlier report.

    Returns:
        Paths of the files.

    Raises:
        ValueError: there are no results, or there are files and not `force`.
    """
    records = last_of_each(read_results(folder, ("cell", "replicate"), "outcome"))
    if not records:
        raise ValueError(
            f"{folder}: expected results of a sweep ({RESULTS_FILE}), got none; `softhand sweep` "
            "makes them"
        )
    out = out or (folder if folder.is_dir() else folder.parent)
    groups = groups_of(records)
    maps = {group.name: group.map for group in groups if group.map is not None}
    files = [out / name for name in (PAGE, REPORT_DATA, SHARES, *([MAPS] if maps else []))]
    for file in files:
        check_new(file, force)
    compared = agreements(records)
    write_new(out / PAGE, page(groups, maps, compared), force)
    engines = {"engines": [agreement.record() for agreement in compared]}
    write_json(out / REPORT_DATA, document(groups, records) | engines, force)
    shares = [group.share for group in groups], [group.interval for group in groups]
    figure = shares_figure([group.name for group in groups], *shares)
    save_figure(figure, out / SHARES, dpi=FIGURE_DPI)
    if maps:
        save_figure(maps_figure(maps), out / MAPS, dpi=FIGURE_DPI)
    return files


def last_of_each(records: Sequence[Record]) -> list[Record]:
    """The latest record of each trial, since a trial that raised an error is tried again."""
    return list({record["key"]: record for record in records}.values())


def page(
    groups: Sequence[Group], maps: dict[str, SuccessMap], compared: Sequence[Agreement] = ()
) -> str:
    """The tables in Markdown, with the pictures, and with a table of the engines if some were
    `compared`.
    """
    rows: list[tuple[str, ...]] = [("trials", "gripped", "share", "95 % interval", "failures")]
    rows += [_shares_row(group) for group in groups]
    names = ["sweep, object, variant", *(group.name for group in groups)]
    text = ["# Report of a sweep", _table(names, rows), f"![Shares of success]({SHARES})"]
    if any(group.contacts for group in groups):
        rows = [CONTACT_COLUMNS, *map(_contacts_row, groups)]
        text += ["## Contacts of what is held", CONTACTS_TEXT, _table(names, rows)]
    if compared:
        rows = [("trials in all", *compared[0].engines, "same verdict", "differ, gripped in")]
        rows += map(_engines_row, compared)
        names = ["sweep, object, variant", *(agreement.name for agreement in compared)]
        text += ["## Engines", _table(names, rows)]
    if maps:
        head = ("region [cm2]", "radius [mm]", "centre [mm]", "largest part", "largest hole")
        rows = [(*head, "fuzziness", "ends within the grid"), *map(_map_row, maps.values())]
        text += ["## Maps", MAPS_TEXT, _table(["map", *maps], rows), f"![Maps]({MAPS})"]
    return "\n\n".join(text) + "\n"


CONTACTS_TEXT = """Means over the successes, at the end of the hold: contact points (they depend on
the engine), links and parts of the hand that touch, area of the skin's patches, redundancy of the
forces, share that is force-closed, and the least wrench resisted for 1 N of normal forces (torque
over half the object's diagonal)."""
CONTACT_COLUMNS = (
    *("points", "links", "parts", "area [cm2]"),
    *("redundancy", "force-closed", "margin [-]"),
)

MAPS_TEXT = """Region: cells in which at least half of the jittered trials succeed. Its largest
4-connected part as a share of it; its largest hole in cells; fuzziness: cells with a share between
0.2 and 0.8 over the sides of its border."""


def _shares_row(group: Group) -> tuple[str, ...]:
    failures = ", ".join(f"{what} {count}" for what, count in group.failures.most_common())
    low, high = group.interval
    counts = str(len(group.records)), str(group.gripped), f"{group.share:.2f}"
    return (*counts, f"{low:.2f} to {high:.2f}", failures or "-")


def _contacts_row(group: Group) -> tuple[str, ...]:
    found = group.contacts
    if found is None:
        return ("-",) * len(CONTACT_COLUMNS)
    counts = (found["points"], found["links"], found["parts"], 1e4 * found["area"])
    told = [f"{value:.1f}" for value in (*counts, found["redundancy"])]
    return (*told, f"{found['force_closed']:.2f}", f"{found['margin']:.3f}")


def _engines_row(found: Agreement) -> tuple[str, ...]:
    differing = [f"{trial}: {', '.join(held)}" for trial, held in found.differing.items()]
    counts = map(str, (len(found.verdicts), *found.gripped.values(), found.same))
    return (*counts, "; ".join(differing) or found.refusal or "-")


def _map_row(found: SuccessMap) -> tuple[str, ...]:
    x, y = (1e3 * value for value in found.centre)
    return (
        f"{1e4 * found.area:.1f}",
        f"{1e3 * found.equivalent_radius:.0f}",
        f"{x:.0f}, {y:.0f}" if found.region.any() else "-",
        f"{largest_share(found.region):.2f}" if found.region.any() else "-",
        str(largest_hole(found.region)),
        f"{found.fuzziness:.2f}",
        "no" if found.reaches_border else "yes",
    )


def _table(names: Sequence[str], rows: Sequence[tuple[str, ...]]) -> str:
    """A table in Markdown, the first row its head."""
    lines = [f"| {' | '.join((name, *row))} |" for name, row in zip(names, rows, strict=True)]
    lines.insert(1, "| --- " * (1 + len(rows[0])) + "|")
    return "\n".join(lines)


def document(groups: Sequence[Group], records: Sequence[Record]) -> dict[str, Any]:
    """The report as plain data, SI units."""
    return {
        "format": FORMAT,
        "trials": len(records),
        "errors": sum("error" in record for record in records),
        "cpu_time": float(np.sum([record.get("cpu_time", 0.0) for record in records])),
        "code": codes_of(records),
        "groups": [
            {
                "name": group.name,
                "trials": len(group.records),
                "gripped": group.gripped,
                "share": group.share,
                "interval": group.interval,
                "failures": dict(group.failures.most_common()),
                "contacts": group.contacts,
                "map": None if group.map is None else _map_data(group.map),
            }
            for group in groups
        ],
    }


def _map_data(found: SuccessMap) -> dict[str, Any]:
    names = ("xs", "ys", "once", "filtered", "share", "area", "equivalent_radius", "centre")
    plain = {name: getattr(found, name) for name in (*names, "fuzziness", "reaches_border")}
    parts = {"largest_share": largest_share(found.region), "hole": largest_hole(found.region)}
    return plain | parts
