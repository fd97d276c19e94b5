"""Slide-to-wall grasp with RBO Hand 2 over the wall's inclination (9.1.2, Fig. 9.4)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pneuflex_sim.engines import check_engines
from pneuflex_sim.scene.scenes import load_scene
from softhand_trials.sweep import Jitter, SweepPlan, run_sweep
from softhand_trials.sweep.plan import SweptObject
from softhand_trials.sweep.report import wilson
from softhand_trials.sweep.success_map import finished
from softhand_trials.trials import TrialSettings
from thesis.chapter_8.map_evidence import (
    SMALL_EVIDENCE,
    Evidence,
    evidence_findings,
    judged_again,
    other_engines,
)
from thesis.chapter_8.object_map import RUBBER, check_names, rubber_row
from thesis.frame import Figure, Finding, Job, Report, Results, option

SIZE = (9.0, 3.8)
SCENE, STRATEGY, OBJECT = "wall", "rbo_hand_2_slide_to_wall", "thin_cylinder"
YAW = 0.0873  # 5 deg [rad]; the thesis tells of none
BEST, GOOD, OUTER, LOW = 60.0, (50.0, 70.0), (45.0, 80.0, 85.0, 90.0), 40.0  # inclinations [deg]
FLAT = 0.15  # greatest difference of the success between starts
NO_WALL = "no_wall"
SMALL = {"inclinations": (60.0,), "starts": (0.10,), "replicates": 1, "jobs": 0, **SMALL_EVIDENCE}


@dataclass(frozen=True)
class Parameters(Evidence):
    """Options of the experiment."""

    inclinations: tuple[float, ...] = option(
        (40.0, 45.0, 50.0, 60.0, 70.0, 80.0, 85.0, 90.0), "of the wall against the table [deg]"
    )
    starts: tuple[float, ...] = option(
        (0.06, 0.08, 0.10, 0.12, 0.14), "of the cylinder's axis before the corner [m]"
    )
    replicates: int = option(6, "jittered trials of an inclination and a start [-]")
    seed: int = option(1000, "of the jitter; the strategy was tuned at others [-]")
    checks: tuple[str, ...] = option(tuple(RUBBER), "other frictions of the rubber, by name [-]")

    def __post_init__(self) -> None:
        check_names(self.checks, RUBBER)


def plan(given: Parameters) -> SweepPlan:
    """Trials at each inclination, from each start; the hand's path is fixed, and the object is
    moved.
    """
    wall = load_scene(SCENE).wall
    if wall is None:
        raise ValueError(f"scene {SCENE}: expected a wall, got none")
    return SweepPlan(
        "wall_success",
        TrialSettings(
            STRATEGY, OBJECT, SCENE, step=given.step, early_end=True, engine=given.engines[0]
        ),
        (SweptObject(OBJECT),),
        tuple((round(wall.distance - start, 6), 0.0) for start in given.starts),
        moves="object",
        replicates=given.replicates,
        seed=given.seed,
        jitter=Jitter(yaw=YAW),
        vary={"wall_inclination": given.inclinations},
    )


def run(given: Parameters, job: Job) -> Results:
    """Successes over inclination and start, the same without a wall, and at the best inclination
    with other friction of the rubber.
    """
    check_engines(given.engines)
    main = plan(given)
    job.progress("trials at the wall", 0.0)
    records = finished(run_sweep(main, job.folder / "main", given.jobs))
    others = other_engines(main, given, job.folder)
    evidence = judged_again(main, {given.engines[0]: records, **others}, given, job.folder)
    job.progress("trials without a wall", 0.8)
    bare = replace(
        main,
        name=f"{main.name}-{NO_WALL}",
        settings=replace(main.settings, scene="table"),
        vary={},
        replicates=max(1, given.replicates // 3),
    )
    control = finished(run_sweep(bare, job.folder / NO_WALL, given.jobs))
    other = {}
    for name in given.checks:
        settings = replace(main.settings, wall_inclination=BEST, rubber_friction_scale=RUBBER[name])
        rubbed = replace(main, name=f"{main.name}-{name}", settings=settings, vary={})
        other[name] = finished(run_sweep(rubbed, job.folder / name, given.jobs))
    distance = main.cells[0][0] + given.starts[0]
    return {
        "trials": [_trial(record, distance) for record in records],
        "control": [_trial(record, distance) for record in control],
        **evidence,
        **{name: [_trial(record, distance) for record in found] for name, found in other.items()},
    }


def _trial(record: Mapping[str, Any], distance: float) -> dict[str, Any]:
    return {
        "inclination": record["settings"].get("wall_inclination"),
        "start": round(distance - record["cell"][0], 6),
        "gripped": int(record.get("outcome") == "gripped"),
        "cause": record.get("cause") or "",
        "phase": record.get("phase") or "",
    }


def share(trials: Iterable[Mapping[str, Any]]) -> tuple[int, int]:
    """Successes and trials."""
    gripped = [trial["gripped"] for trial in trials]
    return sum(gripped), len(gripped)


def by(trials: Iterable[Mapping[str, Any]], key: str) -> dict[float, list[Mapping[str, Any]]]:
    """Trials by one of their values, in order."""
    found: dict[float, list[Mapping[str, Any]]] = {}
    for trial in trials:
        found.setdefault(trial[key], []).append(trial)
    return dict(sorted(found.items()))


def report(results: Results, given: Parameters) -> Report:
    """A row per inclination, then the criteria."""
    trials = by(results["trials"], "inclination")
    counts = {angle: share(found) for angle, found in trials.items()}
    rates = {angle: held / count for angle, (held, count) in counts.items()}
    findings = [_row(angle, trials[angle]) for angle in counts]
    seen = {60.0: "reliable", 45.0: "works", 90.0: "works"}
    if BEST in rates:
        findings.append(_least(BEST, rates, 0.9, seen[BEST]))
    findings += [_least(a, rates, 0.5, "up to 15 deg off") for a in GOOD if a in rates]
    findings += [
        Finding(
            f"some success at {a:g} deg", seen.get(a, "-"), f"{rates[a]:.2f} (> 0)", rates[a] > 0
        )
        for a in OUTER
        if a in rates
    ]
    if {LOW, BEST} <= rates.keys():
        findings += [_apart(counts)]
    if len(rates) > 2:
        findings += [_one_peak(counts)]
    findings += [_flat(results["trials"]), _control(results["control"])]
    findings += evidence_findings(results, given.step)
    findings += [_rubber(name, results[name]) for name in given.checks if name in results]
    best = max(rates, key=lambda angle: rates[angle])
    return Report(findings, f"Most successes at {best:g} deg: {100 * rates[best]:.0f} %.")


def _row(angle: float, trials: list[Mapping[str, Any]]) -> Finding:
    held, count = share(trials)
    low, high = wilson(held, count)
    causes = [f"{t['cause']} in {t['phase']}" for t in trials if not t["gripped"]]
    most = max(set(causes), key=causes.count) if causes else "-"
    ours = f"{held} of {count} ({low:.2f} to {high:.2f}); most failures: {most}"
    return Finding(f"wall at {angle:g} deg", "-", ours)


def _least(angle: float, rates: Mapping[float, float], least: float, seen: str) -> Finding:
    ours = f"{rates[angle]:.2f} (>= {least:g})"
    return Finding(f"share of successes at {angle:g} deg", seen, ours, rates[angle] >= least)


def _apart(counts: Mapping[float, tuple[int, int]]) -> Finding:
    _, high = wilson(*counts[LOW])
    low, _ = wilson(*counts[BEST])
    ours = f"{LOW:g} deg at most {high:.2f}, {BEST:g} deg at least {low:.2f}"
    return Finding(f"fewer at {LOW:g} than at {BEST:g} deg", "works from 45 on", ours, high < low)


def _one_peak(counts: Mapping[float, tuple[int, int]]) -> Finding:
    """Whether the share of successes rises to one peak and falls from there, as far as the
    intervals show.
    """
    ends = [wilson(*found) for found in counts.values()]
    dips = [
        angle
        for k, angle in enumerate(counts)
        if any(lower[0] > ends[k][1] for lower in ends[:k])
        and any(lower[0] > ends[k][1] for lower in ends[k + 1 :])
    ]
    ours = (
        f"dips at {', '.join(f'{a:g}' for a in dips)} deg" if dips else "no dip between two peaks"
    )
    return Finding("one peak over the inclination", "-", ours, not dips)


def _flat(trials: list[Mapping[str, Any]]) -> Finding:
    rates = {start: np.divide(*share(found)) for start, found in by(trials, "start").items()}
    least, most = min(rates, key=lambda s: rates[s]), max(rates, key=lambda s: rates[s])
    low, high = (f"{rates[s]:.2f} from {1e3 * s:.0f} mm" for s in (least, most))
    ours = f"{low} to {high} (<= {FLAT:g} apart)"
    met = bool(rates[most] - rates[least] <= FLAT)
    return Finding("success over the start before the corner", "any place works", ours, met)


def _control(trials: list[Mapping[str, Any]]) -> Finding:
    held, count = share(trials)
    return Finding("negative control: no wall", "-", f"{held} of {count} (0)", held == 0)


def _rubber(name: str, trials: list[Mapping[str, Any]]) -> Finding:
    held, count = share(trials)
    what = f"{rubber_row(name)}, wall at {BEST:g} deg"
    return Finding(what, "-", f"{held} of {count}")


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Share of successes with its interval over inclination, and over start."""
    panels = figure.subplots(1, 2, sharey=True)
    for panel, key in zip(panels, ("inclination", "start"), strict=True):
        counts = {value: share(found) for value, found in by(results["trials"], key).items()}
        scale = 1e3 if key == "start" else 1.0
        places = [scale * value for value in counts]
        rates = np.array([held / count for held, count in counts.values()])
        ends = np.array([wilson(*found) for found in counts.values()]).T
        panel.errorbar(
            places, rates, np.abs(ends - rates), marker="o", capsize=3, color="tab:green"
        )
    panels[0].set(
        xlabel="inclination of the wall [deg]", ylabel="share of successes", ylim=(0, 1.05)
    )
    panels[1].set(xlabel="start before the corner [mm]")
