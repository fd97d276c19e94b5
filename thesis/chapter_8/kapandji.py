"""Kapandji test of RBO Hand 2's thumb (8.2.1, Figs 7.7, 8.7, 8.8).

Pressures are found by TPE, where the thesis chose them by hand; places and judge are those of
`thesis.chapter_8.dexterity.kapandji`. Of the best postures of each place, the winner is the one
with the lowest worst cost in four tries with varied pressures. It is judged again with other draws,
and the place counts as reached when all of these repeats touch it.

The cost, in which a contact elsewhere is no worse than none, and the sampler were chosen on place 8
alone, before all other searches (seed 1, 5 segments): after 60 evaluations the cost was 21.8 with
TPE and 25.1 with CMA-ES, after 130 18.1 and 18.0. Searches run at steps of 2 ms: at 5 ms, fingers
that press on each other trembled, and touches found there were lost at 2 ms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from pneuflex_sim.pictures.render import Camera, HandState, Renderer
from softhand_model.hand.hand import load_hand
from softhand_trials.search import SearchProblem, Variable, search_with, try_again
from softhand_trials.sweep.run import Workers, start_workers
from thesis.chapter_8.dexterity.kapandji import OTHER_RADII, RADIUS, TARGETS, Target
from thesis.chapter_8.dexterity.posture import (
    FOUR,
    HAND,
    PALM,
    RIGID,
    SEVEN,
    PosedHand,
    hand_variant,
    touch_place,
)
from thesis.frame import Array, Figure, Finding, Job, Report, Results, option

SIZE = (12.0, 9.0)
NO_INDEX = "no_index"
CASES = {  # hand, channels that stay empty, places
    FOUR: (FOUR, (), tuple(range(1, 9))),
    SEVEN: (SEVEN, (), tuple(range(1, 9))),
    RIGID: (RIGID, (), tuple(range(1, 9))),
    NO_INDEX: (FOUR, ("b",), (1, 2, 3)),
}
SAMPLER = "tpe"
OBJECTIVE = "thesis.chapter_8.dexterity.posture:touch_place"
ENOUGH, MOST_RIGID = 6, 3  # places that are to be reached, and at most with a palm that is rigid
VIEW = {"target": (0.0, 0.0, 0.12), "distance": 4.0, "view_angle": 3.2, "yaw": 90.0, "pitch": 0.0}
UPRIGHT = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
PIXELS = 420
SMALL = {
    "places": (4,),
    "cases": (FOUR,),
    "evaluations": 8,
    "tried": (1,),
    "segments": 5,
    "step": 0.005,
    "fine_step": 0.0025,
    "points": 2,
    "jobs": 0,
}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    places: tuple[int, ...] = option(tuple(range(1, 9)), "by their numbers [-]")
    cases: tuple[str, ...] = option(tuple(CASES), "hands and channels that are searched [-]")
    evaluations: int = option(360, "of a search, its budget [-]")
    tried: tuple[int, ...] = option(
        (24, 8, 4, 4), "candidates that each draw of other pressures is tried on [-]"
    )
    generation: int = option(8, "evaluations a generation [-]")
    repeats: int = option(3, "judged postures of each winner [-]")
    step: float = option(0.002, "of the physics [s]")
    fine_step: float = option(0.001, "of another verdict on the first case's winners [s]")
    segments: int = option(8, "an actuator [-]")
    points: int = option(6, "pressures a channel of the thumb base's workspace [-]")
    seed: int = option(6000, "of searches and repeats [-]")
    jobs: int = option(2, "processes [-]")


def problem(given: Parameters, case: str, place: int) -> SearchProblem:
    """The search for one place."""
    variant, empty, _ = CASES[case]
    hand = hand_variant(variant)
    return SearchProblem(
        f"{case}_{place}",
        OBJECTIVE,
        tuple(
            Variable(name, 0.0, float(limit))
            for name, limit in zip(hand.channels, hand.max_pressures(), strict=True)
            if name not in empty
        ),
        given.evaluations,
        given.generation,
        SAMPLER,
        seed=given.seed + place,
        settings={
            "place": place,
            "hand": variant,
            "step": given.step,
            "segments": given.segments,
        },
        allow_any=True,
    )


# ---------------------------------------------------------------- run
def run(given: Parameters, job: Job) -> Results:
    """Searches of all cases and places, repeats of the winners, the workspace of the thumb's base,
    and the postures of the first case.
    """
    wanted = [(c, p) for c in given.cases for p in CASES[c][2] if p in given.places]
    found: dict[str, dict[str, Any]] = {case: {} for case in given.cases}
    with start_workers(given.jobs) as workers:
        for number, (case, place) in enumerate(wanted):
            job.progress(f"{case}, place {place}", number / (len(wanted) + 1))
            found[case][str(place)] = _searched(workers, given, case, place, job.folder)
    job.progress("postures and workspace", len(wanted) / (len(wanted) + 1))
    fine = finely(found[given.cases[0]], given)
    return {"cases": found, "fine": fine, **postures(found, given), **workspace(given)}


def _searched(
    workers: Workers, given: Parameters, case: str, place: int, folder: Path
) -> dict[str, Any]:
    """The winner of a search and its repeats."""
    search, folder = problem(given, case, place), folder / case / str(place)
    result = search_with(workers, search, folder)
    # not those of the repeats
    draws = {str(k): (search.seed, 100 + k) for k in range(len(given.tried))}
    tried = try_again(workers, search, result, draws, given.tried, folder / "tried")
    best = tried[0].record
    return {
        "values": dict(best["values"]),
        "found": {key: best[key] for key in ("cost", "touched", "reason", "gap")},
        "worst": tried[0].worst,
        "failed": result.failed,
        "repeats": repeats(search, best["values"], given),
    }


def finely(found: Mapping[str, Any], given: Parameters) -> dict[str, Any]:
    """Winners of the first case by place, each repeated with the finer step. With a coarse step,
    fingers that press on each other may tremble, and the joints do not come to rest.
    """
    again = {}
    for place, one in found.items():
        search = problem(given, given.cases[0], int(place)).with_settings(step=given.fine_step)
        again[place] = {**one, "repeats": repeats(search, one["values"], given)}
    return again


def repeats(search: SearchProblem, values: Mapping[str, float], given: Parameters) -> list[Any]:
    """Verdicts on a winner with pressures that differ, each by its own draw."""
    draws = [[search.seed, 1 + number] for number in range(given.repeats)]
    return [touch_place(values, {**search.settings, "draw": draw}) for draw in draws]


def postures(found: Mapping[str, Any], given: Parameters) -> Results:
    """Joint orientations (places, n, 4) of the winners of the first case, and the points of their
    places (places, 3) [m] in the wrist frame.
    """
    case = next(iter(found))
    hand = PosedHand(CASES[case][0], given.step, given.segments)
    joints, marks = [], []
    for place, one in found[case].items():
        target = TARGETS[int(place) - 1]
        hand.take(np.array([one["values"].get(name, 0.0) for name in hand.channels]))
        q = hand.joints()
        joints.append(q)
        marks.append(hand.scene.skin.point(target.finger, target.share, target.side, q))
    hand.close()
    return {"joints": np.array(joints), "marks": np.array(marks)}


def workspace(given: Parameters) -> Results:
    """Place (k, 3) [m] of the thumb's base and its twist [rad] about the palm's end, relative to
    rest: at pressures of c and d (k, 2) [Pa] that are equal, and at different ones (Fig. 7.7).
    """
    hand = PosedHand(FOUR, given.step, given.segments)
    c, d = (hand.limits[hand.channels.index(name)] for name in "cd")
    equal = np.repeat(np.linspace(0.0, min(c, d), given.points)[:, None], 2, axis=1)
    axes = np.linspace(0.0, c, given.points), np.linspace(0.0, d, given.points)
    differing = np.array(np.meshgrid(*axes)).reshape(2, -1).T
    found = {"equal": equal, "differing": differing}
    results: Results = {}
    for name, pressures in found.items():
        posed = [_thumb_base(hand, pair) for pair in pressures]
        results[f"{name}_pressures"] = pressures
        results[f"{name}_places"] = np.array([position for position, _ in posed])
        results[f"{name}_twists"] = np.array([twist for _, twist in posed])
    hand.close()
    return results


def _thumb_base(hand: PosedHand, pair: Array) -> tuple[Array, float]:
    """Place [m] of the palm's end in the wrist frame, and by how much [rad] the palm is twisted:
    the turns of its joints about its own length, in sum.
    """
    by_name = dict(zip("cd", pair, strict=True))
    hand.take(np.array([by_name.get(name, 0.0) for name in hand.channels]))
    shape = hand.scene.simulation.shape
    q, joints = hand.joints(), shape.layout.chain_joints[PALM]
    position, frame, _ = shape.frames(q)
    bent = Rotation.from_quat(shape.layout.rest[joints]).inv() * Rotation.from_quat(q[joints])
    last = joints.stop - 1
    place = position[last] + frame[last] @ shape.layout.chain_tips[PALM]
    return place, float(bent.as_rotvec()[:, 2].sum())


# ---------------------------------------------------------------- report
def reached(one: Mapping[str, Any], radius: float = RADIUS) -> bool:
    """Whether all repeats of a place's winner touch it within a radius [m]."""
    return all(repeat["at_radius"][f"{1e3 * radius:g}"] for repeat in one["repeats"])


