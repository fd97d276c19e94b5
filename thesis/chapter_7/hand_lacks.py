"""What the model of RBO Hand 2 lacks, by what the thesis says of the real hand (7.3, 8.2.1).

Three facts are compared with the model: the palm at equal pressures (7.3), the places that the
thumb reaches (8.2.1), and the force at which a cylinder slides (Fig. 7.10). `facts.yaml` has each
with its source, how it was read, and its uncertainty, and those that no comparison can use.

Criteria, fixed before the runs whose results are reported; the base model's distances and forces
had been seen before. A cause is named only where the base model contradicts a fact beyond its
uncertainty and one effect in its usual range, and no other, ends that: for the palm by the lab's
verdict, for the places within 8 mm, for the forces by squares of z-values up to REFUTED. An effect
is bounded by a fact that it contradicts at a value of its usual range.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import model_lab as lab
from model_lab.comparison.compare import errors_of
from model_lab.measurements.load import load_measurements
from model_lab.rules import RULES
from softhand_common.documents.output_file import write_file
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.model_file import load_model
from thesis.chapter_3_and_5.disturbance import DIRECTIONS, JUDGED
from thesis.chapter_7.candidates import IN_GRASP, IN_POSE, Candidate
from thesis.chapter_7.kept import kept
from thesis.chapter_7.palm_cone import MARKERS, cone, own_bend, write_set
from thesis.chapter_7.sliding import MEASURED, UNCERTAINTY, forces, misfit, z_values
from thesis.chapter_7.static_reach import ROUNDS, StaticHand, nearest
from thesis.chapter_8.dexterity.kapandji import RADIUS, TARGETS, THUMB, Target
from thesis.chapter_8.dexterity.posture import (
    FOUR,
    HAND,
    RIGID,
    SEVEN,
    hand_variant,
)
from thesis.frame import Array, Figure, Finding, Job, Report, Results, option

SIZE = (10.0, 6.5)
FACTS = Path(__file__).with_name("facts.yaml")
REACHED = tuple(target.number != 1 for target in TARGETS)  # in the thesis
MOST_PALM_PRESSURE = 60e3  # [Pa]
PALM_NOISE = 0.0005  # [m] of a coordinate, as of motion capture
MODEL = """format: softhand-model/1
base: pneuflex
effects:
  - {{name: gravity, parameters: {{mass_scale: {weight}}}}}
