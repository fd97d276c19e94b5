"""Push grasp with RBO Hand 1 over the place of the hand (8.1.2, Fig. 8.4)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from softhand_trials.sweep.success_map import Cells, correlation, overlap, window_mean
from thesis.chapter_8.map_evidence import MAIN, evidence_findings
from thesis.chapter_8.map_picture import PICTURE, draw_map
from thesis.chapter_8.object_map import (
    RUBBER_CHECKS,
    SMALL_MAP,
    Check,
    MapParameters,
    about,
    cells_of,
    compared,
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
HEADLINE = ("water_bottle", "paper_cup", "cylinder", "tube", "tape_dispenser", "marker")
UPRIGHT = ("water_bottle", "cylinder", "tube")  # the cup stands as it is described
STEP, OTHER, NO_AIR, NO_PUSH = "other_step", "other_jitter", "no_air", "no_advance"
CHECKS = {
    STEP: Check({"step": 0.005}, whole=True),
    OTHER: Check({}, replicates=1, other_seed=1, whole=True),
    NO_AIR: Check({"air_scale": 0.0}),
    NO_PUSH: Check({"without": ("advance",)}),
    **RUBBER_CHECKS,
}


@dataclass(frozen=True)
class Parameters(MapParameters):
    """Options of the experiment."""

    checks: tuple[str, ...] = option(tuple(CHECKS), "sweeps beside the maps, by name [-]")

    def __post_init__(self) -> None:
        super().__post_init__()
        if OTHER in self.checks and not self.replicates:
            raise ValueError(f"checks: expected no {OTHER} without jittered trials, got it")


SMALL = {**SMALL_MAP, "checks": (NO_AIR,)}


def run(given: Parameters, job: Job) -> Results:
    """The maps, and the checks on the six headline objects."""
    main = map_plan("push_map", "rbo_hand_1_push", given, UPRIGHT)
    checks = {name: CHECKS[name] for name in given.checks}
    return run_maps(main, checks, headline(HEADLINE, given), given, job)


def report(results: Results, given: Parameters) -> Report:
    """A row a map, then the criteria; the thesis tells of them in words and pictures alone."""
    maps, objects = maps_of(results), headline(HEADLINE, given)
    failed = {name: found["failed"] for name, found in results["sweeps"][MAIN].items()}
    findings = [row for name in maps for row in about(name, maps[name], failed[name])]
    somewhere = sum(maps[name].once.any() for name in objects)
    areas = {name: maps[name].area for name in objects}
    smallest = min(areas, key=lambda name: areas[name])
    findings += [
        Finding(
            "objects that succeed somewhere",
            "all",
            f"{somewhere} of {len(objects)}",
            bool(somewhere == len(objects)),
        ),
        *region_findings(maps, objects),
        Finding(
            "smallest region",
            "marker: most difficult",
            f"{smallest}, {1e4 * areas[smallest]:.0f} cm2",
            smallest == "marker",
        ),
        shared_finding(maps, objects, 4, "large overlaps"),
        *evidence_findings(results, given.step),
        *(_checked(name, results, objects) for name in given.checks),
    ]
    return Report(
        findings,
        f"The push grasp succeeds somewhere with {somewhere} of {len(objects)} objects; the "
        f"smallest region is the {smallest}'s.",
    )


def _step(results: Results, objects: tuple[str, ...]) -> Finding:
    pairs = _pairs(results, STEP, 0, objects)
    overlaps = {n: overlap(first, second) for n, (first, second) in pairs.items()}
    similar = _correlations(pairs)
    enough = min(overlaps.values()) >= 0.7 and min(similar.values()) >= 0.8
    ours = f"overlap {_least(overlaps)} (>= 0.7), correlation {_least(similar)} (>= 0.8)"
    return Finding("maps at 2 and 5 ms, the object that agrees least", "-", ours, enough)


def _other(results: Results, objects: tuple[str, ...]) -> Finding:
    pairs = _pairs(results, OTHER, 1, objects)
    similar = _correlations(pairs)
    ours = f"correlation {_least(similar)} (>= 0.8)"
    enough = min(similar.values()) >= 0.8
    return Finding(
        "a repetition with other jitter, the object that agrees least", "-", ours, enough
    )


def _pairs(
    results: Results, check: str, replicate: int, objects: tuple[str, ...]
) -> dict[str, tuple[Cells, Cells]]:
    """Successes (nx, ny) of a replicate in the map and in a check of whole maps, by object."""

    def cells(sweep: str, name: str) -> Cells:
        return cells_of(results, sweep, name)[replicate].astype(bool)

    return {name: (cells(MAIN, name), cells(check, name)) for name in objects}


def _correlations(pairs: Mapping[str, tuple[Cells, Cells]]) -> dict[str, float]:
    """Correlation of two filtered maps by object, 0 where only one map is even."""
    filtered = {
        n: (window_mean(first), window_mean(second)) for n, (first, second) in pairs.items()
    }
    return {n: float(np.nan_to_num(correlation(*pair))) for n, pair in filtered.items()}


def _least(by_object: Mapping[str, float]) -> str:
    """The least value, and whose it is."""
    name = min(by_object, key=lambda name: by_object[name])
    return f"{by_object[name]:.2f} ({name.replace('_', ' ')})"


def _no_air(results: Results, objects: tuple[str, ...]) -> Finding:
    _, count, tried = compared(results, NO_AIR, objects)
    return Finding("negative control: 0 kPa", "-", f"{count} successes of {tried} (0)", count == 0)


def _no_push(results: Results, objects: tuple[str, ...]) -> Finding:
    return shrinking(results, NO_PUSH, "without the advance", objects, 0.3)


_CHECKED = {STEP: _step, OTHER: _other, NO_AIR: _no_air, NO_PUSH: _no_push}


def _checked(name: str, results: Results, objects: tuple[str, ...]) -> Finding:
    found = _CHECKED.get(name)
    return found(results, objects) if found else sensitivity(results, name, objects)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Maps of all objects, where engines differ, and by what trials failed."""
    draw_map(figure, results)