def report(results: Results, given: Parameters) -> Report:
    """A row per place, then the criteria."""
    cases = results["cases"]
    findings = [_row(int(place), one) for place, one in cases.get(FOUR, {}).items()]
    counts = {name: sum(map(reached, found.values())) for name, found in cases.items()}
    if FOUR in cases:
        findings += _counted(cases[FOUR])
        findings += [_first(cases[FOUR])] if "1" in cases[FOUR] else []
    fine = results["fine"]
    ours = f"{sum(map(reached, fine.values()))} of {len(fine)}: {_numbers(fine)}"
    findings.append(Finding(f"winners at steps of {1e3 * given.fine_step:g} ms", "-", ours))
    if SEVEN in cases:
        ours = f"{counts[SEVEN]} of {len(cases[SEVEN])}: {_numbers(cases[SEVEN])}"
        findings.append(Finding("with seven channels", "-", ours))
    if RIGID in cases:
        ours = f"{counts[RIGID]} of {len(cases[RIGID])}: {_numbers(cases[RIGID])} (<= {MOST_RIGID})"
        findings.append(
            Finding("negative control: palm rigid", "-", ours, counts[RIGID] <= MOST_RIGID)
        )
    if NO_INDEX in cases:
        ours = f"{counts[NO_INDEX]} of {len(cases[NO_INDEX])}: {_numbers(cases[NO_INDEX])} (0)"
        what = "negative control: index empty, places 1 to 3"
        findings.append(Finding(what, "-", ours, counts[NO_INDEX] == 0))
    findings += _twists(results)
    first = next(iter(counts))
    return Report(findings, f"The thumb reaches {counts[first]} of {len(cases[first])} places.")


