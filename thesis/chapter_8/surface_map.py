"""Surface-constrained grasp with RBO Hand 1 over the place of the hand (8.1.2, Fig. 8.6)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from thesis.chapter_8.map_evidence import MAIN, evidence_findings
from thesis.chapter_8.map_picture import PICTURE, draw_map
from thesis.chapter_8.object_map import (
    ALL,
    RUBBER_CHECKS,
    SMALL_MAP,
    YIELDING,
    Check,
    MapParameters,
    about,
    headline,
    map_plan,
    maps_of,
    region_findings,
    run_maps,
    sensitivity,
    shared_finding,
    shrinking,
)
from thesis.frame import Figure, Finding, Job, Report, Results, option

SIZE = PICTURE
HEADLINE = tuple(name for name in ALL if name not in ("water_bottle", "paper_cup"))
FUZZY = ("sunglasses", "marker")
NO_ROLL, SLIPPERY = "no_roll", "ptfe_table"
PTFE_TABLE = Path(__file__).with_name("ptfe_table.yaml")
CHECKS = {
    NO_ROLL: Check({"without": ("roll",)}),
    SLIPPERY: Check({"scene": str(PTFE_TABLE)}),
    **RUBBER_CHECKS,
}
LEAST_CELLS = 4  # of a region
NEAR = 0.030  # [m] of a region's centre from the mean of the centres


@dataclass(frozen=True)
class Parameters(MapParameters):
    """Options of the experiment."""

    checks: tuple[str, ...] = option(tuple(CHECKS), "sweeps beside the maps, by name [-]")


SMALL = {**SMALL_MAP, "checks": (NO_ROLL,)}


def run(given: Parameters, job: Job) -> Results:
    """The maps, and the checks on the eight headline objects."""
    main = map_plan("surface_map", "rbo_hand_1_surface", given)
    checks = {name: CHECKS[name] for name in given.checks}
    return run_maps(main, checks, headline(HEADLINE, given), given, job)


def report(results: Results, given: Parameters) -> Report:
    """A row a map, then the criteria; those on regions are asked of rigid objects alone."""
    maps, objects = maps_of(results), headline(HEADLINE, given)
    rigid = tuple(name for name in objects if name not in YIELDING)
    failed = {name: found["failed"] for name, found in results["sweeps"][MAIN].items()}
    wide = sum(int(maps[name].region.sum()) >= LEAST_CELLS for name in rigid)
    findings = [row for name in maps for row in about(name, maps[name], failed[name])]
    findings += [
        Finding(
            f"rigid objects with a region of {LEAST_CELLS} cells or more",
            "all have a contiguous region",
            f"{wide} of {len(rigid)}",
            wide == len(rigid),
        ),
        *region_findings(maps, rigid),
        shared_finding(maps, objects, 5, "large overlaps"),
        _fuzziest(maps, rigid),
        _centres(maps, rigid),
        *evidence_findings(results, given.step),
        *(_checked(name, results, objects) for name in given.checks),
    ]
    return Report(
        findings, f"{wide} of {len(rigid)} rigid objects have a region in which the grasp succeeds."
    )


def _fuzziest(maps: dict, rigid: tuple[str, ...]) -> Finding:
    order = sorted(rigid, key=lambda name: -maps[name].fuzziness)[:3]
    return Finding(
        "three fuzziest rigid objects",
        "sunglasses and marker are fuzzy",
        ", ".join(f"{name} {maps[name].fuzziness:.2f}" for name in order),
        set(FUZZY) <= set(order),
    )


def _centres(maps: dict, rigid: tuple[str, ...]) -> Finding:
    centres = np.array([maps[name].centre for name in rigid if maps[name].region.any()])
    if not len(centres):
        return Finding("centres of the regions", "large overlaps", "there is no region", False)
    farthest = float(np.linalg.norm(centres - centres.mean(axis=0), axis=1).max())
    ours = f"{1e3 * farthest:.0f} mm from their mean at most (<= {1e3 * NEAR:.0f})"
    return Finding("centres of the regions", "large overlaps", ours, farthest <= NEAR)


def _no_roll(results: Results, objects: tuple[str, ...]) -> Finding:
    return shrinking(results, NO_ROLL, "without the roll", objects, 0.3)


def _slippery(results: Results, objects: tuple[str, ...]) -> Finding:
    return shrinking(results, SLIPPERY, "table of PTFE", objects, 0.3)


_CHECKED = {NO_ROLL: _no_roll, SLIPPERY: _slippery}


def _checked(name: str, results: Results, objects: tuple[str, ...]) -> Finding:
    found = _CHECKED.get(name)
    return found(results, objects) if found else sensitivity(results, name, objects)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Maps of all objects, where engines differ, and by what trials failed."""
    draw_map(figure, results)