"""
CONTROLS = tuple(
    Candidate("mount_tilt", "yaw", {"chain": chain}) for chain in ("palm", "index")
)  # the first must show in poses of the thumb's base, the second cannot
FORCE_PRESSURES = (45e3, JUDGED, 70e3)  # [Pa]
OTHER_SEGMENTS = 7  # which tell how uncertain a predicted force is
REFUTED = (
    5.99  # [-] sum of squared z-values of 3 forces with a free pressure, beyond 95 % of chance
)
SHIFT = 0.05  # of a finger's length, by which our places may be off
BENDS = (180.0, 225.0, 270.0, 315.0, 360.0)  # [deg] of palm and thumb; above, they coil up
JUDGED_BEND = np.radians(270.0)  # chosen after the base model's coils were seen, before effects
COILED = (6, 7, 8)  # places that the base model reaches by coils alone
Reach = Callable[..., tuple[float, Array]]  # `nearest` with its numbers of tries
SMALL = {
    "poses": 5,
    "places": (1, 6),
    "pose_effects": 1,
    "grasp_effects": 0,
    "first": 64,
    "rounds": 1,
    "rate": 16.0,
    "bent_effects": 1,
}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    poses: int = option(9, "of the palm with equal pressures [-]")
    places: tuple[int, ...] = option(tuple(range(1, 9)), "of Kapandji, by their numbers [-]")
    pose_effects: int = option(len(IN_POSE), "effects that are tried on the places [-]")
    grasp_effects: int = option(len(IN_GRASP), "effects that are tried on the forces [-]")
    first: int = option(2048, "pressures tried all over their range, for each place [-]")
    rounds: int = option(ROUNDS, "in which others near the best ones are tried [-]")
    rate: float = option(4.0, "of the growing force on the cylinder [N/s]")
    bent_effects: int = option(len(IN_POSE), "effects that are tried without coils [-]")


# ---------------------------------------------------------------- run
def run(given: Parameters, job: Job) -> Results:
    """The three comparisons, one after the other."""
    return {
        "palm": palm(given, job),
        "places": places(given, job),
        "forces": sliding_forces(given, job),
    }


def palm(given: Parameters, job: Job) -> Results:
    """What the lab says of the palm as a cone, and of the set without pressures; and which effects
    would show in poses of the thumb's base, at equal pressures and at different ones.
    """
    job.progress("palm", 0.0)
    hand, folder = load_hand(HAND), job.folder / "palm"
    equal = np.linspace(0.0, MOST_PALM_PRESSURE, given.poses)
    both = np.repeat(equal[:, None], len(hand.channels), axis=1)
    cones = cone(hand, own_bend(hand, equal))
    title = "the palm as a segment of a cone at equal pressures, after section 7.3"
    write_set(folder, hand, both, cones, PALM_NOISE, title)
    weightless = folder / "weightless.yaml"
    write_file(weightless, MODEL.format(weight=0.0))
    found: Results = kept(folder / "verdict.json", partial(diagnosed, folder, weightless))
    picture = job.folder / "palm_without_pressures"
    write_set(picture, hand, both, cones, PALM_NOISE, title, with_pressures=False)
    try:
        lab.compare(picture, weightless)
    except ValueError as refusal:
        found["refusal"] = str(refusal).replace(str(job.folder), "OUT")
    at = np.array(list(product(np.linspace(0.0, 60e3, 4), np.linspace(0.0, 90e3, 4))))  # c and d
    apart = np.hstack([np.zeros((len(at), 2)), at])
    for name, pressures in (("equal", both), ("different", apart)):
        job.progress(f"poses at {name} pressures", 0.02)
        found[name] = shown(given, hand, pressures, job.folder / name)
    return found


def diagnosed(folder: Path, model: Path) -> Results:
    """Verdict of the lab, what it names, error and floor [m]."""
    diagnosis = lab.diagnose(folder, model)
    said = diagnosis.json()
    return {
        "verdict": diagnosis.verdict,
        "sentence": diagnosis.sentence,
        "effects": [effect.name for effect in diagnosis.effects],
        "tied": [list(tied) for tied in diagnosis.tied],
        "error": said["rmse_before"],
        "floor": said["noise_floor"],
    }


def shown(
    given: Parameters, hand: HandDescription, pressures: Array, folder: Path
) -> dict[str, list[float]]:
    """Error over floor [-] of models with each effect at both ends of its usual range, against
    poses of the thumb's base of the base model at pressures (rows, channels) [Pa].
    """
    marks = np.array(list(MARKERS.values()))
    places = StaticHand(hand).points(THUMB, 0.0, marks, pressures)
    write_set(folder, hand, pressures, places, PALM_NOISE, "poses of the base model")
    found: dict[str, list[float]] = {}
    for candidate in (*IN_POSE[: given.pose_effects], *CONTROLS):
        file = folder / f"{candidate.label.replace(' ', '_')}.json"
        found[candidate.label] = kept(file, partial(error_over_floor, folder, candidate))
    return found


def error_over_floor(folder: Path, candidate: Candidate) -> list[float]:
    """Error over floor [-] of the models with an effect at both ends of its usual range."""
    data, model, found = load_measurements(folder), folder / "model.yaml", []
    for value in candidate.usual(2):
        write_file(model, MODEL.format(weight=1.0) + candidate.entry(value) + "\n")
        errors = errors_of(data, load_model(model))
        found.append(errors.held_out.rmse / errors.floor.total)
    return found


def places(given: Parameters, job: Job) -> Results:
    """Least distances [m] of the thumb's end from the places: of the base model, of controls, under
    each effect, and with contact.
    """
    targets = [target for target in TARGETS if target.number in given.places]
    job.progress("places, base model", 0.1)
    named = f"{'_'.join(map(str, given.places))}_{given.first}_{given.rounds}.json"
    reach = partial(nearest, first=given.first, rounds=given.rounds)
    folder = job.folder / "places"
    found: Results = kept(folder / f"base_{named}", partial(by_hand, targets, reach))
    found |= {"effects": {}, "bent_effects": {}}
    found["bent"] = kept(folder / f"bent_{named}", partial(bent, targets, reach))
    found["bent_seven"] = kept(folder / f"bent_seven_{named}", partial(bent_seven, targets, reach))
    for number, candidate in enumerate(IN_POSE[: given.pose_effects]):
        job.progress(f"places, {candidate.label}", 0.2 + 0.4 * number / len(IN_POSE))
        file = folder / f"{candidate.label.replace(' ', '_')}_{named}"
        found["effects"][candidate.label] = kept(file, partial(under, candidate, targets, reach))
    for number, candidate in enumerate(IN_POSE[: given.bent_effects]):
        job.progress(f"places without coils, {candidate.label}", 0.6 + 0.1 * number / len(IN_POSE))
        file = folder / f"bent_{candidate.label.replace(' ', '_')}_{named}"
        far = [target for target in targets if target.number in COILED]
        found["bent_effects"][candidate.label] = kept(
            file, partial(under, candidate, far, reach, JUDGED_BEND)
        )
    return found


def by_hand(targets: Sequence[Target], reach: Reach) -> Results:
    """Least distances [m] of the base model with its pressures [Pa], with a channel for each
    actuator, with places elsewhere on the fingers, and of the controls.
    """
    four = load_hand(HAND)
    base, rigid, seven = map(StaticHand, (four, hand_variant(RIGID), hand_variant(SEVEN)))
    near = [reach(base, target) for target in targets]
    no_index = base.limits * [name != "b" for name in four.channels]
    return {
        "numbers": [target.number for target in targets],
        FOUR: [gap for gap, _ in near],
        "pressures": [pressures.tolist() for _, pressures in near],
        SEVEN: [reach(seven, target)[0] for target in targets],
        RIGID: [reach(rigid, target)[0] for target in targets],
        "no_index": [reach(base, target, no_index)[0] for target in targets],
        "shifted": {
            f"{shift:+g}": [reach(base, moved(target, shift))[0] for target in targets]
            for shift in (-SHIFT, SHIFT)
        },
    }


def bent(targets: Sequence[Target], reach: Reach) -> dict[str, list[float]]:
    """Least distances [m] by the bend [deg] beyond which neither palm nor thumb may go."""
    hand = StaticHand(load_hand(HAND))
    return {
        f"{degrees:g}": [
            reach(hand, target, most_bend=np.radians(degrees))[0] for target in targets
        ]
        for degrees in BENDS
    }


def bent_seven(targets: Sequence[Target], reach: Reach) -> list[float]:
    """Least distances [m] without coils, with a channel for each actuator."""
    hand = StaticHand(hand_variant(SEVEN))
    return [reach(hand, t, most_bend=JUDGED_BEND)[0] for t in targets]


def moved(target: Target, shift: float) -> Target:
    """The place moved along its finger by a share of the length; tips stay on the finger."""
    return replace(target, share=min(1.0, target.share + shift))


def under(
    candidate: Candidate, targets: Sequence[Target], reach: Reach, most_bend: float = np.inf
) -> dict[str, Any]:
    """Least distances (values, places) [m] at both ends of the usual range of an effect."""
    values = candidate.usual(2)
    hands = [StaticHand(load_hand(HAND), [candidate.at(value)]) for value in values]
    gaps = [[reach(hand, target, most_bend=most_bend)[0] for target in targets] for hand in hands]
    numbers = [target.number for target in targets]
    return {"values": values.tolist(), "gaps": gaps, "numbers": numbers}


def sliding_forces(given: Parameters, job: Job) -> Results:
    """Forces [N] by pressure, for the base model, with other segments, and under each effect."""
    folder = job.folder / "forces"
    job.progress("forces, base model", 0.7)
    pressures = FORCE_PRESSURES if given.grasp_effects else (JUDGED,)
    base = {p: forces(folder, given.rate, p) for p in pressures}
    other = forces(folder, given.rate, segments=OTHER_SEGMENTS)
    found: Results = {
        "base": by_pressure(base),
        "other_segments": other.tolist(),
        "effects": {},
    }
    for number, candidate in enumerate(IN_GRASP[: given.grasp_effects]):
        job.progress(f"forces, {candidate.label}", 0.75 + 0.25 * number / len(IN_GRASP))
        found["effects"][candidate.label] = {
            f"{value:g}": by_pressure(
                {p: forces(folder, given.rate, p, effect=(candidate, value)) for p in pressures}
            )
            for value in candidate.usual(2)
        }
    return found


def by_pressure(predicted: Mapping[float, Array]) -> dict[str, list[float]]:
    """Forces by pressure as text [Pa]."""
    return {f"{pressure:g}": force.tolist() for pressure, force in predicted.items()}


# ---------------------------------------------------------------- report
def report(results: Results, given: Parameters) -> Report:
    """What each fact says of the model, and the effects that it names or bounds."""
    findings = [*_palm_rows(results["palm"]), *_place_rows(results["places"])]
    findings += _force_rows(results["forces"])
    findings += [
        Finding(f"fact left out: {fact['what']}", str(fact["value"]), fact["left_out"])
        for fact in yaml.safe_load(FACTS.read_text(encoding="utf-8"))["facts"]
        if "left_out" in fact
    ]
    return Report(findings, _conclusion(results))


def _palm_rows(found: Results) -> list[Finding]:
    named = ", ".join(found["effects"]) or "nothing"
    error, floor = (f"{1e3 * found[key]:.2f} mm" for key in ("error", "floor"))
    ours = f"{found['verdict']}, names {named}; error {error}, floor {floor}"
    rows = [
        Finding("palm at equal pressures", "a cone", ours, None, 1e3 * found["error"], "mm"),
        Finding("the same without pressures, as in Fig. 7.7", "-", found["refusal"]),
    ]
    tilt, elsewhere = (candidate.label for candidate in CONTROLS)
    for name in ("equal", "different"):
        least = {label: min(ends) for label, ends in found[name].items()}
        seen = [label for label, share in least.items() if share > RULES.explained_error]
        unseen = [label for label in least if label not in seen and label != elsewhere]
        ours = f"{len(seen)} of {len(least) - 1} effects show, not {', '.join(unseen) or 'any'}"
        rows.append(Finding(f"poses of the thumb's base at {name} pressures", "-", ours))
        ends = " and ".join(f"{share:.1f}" for share in found[name][tilt])
        ours = f"error {ends} times the floor (> {RULES.explained_error:g})"
        rows.append(Finding(f"control: {tilt}, {name} pressures", "-", ours, tilt in seen))
        ours = f"error {max(found[name][elsewhere]):.2g} of the floor (< 0.1)"
        met = max(found[name][elsewhere]) < 0.1
        rows.append(Finding(f"negative control: {elsewhere}, {name} pressures", "-", ours, met))
    return rows


def agreeing(numbers: Sequence[int], gaps: Sequence[float], radius: float = RADIUS) -> list[bool]:
    """Whether each place is within the radius [m] as in the thesis: all but place 1.

    >>> agreeing([1, 2, 3], [0.02, 0.001, 0.009])
    [True, True, False]
    """
    return [
        bool((gap <= radius) == REACHED[number - 1])
        for number, gap in zip(numbers, gaps, strict=True)
    ]


def _place_rows(found: Results) -> list[Finding]:
    numbers, rows = found["numbers"], []
    for k, number in enumerate(numbers):
        parts = [f"{1e3 * found[FOUR][k]:.1f} mm", f"seven channels {1e3 * found[SEVEN][k]:.1f}"]
        parts += [f"bent by up to {key} deg {1e3 * v[k]:.1f}" for key, v in found["bent"].items()]
        parts.append(f"the same with seven channels, by 270 {1e3 * found['bent_seven'][k]:.1f}")
        seen = "reached" if REACHED[number - 1] else "not reached"
        rows.append(
            Finding(f"place {number}", seen, "; ".join(parts), None, 1e3 * found[FOUR][k], "mm")
        )
    named = {"four channels": found[FOUR], "seven channels": found[SEVEN]}
    named |= {f"places shifted by {key}": gaps for key, gaps in found["shifted"].items()}
    named |= {f"bent by up to {key} deg": gaps for key, gaps in found["bent"].items()}
    named["seven channels, bent by up to 270 deg"] = found["bent_seven"]
    for name, gaps in named.items():
        right = agreeing(numbers, gaps)
        wrong = [str(n) for n, agrees in zip(numbers, right, strict=True) if not agrees]
        ours = f"{sum(right)} of {len(right)}" + (f", not {', '.join(wrong)}" if wrong else "")
        rows.append(Finding(f"places as in the thesis, {name}", "8 of 8", ours))
    within = sum(gap <= RADIUS for gap in found[RIGID])
    rows.append(
        Finding("negative control: palm rigid", "-", f"{within} within 8 mm (0)", within == 0)
    )
    index = [g for n, g in zip(numbers, found["no_index"], strict=True) if n <= 3]
    within = sum(gap <= RADIUS for gap in index)
    ours = f"{within} of {len(index)} within 8 mm (0)"
    rows.append(Finding("negative control: index empty, places 1 to 3", "-", ours, within == 0))
    rows += [_effect_row(numbers, *item) for item in found["effects"].items()]
    return rows + [_bent_row(*item) for item in found["bent_effects"].items()]


def _effect_row(numbers: Sequence[int], label: str, found: Mapping[str, Any]) -> Finding:
    """At which of its values an effect contradicts which places."""
    parts = []
    for value, gaps in zip(found["values"], found["gaps"], strict=True):
        right = agreeing(numbers, gaps)
        wrong = [str(n) for n, agrees in zip(numbers, right, strict=True) if not agrees]
        if wrong:
            parts.append(f"{value:.3g}: not {', '.join(wrong)}")
    ends = f"{found['values'][0]:.3g} to {found['values'][-1]:.3g}"
    return Finding(f"places under {label}", ends, "; ".join(parts) or "all as in the thesis")


def _bent_row(label: str, found: Mapping[str, Any]) -> Finding:
    """How near an effect brings the thumb, without coils, to places the base model misses then."""
    parts = [
        f"{value:.3g}: " + ", ".join(f"{1e3 * gap:.1f}" for gap in gaps)
        for value, gaps in zip(found["values"], found["gaps"], strict=True)
    ]
    numbers = ", ".join(map(str, found["numbers"]))
    what = f"places {numbers} [mm], bent by up to {np.degrees(JUDGED_BEND):g} deg, {label}"
    return Finding(what, "reached", "; ".join(parts))


def reaching(found: Results) -> list[str]:
    """Effects that bring the thumb, without coils, to all places that the base model misses then,
    at an end of their usual range.
    """
    return [
        label
        for label, one in found["bent_effects"].items()
        if any(max(gaps, default=np.inf) <= RADIUS for gaps in one["gaps"])
    ]


def prediction_uncertainty(found: Results) -> float:
    """Root mean square [N] of what other segments change in the forces."""
    change = np.array(found["other_segments"]) - found["base"][f"{JUDGED:g}"]
    return float(np.sqrt(np.mean(change**2)))


def _force_rows(found: Results) -> list[Finding]:
    sure = prediction_uncertainty(found)
    seen = f"{MEASURED:g} +- {UNCERTAINTY:g} N"
    rows = [Finding("uncertainty of a predicted force", "-", f"{sure:.2f} N", None, sure, "N")]
    at = found["base"][f"{JUDGED:g}"]
    for name, force, z in zip(DIRECTIONS, at, z_values(np.array(at), sure), strict=True):
        ours = f"{force:.1f} N at {JUDGED / 1e3:g} kPa, z = {z:+.1f}"
        rows.append(Finding(f"force {name}", seen, ours, None, float(z)))
    told = {"base model": found["base"]}
    told |= {
        f"{label} {value}": one
        for label, ends in found["effects"].items()
        for value, one in ends.items()
    }
    for name, predicted in told.items():
        squares, pressure = misfit(_numbers(predicted), sure)
        word = "refuted" if squares > REFUTED else "not refuted"
        ours = f"{squares:.1f} at {pressure / 1e3:.0f} kPa: {word} (<= {REFUTED:g})"
        rows.append(Finding(f"squares of z, pressure free, {name}", seen, ours, None, squares))
    return rows


def _numbers(predicted: Mapping[str, Sequence[float]]) -> dict[float, Array]:
    return {float(pressure): np.array(force) for pressure, force in predicted.items()}


def mending(found: Results) -> list[str]:
    """Effects that make refuted forces agree at an end of their usual range; none where the base
    model is not refuted.
    """
    sure = prediction_uncertainty(found)
    if misfit(_numbers(found["base"]), sure)[0] <= REFUTED:
        return []
    return [
        label
        for label, ends in found["effects"].items()
        if any(misfit(_numbers(one), sure)[0] <= REFUTED for one in ends.values())
    ]


def _conclusion(results: Results) -> str:
    found, of_forces = results["places"], results["forces"]
    right = agreeing(found["numbers"], found[FOUR])
    degrees = f"{np.degrees(JUDGED_BEND):g}"
    bent_right = agreeing(found["numbers"], found["bent"][degrees])
    seven_right = agreeing(found["numbers"], found["bent_seven"])
    squares, _ = misfit(_numbers(of_forces["base"]), prediction_uncertainty(of_forces))
    mends = mending(of_forces)
    told = "not refuted by the forces"
    if squares > REFUTED:
        told = f"refuted by the forces, which {' or '.join(mends) or 'no effect'} would mend"
    return (
        f"Palm: {results['palm']['verdict']}; {sum(right)} of {len(right)} places are as "
        f"in the thesis, {sum(seven_right)} with seven channels "
        f"and {sum(bent_right)} with four if palm and thumb bend by up to {degrees} deg, where "
        f"{' or '.join(reaching(found)) or 'no effect'} brings the thumb to all of the others; the "
        f"base model is {told}."
    )


# ---------------------------------------------------------------- figure
def draw(figure: Figure, results: Results, report: Report) -> None:
    """Distances of the places, under the base model and over the usual ranges of all effects; the
    forces over the pressure.
    """
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
    found = results["places"]
    numbers = np.array(found["numbers"])
    ends = np.array([one["gaps"] for one in found["effects"].values()])
    spread = 1e3 * ends.reshape(-1, len(numbers))
    left.vlines(
        numbers,
        spread.min(axis=0),
        spread.max(axis=0),
        color="0.75",
        lw=6,
        label="each effect, ends of its range",
    )
    left.plot(numbers, 1e3 * np.array(found[FOUR]), "o", label="base model, statics")
    left.plot(numbers, 1e3 * np.array(found[SEVEN]), "x", label="the same, seven channels")
    degrees = f"{np.degrees(JUDGED_BEND):g}"
    gaps = 1e3 * np.array(found["bent"][degrees])
    left.plot(numbers + 0.15, gaps, "s", label=f"palm and thumb bent by up to {degrees} deg")
    left.axhline(1e3 * RADIUS, color="0.4", ls=":", lw=1)
    left.set(xlabel="place (thesis: all but 1)", ylabel="thumb's end to place [mm]", ylim=(0, None))
    left.set_xticks(numbers)
    left.legend(fontsize=8)
    right.axhspan(MEASURED - UNCERTAINTY, MEASURED + UNCERTAINTY, color="0.88")
    base = _numbers(results["forces"]["base"])
    for k, name in enumerate(DIRECTIONS):
        right.plot(
            [1e-3 * p for p in base], [force[k] for force in base.values()], "o-", label=name
        )
    right.set(xlabel="pressure [kPa]", ylabel="force at which the cylinder slides [N]")
    right.set_ylim(0, None)
    right.legend(fontsize=8, title="grey: thesis", title_fontsize=8)