def _numbers(found: Mapping[str, Any], radius: float = RADIUS) -> str:
    return ", ".join(place for place, one in found.items() if reached(one, radius)) or "none"


def _row(place: int, one: Mapping[str, Any]) -> Finding:
    target = TARGETS[place - 1]
    touched = sum(repeat["touched"] for repeat in one["repeats"])
    pressures = " / ".join(f"{1e-3 * value:.0f}" for value in one["values"].values())
    why = sorted({repeat["reason"] for repeat in one["repeats"]} - {""})
    others = sorted({name for repeat in one["repeats"] for name in repeat["others"]})
    parts = [
        f"{touched} of {len(one['repeats'])}",
        f"{_remaining(one):.1f} mm away",
        f"{pressures} kPa",
        *(["also touches " + ", ".join(others)] if others else []),
        *why,
    ]
    seen = "not reached" if place == 1 else "reached"
    return Finding(f"place {place}: {place_name(target)}", seen, "; ".join(parts))


def place_name(target: Target) -> str:
    """A place in words."""
    where = {"+y": "radial side", "pad": "pad", "tip": "tip"}[target.side]
    at = "" if target.side == "tip" else f" at {100 * target.share:.0f} %"
    return f"{target.finger}, {where}{at}"


def _remaining(one: Mapping[str, Any]) -> float:
    """Mean distance [mm] of the repeats from the place: along the skin, or through the air without
    contact.
    """
    far = [r["gap"] if r["distance"] is None else r["distance"] for r in one["repeats"]]
    return float(1e3 * np.mean(far))


def _effort(one: Mapping[str, Any]) -> float:
    """Mean of the pressures as shares of their limits [-] (ours)."""
    hand = load_hand(HAND)
    limits = dict(zip(hand.channels, hand.max_pressures(), strict=True))
    return float(np.mean([value / limits[name] for name, value in one["values"].items()]))


def _counted(found: Mapping[str, Any]) -> list[Finding]:
    whole = len(found) == len(TARGETS)
    count = sum(map(reached, found.values()))
    ours = f"{count} of {len(found)}: {_numbers(found)} (>= {ENOUGH})"
    met = count >= ENOUGH if whole else None
    findings = [Finding(f"places reached within {1e3 * RADIUS:g} mm", "7 of 8", ours, met)]
    for radius in OTHER_RADII:
        number = sum(reached(one, radius) for one in found.values())
        ours = f"{number} of {len(found)}: {_numbers(found, radius)}"
        findings.append(Finding(f"within {1e3 * radius:g} mm", "-", ours))
    return findings


