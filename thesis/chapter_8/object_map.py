"""Maps of success over the displacement of RBO Hand 1, one for each object of Table 8.1.

Shared by the push grasp and the surface-constrained grasp: plans of the sweeps, maps, findings
about each map, and the figure. The thesis states neither the objects of each map nor grid and axes;
those used here are our choice.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from pneuflex_sim.engines import check_engines, default_engine
from pneuflex_sim.scene.friction import load_friction
from pneuflex_sim.scene.objects import load_object
from softhand_common.documents.quoted import listed
from softhand_trials.sweep import Jitter, SweepPlan, run_sweep
from softhand_trials.sweep.plan import Cell, SweptObject, grid
from softhand_trials.sweep.report import agreements, wilson
from softhand_trials.sweep.results import read_results
from softhand_trials.sweep.success_map import SuccessMap, finished, largest_hole, largest_share
from softhand_trials.trials import TrialSettings
from thesis.frame import Finding, Job, Results, option

UPRIGHT = (0.0, 0.0, 0.0)  # rpy of a cylinder that stands [rad]
YIELDING = ("water_balloon", "tissue")  # reported apart: their models are coarse
ALL = (
    *("cylinder", "tube", "marker", "water_bottle", "tape_dispenser", "staple_remover"),
    *("paper_cup", "sunglasses", "water_balloon", "tissue"),
)
MAIN = "main"  # name of the sweep that makes the maps
SMALL_MAP = {"objects": ("cylinder", "marker"), "pitch": 0.06, "replicates": 1}
LEAST_SHARE = 0.8  # of the successes in the largest component


def engines_option() -> Any:
    """The option of a map for its engines."""
    usual = (default_engine(),)
    return option(usual, "physics engine of the map; others run its trials to compare [-]")


@dataclass(frozen=True)
class MapParameters:
    """Options of a map."""

    x: tuple[float, ...] = option((-0.06, 0.06), "first and last displacement in x [m]")
    y: tuple[float, ...] = option((-0.08, 0.08), "first and last displacement in y [m]")
    pitch: float = option(0.010, "of the grid [m]")
    objects: tuple[str, ...] = option(ALL, "names of objects [-]")
    replicates: int = option(3, "jittered trials of a cell [-]")
    checks: tuple[str, ...] = option((), "other sweeps beside the maps, by name [-]")
    step: float = option(0.005, "of the physics [s]")
    seed: int = option(0, "of the jitter [-]")
    jobs: int = option(2, "processes [-]")
    engines: tuple[str, ...] = engines_option()

    def __post_init__(self) -> None:
        known = type(self).checks
        if unknown := [name for name in self.checks if name not in known]:
            raise ValueError(f"checks: expected some of {listed(known)}, got {listed(unknown)}")

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


@dataclass(frozen=True)
class Check:
    """A sweep in addition to the maps: the settings that differ, its replicates and seed, and
    whether it is a negative control.
    """

    settings: Mapping[str, Any]
    replicates: int = 0
    other_seed: int = 0


# the rubber's friction with anything else at both ends of its range [-]
RUBBER = dict(zip(("less_friction", "more_friction"), load_friction().rubber_range, strict=True))
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
    sweeps, engines = {}, []
    for number, (name, plan) in enumerate(plans.items()):
        job.progress(name, number / len(plans))
        records = finished(run_sweep(plan, job.folder / name, given.jobs))
        if name == MAIN:
            engines = compared(plan, records, given.engines, job.folder, given.jobs)
        sweeps[name] = {swept.name: tally(records, swept.name) for swept in plan.objects}
    xs, ys = (sorted({cell[axis] for cell in main.cells}) for axis in (0, 1))
    return {"xs": xs, "ys": ys, "sweeps": sweeps, "engines": engines}


def compared(
    main: SweepPlan,
    records: Sequence[Mapping[str, Any]],
    engines: Sequence[str],
    folder: Path,
    jobs: int,
) -> list[dict[str, Any]]:
    """Run the trials of a map, whose records are given, in all engines but the first; how far they
    agree (`Agreement.record`), by object. An engine may refuse an object.
    """
    found = [dict(record) for record in records]
    for engine in engines[1:]:
        plan = main.in_engines([engine])
        found += run_sweep(plan, folder / f"{MAIN}_{engine}", jobs)
    return [agreement.record() for agreement in agreements(found)]


def tally(records: Iterable[Mapping[str, Any]], name: str) -> dict[str, Any]:
    """Of an object: cells [m] with success (1) or not by replicate, and the causes of failures."""
    replicates: dict[str, list[tuple[Cell, int]]] = {}
    causes: Counter[str] = Counter()
    for record in records:
        if record["object"] == name:
            gripped = record.get("outcome") == "gripped"
            cells = replicates.setdefault(str(record["replicate"]), [])
            cells.append((tuple(record["cell"]), int(gripped)))
            causes.update([] if gripped else [str(record.get("cause"))])
    return {
        "replicates": {key: [g for _, g in sorted(cells)] for key, cells in replicates.items()},
        "causes": dict(causes.most_common()),
    }


def cells_of(results: Results, sweep: str, name: str) -> dict[int, np.ndarray]:
    """Successes (nx, ny) by number of the replicate; 0 is the trial without jitter."""
    shape = len(results["xs"]), len(results["ys"])
    found = results["sweeps"][sweep][name]["replicates"]
    return {int(key): np.array(cells, bool).reshape(shape) for key, cells in found.items()}


def success_map(results: Results, name: str, sweep: str = MAIN) -> SuccessMap:
    """The map of an object."""
    cells = cells_of(results, sweep, name)
    once = cells.pop(0)
    axes = np.array(results["xs"]), np.array(results["ys"])
    return SuccessMap(*axes, once, np.array([cells[k] for k in sorted(cells)]))


def maps_of(results: Results) -> dict[str, SuccessMap]:
    """Maps by object."""
    return {name: success_map(results, name) for name in results["sweeps"][MAIN]}


# ---------------------------------------------------------------- findings
def engine_findings(results: Results) -> list[Finding]:
    """A row an object on trials that several engines ran, and where they differ."""
    rows = results.get("engines", [])
    return [Finding(f"engines, {found['name']}", "-", found["text"]) for found in rows]


def about(name: str, found: SuccessMap, causes: Mapping[str, int]) -> list[Finding]:
    """What a map shows, and why trials failed, the four most frequent causes by name."""
    count = found.replicates.size
    low, high = wilson(int(found.replicates.sum()), count)
    ring = ", to the grid's end" if found.reaches_border else ""
    x, y = (1e3 * value for value in found.centre)
    where = f" about ({x:.0f}, {y:.0f}) mm" if found.region.any() else ""
    ours = (
        f"{found.once.sum()} of {found.once.size} cells, jittered {found.replicates.mean():.2f} "
        f"({low:.2f} to {high:.2f}); {1e4 * found.area:.0f} cm2{where}, radius "
        f"{1e3 * found.equivalent_radius:.0f} mm; largest part {_share(found)}, "
        f"hole {largest_hole(found.region)}, fuzziness {found.fuzziness:.2f}{ring}"
    )
    spoken = name.replace("_", " ")
    return [
        Finding(spoken, "a picture", ours),
        Finding(f"{spoken}, failures", "-", _frequent(causes, 4)),
    ]


def _frequent(causes: Mapping[str, int], named: int) -> str:
    """The most frequent causes of failures, and the sum of the others.

    >>> _frequent({"missed": 1, "tipped": 5, "rolled away": 2}, 1)
    'tipped 5, others 3'
    """
    ordered = Counter(causes).most_common()
    others = sum(number for _, number in ordered[named:])
    rows = [*ordered[:named], *([("others", others)] if others else [])]
    return ", ".join(f"{cause} {number}" for cause, number in rows) or "none"


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


def sensitivity(results: Results, name: str, objects: Sequence[str]) -> Finding:
    """Finding about another friction of the rubber: cells without jitter that succeed."""
    before, after = (
        sum(int(cells_of(results, sweep, object)[0].sum()) for object in objects)
        for sweep in (MAIN, name)
    )
    return Finding(f"friction of the rubber x {RUBBER[name]:g}", "-", f"{before} -> {after} cells")


def shrinking(
    results: Results, name: str, what: str, objects: Sequence[str], least: float
) -> Finding:
    """Finding about a negative control that must reduce the mean area by a share; from cells
    without jitter.
    """
    before = sum(int(cells_of(results, MAIN, object)[0].sum()) for object in objects)
    after = sum(int(cells_of(results, name, object)[0].sum()) for object in objects)
    lost = 1.0 - after / before if before else 0.0
    ours = f"{before} -> {after} cells: {100 * lost:.0f} % fewer (>= {100 * least:.0f})"
    return Finding(f"negative control: {what}", "-", ours, lost >= least)
