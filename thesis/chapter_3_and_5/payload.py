"""Payload of 0.5 kg in both hands, in six postures (7.3.1)."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from softhand_model.effects.load import STANDARD_GRAVITY
from thesis.chapter_3_and_5.held_cylinder import STEP, Grasp, HeldCylinder
from thesis.frame import Figure, Finding, Job, Report, Results, option

SIZE = (9.0, 4.0)

HAND_2, HAND_1 = "rbo_hand_2", "rbo_hand_1"
PLACE_2, PLACE_1 = (0.055, 0.0, 0.115), (0.062, 0.0, 0.100)  # [m] of the cylinder in the hands
ENOUGH, ENOUGH_BARE = 10, 17  # segments with which no joint stops, with its model and without
LIFTED = "RBO Hand 1 at 210 kPa"
GRASPS = {
    "RBO Hand 2 at 60 kPa": Grasp(HAND_2, PLACE_2, (60e3, 60e3, 60e3, 90e3)),
    "RBO Hand 1 at 150 kPa": Grasp(HAND_1, PLACE_1, (150e3,), ENOUGH, HAND_1),
    LIFTED: Grasp(HAND_1, PLACE_1, (210e3,), ENOUGH, HAND_1),  # the thesis's pressure, 8.1.2
    "RBO Hand 1 at 150 kPa, bare model": Grasp(HAND_1, PLACE_1, (150e3,), ENOUGH_BARE),
    "RBO Hand 1 at 210 kPa, bare model": Grasp(HAND_1, PLACE_1, (210e3,), ENOUGH_BARE),
}
JUDGED_HAND = "RBO Hand 2 at 60 kPa"  # the thesis states no other payload
DIRECTIONS = {  # of the weight, in the wrist's frame
    "palm down": (1.0, 0.0, 0.0),
    "palm up": (-1.0, 0.0, 0.0),
    "fingers down": (0.0, 0.0, 1.0),
    "fingers up": (0.0, 0.0, -1.0),
    "thumb's side down": (0.0, 1.0, 0.0),
    "other side down": (0.0, -1.0, 0.0),
}
LOADING, HOLDING = 1.5, 1.5  # [s]
JUDGED = 1.0  # [s] at the end of the hold
DRIFT = 0.001  # [m] that a held object may move in that time
LOST = "squeezed out while the hand closes, before any weight acts"
SMALL = {"grasps": (JUDGED_HAND,)}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    mass: float = option(0.5, "of the cylinder [kg]")
    grasps: tuple[str, ...] = option(tuple(GRASPS), "hands and pressures, by name [-]")

    def __post_init__(self) -> None:
        if unknown := set(self.grasps) - set(GRASPS):
            raise ValueError(f"grasps: expected of {', '.join(GRASPS)}, got {', '.join(unknown)}")


def weighed(
    held: HeldCylinder, direction: tuple[float, float, float], mass: float
) -> dict[str, Any]:
    """Times [s] and displacements [m] of the cylinder while its weight grows and is held."""
    start, times, ways = held.place, [], []
    for k in range(round((LOADING + HOLDING) / STEP)):
        share = min(1.0, (k + 1) * STEP / LOADING)
        held.load(share * mass * STANDARD_GRAVITY * np.array(direction))
        if k % 10 == 9:
            times.append((k + 1) * STEP)
            ways.append((held.place - start).tolist())
    return {"time": times, "way": ways}


def run(given: Parameters, job: Job) -> Results:
    """The weight in every direction, each from the same grasp; no results where the hand lost the
    cylinder while it closed.
    """
    hands: Results = {}
    for name in given.grasps:
        job.progress(name, len(hands) / len(given.grasps))
        hands[name] = held_up(GRASPS[name], given.mass)
    return {"hands": hands}


def held_up(grasp: Grasp, mass: float) -> dict[str, Any]:
    """How a hand holds the cylinder of a mass [kg] in all directions; None if it does not hold
    it.
    """
    with HeldCylinder(grasp, mass) as held:
        saved, holds, touching = held.simulation.save(), {}, held.touching()
        for posture, direction in DIRECTIONS.items() if touching else ():
            held.simulation.restore(saved)
            holds[posture] = weighed(held, direction, mass)
    return {
        "pressures": list(grasp.pressures),
        "segments": grasp.segments,
        "touching": touching,
        "holds": holds,
    }


def drift(hold: dict[str, Any]) -> float:
    """Displacement [m] of the cylinder between the ends of the judged interval.

    >>> ways = [[0.0, 0.0, 0.1], [0.0, 0.0, 0.2], [0.0, 0.0, 0.4]]
    >>> round(drift({"time": [1.9, 2.5, 3.0], "way": ways}), 3)
    0.2
    """
    ways = np.array(hold["way"])
    begin = int(np.searchsorted(hold["time"], LOADING + HOLDING - JUDGED - 1e-9))
    return float(np.linalg.norm(ways[begin:] - ways[-1], axis=1).max())


def report(results: Results, given: Parameters) -> Report:
    """How far the cylinder moves under its weight, and whether it comes to rest. The thesis states
    a payload for RBO Hand 2 only.
    """
    findings, words = [], []
    for hand, found in results["hands"].items():
        judged = hand == JUDGED_HAND
        limit, seen = (f" (<= {1e3 * DRIFT:g})", "0.5 kg") if judged else ("", "-")
        if not found["touching"]:
            findings.append(Finding(hand, "-", LOST, False if judged else None))
        drifts = {posture: drift(hold) for posture, hold in found["holds"].items()}
        for posture, moved in drifts.items():
            way = np.linalg.norm(found["holds"][posture]["way"][-1])
            ours = f"{1e3 * way:.1f} mm, at last {1e3 * moved:.2f} mm{limit}"
            met = moved <= DRIFT if judged else None
            findings.append(Finding(f"{hand}{', ' if judged else ': '}{posture}", seen, ours, met))
        held = sum(moved <= DRIFT for moved in drifts.values())
        words.append(f"{hand} in {held} of {len(DIRECTIONS)}")
    return Report(findings, f"Postures in which 0.5 kg stays in the hand: {'; '.join(words)}.")


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Displacement over time, for the grasps that hold the cylinder."""
    hands = {hand: found for hand, found in results["hands"].items() if found["holds"]}
    panels = figure.subplots(1, len(hands), sharex=True, sharey=True, squeeze=False)[0]
    for axes, (hand, found) in zip(panels, hands.items(), strict=True):
        for posture, hold in found["holds"].items():
            way = 1e3 * np.linalg.norm(hold["way"], axis=1)
            axes.plot(hold["time"], way, lw=1, label=posture)
        axes.axvline(LOADING, color="0.6", ls=":", lw=1)
        axes.set_title(f"{hand}, {found['segments']} segments", fontsize=9)
        axes.set_xlabel("time [s]")
    panels[0].set(ylabel="way of 0.5 kg [mm]", xlim=(0, None), ylim=(0, None))
    panels[0].legend(fontsize=8, loc="upper left")