def _first(found: Mapping[str, Any]) -> Finding:
    """Whether place 1 is the hardest: not reached, or with the largest distance or effort."""
    farthest = max(found, key=lambda place: _remaining(found[place]))
    hardest = max(found, key=lambda place: _effort(found[place]))
    failed = not reached(found["1"])
    easy = "" if failed or "1" in (farthest, hardest) else "; easier than with the real hand"
    ours = (
        f"{'not ' if failed else ''}reached; farthest is {farthest}, most effort takes {hardest}"
        f"{easy}"
    )
    return Finding("place 1 is the hardest", "the only one not reached", ours, failed or not easy)


def _twists(results: Results) -> list[Finding]:
    rows = []
    for name, words in (("equal", "equal"), ("differing", "different")):
        twists, places = np.degrees(results[f"{name}_twists"]), results[f"{name}_places"]
        box = 1e3 * np.ptp(places, axis=0)
        ours = (
            f"{twists.min():.0f} to {twists.max():.0f} deg; within "
            f"{box[0]:.0f} x {box[1]:.0f} x {box[2]:.0f} mm"
        )
        what = f"twist and place of the thumb's base, c and d {words}"
        rows.append(Finding(what, "a picture", ours, None, float(np.ptp(twists)), "deg"))
    return rows


# ---------------------------------------------------------------- figure
def draw(figure: Figure, results: Results, report: Report) -> None:
    """The postures from the palm's side, each with its place; the workspace of the thumb's base."""
    found = next(iter(results["cases"].values()))
    top, below = figure.subfigures(2, 1, height_ratios=(2.6, 1.0))
    columns = min(4, len(found))
    rows = -(-len(found) // columns)
    panels = np.atleast_1d(top.subplots(rows, columns, squeeze=False)).ravel()
    for panel in panels[len(found) :]:
        panel.set_axis_off()
    pictures = photographs(results["joints"], next(iter(results["cases"])))
    for panel, (place, one), picture, mark in zip(
        panels, found.items(), pictures, results["marks"], strict=False
    ):
        _draw_posture(panel, int(place), one, picture, mark)
    _draw_workspace(below.subplots(1, 2), results)


def photographs(joints: Array, case: str) -> list[Any]:
    """Pictures of postures from the palm's side."""
    hand = hand_variant(CASES[case][0])
    count = sum(len(chain.actuators) > 0 for chain in hand.chains)
    struts = sum(chain.strut is not None for chain in hand.chains)
    segments = (joints.shape[1] - struts) // count
    renderer = Renderer(hand, None, "stand", segments)
    camera = Camera(**VIEW, light=(1.6, -0.6, 1.2))
    return [renderer.frame(HandState(q, *UPRIGHT), (PIXELS, PIXELS), camera) for q in joints]


def _draw_posture(
    panel: Any, place: int, one: Mapping[str, Any], picture: Any, mark: Array
) -> None:
    half = VIEW["distance"] * np.tan(np.radians(0.5 * VIEW["view_angle"]))
    y, z = VIEW["target"][1:]
    panel.imshow(picture, extent=[y - half, y + half, z - half, z + half])
    panel.plot(mark[1], mark[2], "o", markersize=7, fillstyle="none", color="tab:red")
    touched = sum(repeat["touched"] for repeat in one["repeats"])
    words = f"{place}: {place_name(TARGETS[place - 1])}\n{touched} of {len(one['repeats'])}"
    panel.set_title(f"{words}, {_remaining(one):.1f} mm", fontsize=9)
    panel.set_axis_off()


def _draw_workspace(panels: Sequence[Any], results: Results) -> None:
    for name, style in (("differing", "."), ("equal", "o")):
        places, twists = 1e3 * results[f"{name}_places"], np.degrees(results[f"{name}_twists"])
        color, label = ("0.6", "c and d differ") if name == "differing" else ("tab:orange", "equal")
        line = "none" if name == "differing" else "-"
        panels[0].plot(
            places[:, 1], places[:, 0], marker=style, linestyle=line, color=color, label=label
        )
        total = 1e-3 * results[f"{name}_pressures"].mean(axis=1)
        panels[1].plot(total, twists, marker=style, linestyle=line, color=color, label=label)
    panels[0].set(xlabel="y, to the thumb's side [mm]", ylabel="x, out of the palm [mm]")
    panels[0].set_title("thumb's base (Fig. 7.7)", fontsize=9)
    panels[1].set(xlabel="mean pressure of c and d [kPa]", ylabel="twist [deg]")
    panels[1].legend(fontsize=8)
