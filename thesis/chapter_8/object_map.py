"""Maps of success over the displacement of RBO Hand 1, one for each object of Table 8.1.

Shared by the push grasp and the surface-constrained grasp: plans of the sweeps, maps, findings
about each map, and the figure. The thesis states neither the objects of each map nor grid and axes;
those used here are our choice.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from grasp_strategies.judging.judge import OUTCOME_GRIPPED
from pneuflex_sim.engines import check_engines
from pneuflex_sim.scene.friction import RUBBER_MATERIAL, load_friction
from pneuflex_sim.scene.objects import load_object
from softhand_common.documents.quoted import listed
from softhand_trials.sweep import Jitter, SweepPlan
from softhand_trials.sweep.plan import Cell, SweptObject, grid
from softhand_trials.sweep.report import wilson
from softhand_trials.sweep.results import read_results
from softhand_trials.sweep.run import run_tasks
from softhand_trials.sweep.success_map import SuccessMap, finished, largest_hole, largest_share
from softhand_trials.trials import TrialSettings
from thesis.chapter_8.map_evidence import (
    MAIN,
    SMALL_EVIDENCE,
    Evidence,
    judged_again,
    other_engines,
    sampled,
)
from thesis.frame import Finding, Job, Results, option

UPRIGHT = (0.0, 0.0, 0.0)  # rpy of a cylinder that stands [rad]
YIELDING = ("water_balloon", "tissue")  # reported apart: their models are coarse
ALL = (
    *("cylinder", "tube", "marker", "water_bottle", "tape_dispenser", "staple_remover"),
    *("paper_cup", "sunglasses", "water_balloon", "tissue"),
)
SMALL_MAP = {"objects": ("cylinder", "marker"), "pitch": 0.06, **SMALL_EVIDENCE}
LEAST_SHARE = 0.8  # of the successes in the largest component


@dataclass(frozen=True)
class MapParameters(Evidence):
    """Options of a map."""

    x: tuple[float, ...] = option((-0.06, 0.06), "first and last displacement in x [m]")
    y: tuple[float, ...] = option((-0.08, 0.08), "first and last displacement in y [m]")
    pitch: float = option(0.040, "of the grid [m]")
    objects: tuple[str, ...] = option(ALL, "names of objects [-]")
    replicates: int = option(1, "jittered trials of a cell beside the one without [-]")
    checks: tuple[str, ...] = option((), "other sweeps beside the maps, by name [-]")

    def __post_init__(self) -> None:
        check_names(self.checks, type(self).checks)

    def continued(self, folder: Path) -> Self:
        """These parameters with the objects and checks that already have trials in the folder: a
        run adds to them.
        """
        objects = [record["object"] for record in read_results(folder / MAIN)]
        checks = [name for name in type(self).checks if read_results(folder / name)]
        return replace(
            self,
            objects=tuple(dict.fromkeys([*objects, *self.objects])),
            checks=tuple(dict.fromkeys([*checks, *self.checks])),
        )


def check_names(given: Iterable[str], known: Iterable[str]) -> None:
    """Raise ValueError unless these checks are among those that there are."""
    if unknown := [name for name in given if name not in known]:
        raise ValueError(f"checks: expected some of {listed(known)}, got {listed(unknown)}")


@dataclass(frozen=True)
class Check:
    """A sweep in addition to the maps: the settings that differ, its replicates and seed, and
    whether whole maps are compared, for which a sample of the trials is not enough.
    """

    settings: Mapping[str, Any]
    replicates: int = 0
    other_seed: int = 0
    whole: bool = False


# factors [-] by which the rubber has these coefficients on wood, and others on other things
ON_WOOD = load_friction().pair(RUBBER_MATERIAL, "wood")
RUBBER = {f"rubber_{value:g}": value / ON_WOOD for value in (0.5, 0.7, 1.0)}
RUBBER_CHECKS = {name: Check({"rubber_friction_scale": RUBBER[name]}) for name in RUBBER}


def headline(names: Sequence[str], given: MapParameters) -> tuple[str, ...]:
    """The headline objects among those asked for."""
    return tuple(name for name in names if name in given.objects)


def map_plan(
    name: str, strategy: str, given: MapParameters, upright: Sequence[str] = ()
) -> SweepPlan:
    """Plan of the maps: each object as near to the origin as possible while it lies in x > 0, y < 0
    (section 8.1.2); each cell once without jitter and `replicates` times with jitter.
    """
    objects = tuple(placed(object, object in upright) for object in given.objects)
    settings = TrialSettings(
        strategy,
        model="rbo_hand_1",
        segments=10,
        step=given.step,
        early_end=True,
        engine=given.engines[0],
    )
    axes = [(first, last, given.pitch) for first, last in (given.x, given.y)]
    return SweepPlan(
        name,
        settings,
        objects,
        grid(*axes),
        replicates=given.replicates,
        nominal=True,
        seed=given.seed,
        jitter=Jitter(),
    )


def placed(name: str, upright: bool) -> SweptObject:
    """An object that touches the planes x = 0 and y = 0 from x > 0 and y < 0."""
    described = load_object(name)
    settings = {"object_rpy": UPRIGHT} if upright else {}
    if upright:
        described = replace(described, rpy=UPRIGHT)
    return SweptObject(name, described.corner_place, settings)


def check_plan(main: SweepPlan, name: str, check: Check, headline: Sequence[str]) -> SweepPlan:
    """The plan of a check on the headline objects."""
    return replace(
        main,
        name=f"{main.name}-{name}",
        settings=replace(main.settings, **check.settings),
        objects=tuple(swept for swept in main.objects if swept.name in headline),
        replicates=check.replicates,
        nominal=check.replicates == 0,
        seed=main.seed + check.other_seed,
    )


def run_maps(
    main: SweepPlan,
    checks: Mapping[str, Check],
    headline: Sequence[str],
    given: MapParameters,
    job: Job,
) -> Results:
    """Run the maps, also in further engines, and the checks; trials with results in the job's
    folder are not run again.
    """
    check_engines(given.engines)
    plans = {MAIN: main}
    plans |= {name: check_plan(main, name, check, headline) for name, check in checks.items()}
    sweeps, evidence = {}, {}
    for number, (name, plan) in enumerate(plans.items()):
        job.progress(name, number / len(plans))
        whole = name == MAIN or checks[name].whole
        lines = plan.tasks() if whole else sampled(plan, given)
        records = finished(run_tasks(lines, job.folder / name, given.jobs, name=plan.name))
        sweeps[name] = tallies(records, plan)
        if name == MAIN:
            others = other_engines(plan, given, job.folder)
            sweeps |= {f"{MAIN}_{engine}": tallies(others[engine], plan) for engine in others}
            evidence = judged_again(plan, {given.engines[0]: records, **others}, given, job.folder)
    xs, ys = (sorted({cell[axis] for cell in main.cells}) for axis in (0, 1))
    return {"xs": xs, "ys": ys, "engine": given.engines[0], "sweeps": sweeps, **evidence}


def tallies(records: Sequence[Mapping[str, Any]], plan: SweepPlan) -> dict[str, dict[str, Any]]:
    """The tally of each object of which no trial was refused."""
    refused = {record["object"] for record in records if "error" in record}
    names = [swept.name for swept in plan.objects if swept.name not in refused]
    return {name: tally(records, name, plan.cells) for name in names}


def tally(records: Iterable[Mapping[str, Any]], name: str, cells: Sequence[Cell]) -> dict[str, Any]:
    """Of an object: by replicate, success (1) or not (0) in each of the cells [m] in order, None
    where there was no trial; and the cells of its failures by cause.
    """
    replicates: dict[str, dict[Cell, int]] = {}
    failed: dict[str, list[Cell]] = {}
    for record in records:
        if record["object"] == name:
            cell, gripped = tuple(record["cell"]), record["outcome"] == OUTCOME_GRIPPED
            replicates.setdefault(str(record["replicate"]), {})[cell] = int(gripped)
            if not gripped:
                failed.setdefault(str(record["cause"]), []).append(cell)
    return {
        "replicates": {
            key: [found.get(cell) for cell in sorted(cells)] for key, found in replicates.items()
        },
        "failed": failed,
    }


def cells_of(results: Results, sweep: str, name: str) -> dict[int, np.ndarray]:
    """Successes (nx, ny) by number of the replicate, NaN where there was no trial; 0 is the trial
    without jitter.
    """
    shape = len(results["xs"]), len(results["ys"])
    found = results["sweeps"][sweep][name]["replicates"]
    return {int(key): np.array(cells, float).reshape(shape) for key, cells in found.items()}


def success_map(results: Results, name: str) -> SuccessMap:
    """The map of an object; where no trial is jittered, those without jitter stand in for them."""
    cells = {key: found.astype(bool) for key, found in cells_of(results, MAIN, name).items()}
    once = cells.pop(0)
    axes = np.array(results["xs"]), np.array(results["ys"])
    return SuccessMap(*axes, once, np.array([cells[k] for k in sorted(cells)] or [once]))


def maps_of(results: Results) -> dict[str, SuccessMap]:
    """Maps by object."""
    return {name: success_map(results, name) for name in results["sweeps"][MAIN]}


# ---------------------------------------------------------------- findings
def about(
    name: str, found: SuccessMap, failed: Mapping[str, Sequence[Sequence[float]]]
) -> list[Finding]:
    """What a map shows, and by what trials failed and where, the four most frequent causes."""
    count = found.replicates.size
    low, high = wilson(int(found.replicates.sum()), count)
    ring = ", to the grid's end" if found.reaches_border else ""
    x, y = (1e3 * value for value in found.centre)
    where = f" about ({x:.0f}, {y:.0f}) mm" if found.region.any() else ""
    ours = (
        f"{found.once.sum()} of {found.once.size} cells, share {found.replicates.mean():.2f} "
        f"({low:.2f} to {high:.2f}); {1e4 * found.area:.0f} cm2{where}, radius "
        f"{1e3 * found.equivalent_radius:.0f} mm; largest part {_share(found)}, "
        f"hole {largest_hole(found.region)}, fuzziness {found.fuzziness:.2f}{ring}"
    )
    spoken = name.replace("_", " ")
    return [
        Finding(spoken, "a picture", ours),
        Finding(f"{spoken}, failures", "-", _frequent(failed, 4)),
    ]


def _frequent(failed: Mapping[str, Sequence[Sequence[float]]], named: int) -> str:
    """The most frequent causes of failures with the middle half of their cells [m], and the sum of
    the others.

    >>> _frequent({"missed": [(0.0, 0.0)], "tipped": [(0.02, 0.0)] * 3}, 1)
    'tipped 3 (x 20 to 20, y 0 to 0 mm), others 1'
    """
    ordered = sorted(failed, key=lambda cause: -len(failed[cause]))
    rows = [f"{cause} {len(failed[cause])} ({_middle(failed[cause])})" for cause in ordered[:named]]
    others = sum(len(failed[cause]) for cause in ordered[named:])
    return ", ".join([*rows, *([f"others {others}"] if others else [])]) or "none"


def _middle(cells: Sequence[Sequence[float]]) -> str:
    """Between which displacements the middle half of these cells [m] lies, in either axis."""
    low, high = 1e3 * np.quantile(np.array(cells), (0.25, 0.75), axis=0)
    ends = zip("xy", low, high, strict=True)
    return ", ".join(f"{axis} {first:.0f} to {last:.0f}" for axis, first, last in ends) + " mm"


def _share(found: SuccessMap) -> str:
    share = largest_share(found.region)
    return "none" if math.isnan(share) else f"{share:.2f}"


def region_findings(maps: Mapping[str, SuccessMap], objects: Sequence[str]) -> list[Finding]:
    """Whether the region of success of each object is connected."""
    shares = {name: largest_share(maps[name].region) for name in objects}
    holes = {name: largest_hole(maps[name].region) for name in objects}
    worst = min(shares, key=lambda name: np.nan_to_num(shares[name], nan=-1.0))
    widest = max(holes, key=lambda name: holes[name])
    return [
        Finding(
            "largest component, least share of the successes",
            "extended, contiguous region",
            f"{_share(maps[worst])}, {worst} (>= {LEAST_SHARE})",
            bool(shares[worst] >= LEAST_SHARE),
        ),
        Finding("largest hole", "-", f"{holes[widest]} cells, {widest} (<= 2)", holes[widest] <= 2),
    ]


def shared_cell(maps: Mapping[str, SuccessMap], objects: Sequence[str]) -> tuple[int, Cell]:
    """Largest number of regions that share a cell, and that cell [m]."""
    counts = np.sum([maps[name].region for name in objects], axis=0)
    x, y = np.unravel_index(int(np.argmax(counts)), counts.shape)
    first = maps[objects[0]]
    return int(counts.max()), (float(first.xs[x]), float(first.ys[y]))


def shared_finding(
    maps: Mapping[str, SuccessMap], objects: Sequence[str], least: int, thesis: str
) -> Finding:
    """Whether enough regions overlap in a cell."""
    count, (x, y) = shared_cell(maps, objects)
    ours = f"{count} of {len(objects)} at ({1e3 * x:.0f}, {1e3 * y:.0f}) mm (>= {least})"
    return Finding("regions that overlap in a cell", thesis, ours, count >= least)


def rubber_row(name: str) -> str:
    """What a row about another friction of the rubber is called."""
    return f"friction of the rubber on wood {RUBBER[name] * ON_WOOD:g}, not {ON_WOOD:g}"


def sensitivity(results: Results, name: str, objects: Sequence[str]) -> Finding:
    """Finding about another friction of the rubber: cells without jitter that succeed."""
    before, after, tried = compared(results, name, objects)
    return Finding(rubber_row(name), "-", f"{before} -> {after} of {tried} cells")


def compared(results: Results, name: str, objects: Sequence[str]) -> tuple[int, int, int]:
    """Successes without jitter in the maps and in a check, and the cells that the check tried."""
    pairs = [[cells_of(results, sweep, n)[0] for sweep in (MAIN, name)] for n in objects]
    before, after = np.array(pairs).swapaxes(0, 1)
    tried = ~np.isnan(after)
    return int(before[tried].sum()), int(after[tried].sum()), int(tried.sum())


def shrinking(
    results: Results, name: str, what: str, objects: Sequence[str], least: float
) -> Finding:
    """Finding about a negative control that must reduce the mean area by a share; from cells
    without jitter.
    """
    before, after, tried = compared(results, name, objects)
    lost = 1.0 - after / before if before else 0.0
    ours = f"{before} -> {after} of {tried} cells: {100 * lost:.0f} % fewer (>= {100 * least:.0f})"
    return Finding(f"negative control: {what}", "-", ours, lost >= least)
