"""Edge grasp with RBO Hand 1 over size and distance of a cylinder (9.1.1, Fig. 9.2)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from pneuflex_sim.engines import check_engines
from pneuflex_sim.scene.scenes import Table, load_scene
from softhand_common.documents.output_file import write_file
from softhand_trials.sweep import SweepPlan, run_sweep
from softhand_trials.sweep.plan import SweptObject
from softhand_trials.sweep.report import wilson
from softhand_trials.sweep.success_map import Cells, finished, largest_share, overlap
from softhand_trials.trials import TrialSettings
from thesis.chapter_8.map_evidence import (
    MAIN,
    SMALL_EVIDENCE,
    Evidence,
    differing_cells,
    evidence_findings,
    judged_again,
    other_engines,
)
from thesis.chapter_8.object_map import RUBBER, rubber_row
from thesis.frame import Figure, Finding, Job, Report, Results, option

SIZE = (13.0, 5.5)
ABOVE = {"textcoords": "offset points", "ha": "center"}  # of words beside a cell
STRATEGY, SCENE = "rbo_hand_1_edge", "edge"
LENGTH, DENSITY = 0.150, 300.0  # of the cylinders [m], [kg/m3]; the thesis gives none
NO_EDGE, TOO_HIGH, PAST_BANDS = "no_edge", "too_high", "past_bands"
ROLLING = {"rolling_0.1": 1.0e-4, "rolling_0.4": 4.0e-4}  # [m], where the scene has 2e-4
# heights that succeed are a band of 50 mm about the tuned one: 20 mm more stay within it
CONTROLS = {
    NO_EDGE: {"scene": "table"},
    TOO_HIGH: {"displacement": (0.0, 0.0, 0.020)},
    PAST_BANDS: {"displacement": (0.0, 0.0, 0.060)},
}
FRICTIONS = {name: {"rubber_friction_scale": factor} for name, factor in RUBBER.items()}
OTHERS: dict[str, dict[str, Any]] = {**CONTROLS, **FRICTIONS}
ENOUGH = 2.0 / 3.0  # share of the trials of a cell
CHECKED = 1  # first replicates of a cell that a check runs; it is compared with the same of the map
SMALL = {
    "diameters": (0.030,),
    "distances": (0.02, 0.04),
    "replicates": 1,
    "checks": (TOO_HIGH,),
    **SMALL_EVIDENCE,
}


@dataclass(frozen=True)
class Parameters(Evidence):
    """Options of the experiment."""

    diameters: tuple[float, ...] = option(
        (0.010, 0.015, 0.020, 0.030, 0.040, 0.050, 0.065, 0.080), "of the cylinders [m]"
    )
    distances: tuple[float, ...] = option(
        tuple(round(0.02 * k, 3) for k in range(7)), "from the edge to the nearest surface [m]"
    )
    replicates: int = option(3, "jittered trials of a size and a distance [-]")
    checks: tuple[str, ...] = option(
        (*ROLLING, *CONTROLS, *FRICTIONS), "sweeps beside the map, by name [-]"
    )


def plan(given: Parameters, folder: Path) -> SweepPlan:
    """Trials of each size at each distance; the files of the cylinders are written to the
    folder.
    """
    edge = table_with_edge().edge or 0.0
    objects = tuple(
        SweptObject(str(write_cylinder(folder, diameter)), (edge + diameter / 2, 0.0))
        for diameter in given.diameters
    )
    settings = TrialSettings(
        STRATEGY,
        scene=SCENE,
        model="rbo_hand_1",
        segments=10,
        step=given.step,
        early_end=True,
        engine=given.engines[0],
    )
    cells = tuple((distance, 0.0) for distance in given.distances)
    return SweepPlan(
        "edge_map",
        settings,
        objects,
        cells,
        moves="object",
        replicates=given.replicates,
        seed=given.seed,
    )


def table_with_edge() -> Table:
    """The table of the scene."""
    table = load_scene(SCENE).table
    if table is None or table.edge is None:
        raise ValueError(f"scene {SCENE}: expected a table with an edge")
    return table


def write_cylinder(folder: Path, diameter: float) -> Path:
    """File of a cylinder that lies along the edge."""
    mass = DENSITY * math.pi / 4 * diameter**2 * LENGTH
    path = folder / "objects" / f"cylinder_{1e3 * diameter:g}.yaml"
    write_file(
        path,
        f"format: pneuflex-object/1\nshape: cylinder\ndiameter: {diameter}\nlength: {LENGTH}\n"
        f"mass: {mass:.6f}\nmaterial: cardboard\nrpy: [{math.pi / 2}, 0, 0]\n",
    )
    return path


def write_scene(folder: Path, rolling_resistance: float) -> Path:
    """File of the scene `edge` with another rolling resistance [m]."""
    scene, table = load_scene(SCENE), table_with_edge()
    path = folder / "objects" / f"edge_{1e3 * rolling_resistance:g}.yaml"
    write_file(
        path,
        f"format: pneuflex-scene/1\ntable: {{material: {table.material}, "
        f"edge: {table.edge}, rolling_resistance: {rolling_resistance}}}\nobject: true\n"
        f"wrist: compliant\nwrist_position: {list(scene.wrist_position)}\n"
        f"wrist_rpy: {list(scene.wrist_rpy)}\n",
    )
    return path


def run(given: Parameters, job: Job) -> Results:
    """The map, the same at other resistances and frictions, and the negative controls."""
    check_engines(given.engines)
    main = plan(given, job.folder)
    changes: dict[str, dict[str, Any]] = {MAIN: {}}
    for name in given.checks:
        rolling = ROLLING.get(name)
        scene = {"scene": str(write_scene(job.folder, rolling))} if rolling else OTHERS[name]
        changes[name] = dict(scene)
    sweeps, evidence = {}, {}
    for number, (name, change) in enumerate(changes.items()):
        job.progress(name, number / len(changes))
        own = "edge_map" if name == MAIN else f"edge_map-{name}"
        swept = replace(main, name=own, settings=replace(main.settings, **change))
        if name != MAIN:
            swept = replace(swept, replicates=min(main.replicates, CHECKED))
        records = finished(run_sweep(swept, job.folder / name, given.jobs))
        sweeps[name] = [_trial(record) for record in records]
        if name == MAIN:
            others = other_engines(swept, given, job.folder)
            sweeps |= {f"{MAIN}_{engine}": list(map(_trial, others[engine])) for engine in others}
            evidence = judged_again(swept, {given.engines[0]: records, **others}, given, job.folder)
    return {"engine": given.engines[0], "sweeps": sweeps, **evidence}


def _trial(record: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "diameter": 1e-3 * float(Path(record["object"]).stem.removeprefix("cylinder_")),
        "distance": record["cell"][0],
        "replicate": record["replicate"],
        "gripped": int(record.get("outcome") == "gripped"),
        "cause": record.get("cause") or "",
    }


def shares(trials: Iterable[Mapping[str, Any]]) -> tuple[list[float], list[float], np.ndarray]:
    """Diameters and distances in order [m], and shares of successes (diameters, distances), NaN
    where there was no trial.
    """
    trials = list(trials)
    sizes = sorted({trial["diameter"] for trial in trials})
    places = sorted({trial["distance"] for trial in trials})
    held, count = np.zeros((2, len(sizes), len(places)))
    for trial in trials:
        cell = sizes.index(trial["diameter"]), places.index(trial["distance"])
        held[cell] += trial["gripped"]
        count[cell] += 1
    return sizes, places, np.divide(held, count, out=np.full(count.shape, np.nan), where=count > 0)


def region_of(trials: Iterable[Mapping[str, Any]]) -> Cells:
    """Where at least two of three trials succeed (diameters, distances)."""
    return np.asarray(shares(trials)[2] >= ENOUGH - 1e-9)


def report(results: Results, given: Parameters) -> Report:
    """A row per size, then the criteria."""
    trials = results["sweeps"][MAIN]
    sizes, places, _ = shares(trials)
    region = region_of(trials)
    findings = [_row(size, trials) for size in sizes]
    held = int(region.any(axis=1).sum())
    share = largest_share(region)
    gaps = {size: _gaps(row) for size, row in zip(sizes, region, strict=True)}
    widest = max(gaps, key=lambda size: gaps[size])
    findings += [
        Finding(
            "sizes with a success in two of three trials somewhere",
            "a large range of sizes",
            f"{held} of {len(sizes)} (>= 5)",
            held >= 5,
        ),
        Finding(
            "largest component, share of the successes",
            "contiguous",
            "no success" if math.isnan(share) else f"{share:.2f} (>= 0.85)",
            bool(share >= 0.85),
        ),
        Finding(
            "gaps between the distances of a size",
            "contiguous",
            f"{gaps[widest]} cells at {1e3 * widest:.0f} mm (<= 1)",
            gaps[widest] <= 1,
        ),
        _farthest(sizes, places, region),
        *evidence_findings(results, given.step),
        *(_check(name, results) for name in given.checks),
    ]
    return Report(findings, f"Cylinders of {held} of {len(sizes)} diameters are lifted.")


def _row(size: float, trials: list[Mapping[str, Any]]) -> Finding:
    own = [trial for trial in trials if trial["diameter"] == size]
    _, places, share = shares(own)
    count = sum(trial["gripped"] for trial in own)
    low, high = wilson(count, len(own))
    good = [f"{1e3 * place:.0f}" for place, s in zip(places, share[0], strict=True) if s >= ENOUGH]
    causes = Counter(trial["cause"] for trial in own if not trial["gripped"]).most_common(2)
    failures = ", ".join(f"{cause} {number}" for cause, number in causes)
    where = f"at {' '.join(good)} mm" if good else "nowhere"
    ours = f"{count} of {len(own)} ({low:.2f} to {high:.2f}), {where}; {failures}"
    return Finding(f"diameter {1e3 * size:.0f} mm", "a picture", ours)


def _gaps(row: Cells) -> int:
    """Cells without success between the first and the last successful one."""
    found = np.flatnonzero(row)
    return int(found[-1] - found[0] + 1 - len(found)) if len(found) else 0


def _farthest(sizes: list[float], places: list[float], region: Cells) -> Finding:
    """Whether the largest distance with success does not grow with the diameter."""
    held = [k for k in range(len(sizes)) if region[k].any()]
    ends = [places[int(np.flatnonzero(region[k])[-1])] for k in held]
    what = "largest distance over the diameter"
    if len(held) < 3:
        return Finding(what, "small ones work best", "fewer than three sizes", False)
    if np.ptp(ends) == 0:
        return Finding(what, "small ones work best", "the same for all", True)
    found = stats.spearmanr([sizes[k] for k in held], ends)
    ours = f"Spearman {found.statistic:.2f}, p = {found.pvalue:.2g} (<= 0)"
    return Finding(what, "small ones work best", ours, bool(found.statistic <= 0))


def _check(name: str, results: Results) -> Finding:
    trials, checked = (results["sweeps"][key] for key in (MAIN, name))
    same = {trial["replicate"] for trial in checked}
    region = region_of(trial for trial in trials if trial["replicate"] in same)
    other = region_of(checked)
    if name in ROLLING:
        shared = overlap(region, other)
        what = f"overlap with the map at a rolling resistance of {1e3 * ROLLING[name]:g} mm"
        return Finding(what, "-", f"{shared:.2f} (>= 0.7)", shared >= 0.7)
    if name in RUBBER:
        cells = f"{int(region.sum())} -> {int(other.sum())} cells"
        return Finding(rubber_row(name), "-", cells)
    too_high = {TOO_HIGH: "hand 20 mm too high", PAST_BANDS: "hand 60 mm too high"}
    what = {NO_EDGE: "no edge", **too_high}[name]
    before, after = int(region.sum()), int(other.sum())
    ours = f"{before} -> {after} cells (half or fewer)"
    return Finding(f"negative control: {what}", "-", ours, 2 * after <= before and before > 0)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Share of successes over diameter and distance in each engine, crosses where their verdicts
    differ, and by what most trials failed.
    """
    sweeps = {name: trials for name, trials in results["sweeps"].items() if name.startswith(MAIN)}
    names = [results["engine"], *(name.removeprefix(f"{MAIN}_") for name in list(sweeps)[1:])]
    panels = figure.subplots(1, len(sweeps), sharey=True, squeeze=False)[0]
    apart = [
        (1e3 * distance, float(group.removeprefix("cylinder_")))
        for group, cells in differing_cells(results).items()
        for distance, _ in cells
    ]
    for panel, name, trials in zip(panels, names, sweeps.values(), strict=True):
        sizes, places, share = shares(trials)
        x, y = np.meshgrid(1e3 * np.array(places), 1e3 * np.array(sizes))
        shown = panel.scatter(x, y, c=share, s=70, cmap="Greens", vmin=0, vmax=1, edgecolors="0.4")
        panel.margins(x=0.12)  # for the words below the circles
        for cell, cause in _causes(trials).items():
            panel.annotate(cause, (1e3 * cell[1], 1e3 * cell[0]), (0, -11), fontsize=5, **ABOVE)
        if apart:
            panel.plot(*np.array(apart).T, "x", color="tab:red", markersize=5)
        panel.set(xlabel="distance from the edge [mm]", title=name)
    panels[0].set_ylabel("diameter [mm]")
    figure.colorbar(shown, ax=panels, label="share of successes (cross: engines differ)")


def _causes(trials: Iterable[Mapping[str, Any]]) -> dict[tuple[float, float], str]:
    """The commonest cause of the failures of a cell (diameter, distance) [m]."""
    found: dict[tuple[float, float], Counter[str]] = {}
    for trial in trials:
        if not trial["gripped"]:
            cell = trial["diameter"], trial["distance"]
            found.setdefault(cell, Counter())[trial["cause"]] += 1
    return {cell: causes.most_common(1)[0][0] for cell, causes in found.items()}
