"""Payload of both hands in six postures: 0.5 kg, the least pressure, the largest mass (7.3.1)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from textwrap import wrap
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
JUDGED_HAND = "RBO Hand 2 at 60 kPa"  # the thesis states no other payload, and no pressure for it
PAYLOAD = 0.5  # [kg], of the thesis
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
PRESSURE_STEPS = 12  # of equal size, in which pressures fall to zero
HEAVIER = 1.1  # each mass over the one before
MOST_MASSES = 24  # that are tried, up to nine times the first
TITLE_WIDTH = 26  # characters
SMALL = {"grasps": (JUDGED_HAND,), "limits": ()}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    mass: float = option(PAYLOAD, "of the cylinder [kg]")
    grasps: tuple[str, ...] = option(tuple(GRASPS), "hands and pressures, by name [-]")
    limits: tuple[str, ...] = option(
        (JUDGED_HAND, LIFTED), "those whose least pressure and largest mass are sought [-]"
    )

    def __post_init__(self) -> None:
        for field in ("grasps", "limits"):
            if unknown := sorted(set(getattr(self, field)) - set(GRASPS)):
                expected = f"of {', '.join(GRASPS)}"
                raise ValueError(f"{field}: expected {expected}, got {', '.join(unknown)}")


def weighed(
    held: HeldCylinder, direction: tuple[float, float, float], mass: float
) -> dict[str, Any]:
    """Times [s] and displacements [m] of the cylinder while its weight grows and is held, and what
    touches it in the end.
    """
    start, times, ways = held.place, [], []
    for k in range(round((LOADING + HOLDING) / STEP)):
        share = min(1.0, (k + 1) * STEP / LOADING)
        held.load(share * mass * STANDARD_GRAVITY * np.array(direction))
        if k % 10 == 9:
            times.append((k + 1) * STEP)
            ways.append((held.place - start).tolist())
    return {"time": times, "way": ways, "touching": held.touching()}


def run(given: Parameters, job: Job) -> Results:
    """The weight in every direction, each from the same grasp; no results where the hand lost the
    cylinder while it closed.
    """
    hands: Results = {}
    limits: Results = {}
    count = len(given.grasps) + 2 * len(given.limits)
    for name in given.grasps:
        job.progress(name, len(hands) / count)
        hands[name] = held_up(GRASPS[name], given.mass)
    for name in given.limits:
        job.progress(f"limits of {name}", (len(hands) + 2 * len(limits)) / count)
        grasp = GRASPS[name]
        limits[name] = {
            "pressures": pressure_limit(lambda g: stays(g, given.mass), grasp),
            "masses": mass_limit(lambda mass, grasp=grasp: stays(grasp, mass), given.mass),
        }
    return {"hands": hands, "limits": limits}


def stays(grasp: Grasp, mass: float) -> bool:
    """Whether a mass [kg] stays in the hand in every posture; ends with the first that loses it."""
    with HeldCylinder(grasp, mass) as held:
        return bool(held.touching()) and all(kept(hold) for _, hold in in_postures(held, mass))


def pressure_limit(holds: Callable[[Grasp], bool], grasp: Grasp) -> list[float | None]:
    """The least multiple of a grasp's pressures with which it and all greater ones hold, and the
    next, which does not: pressures of the first channel [Pa], None where there is none.

    >>> grasp = Grasp("rbo_hand_2", (0.0, 0.0, 0.0), (60e3, 90e3))
    >>> pressure_limit(lambda g: g.pressures[1] > 50e3, grasp)
    [35000.0, 30000.0]
    """
    least: float | None = None
    for k in range(PRESSURE_STEPS, 0, -1):
        pressures = tuple(p * k / PRESSURE_STEPS for p in grasp.pressures)
        if not holds(replace(grasp, pressures=pressures)):
            return [least, pressures[0]]
        least = pressures[0]
    return [least, None]


def mass_limit(holds: Callable[[float], bool], first: float) -> list[float | None]:
    """The largest mass [kg], from a first one up in steps of 10 %, that is held with all lighter
    ones tried, and the next, which is not; None where there is none.

    >>> [round(mass, 3) for mass in mass_limit(lambda mass: mass < 0.7, 0.5)]
    [0.666, 0.732]
    """
    largest: float | None = None
    for k in range(MOST_MASSES):
        mass = first * HEAVIER**k
        if not holds(mass):
            return [largest, mass]
        largest = mass
    return [largest, None]


def in_postures(held: HeldCylinder, mass: float) -> Iterator[tuple[str, dict[str, Any]]]:
    """Each posture with what the cylinder does in it (`weighed`), from the same closed hand."""
    saved = held.simulation.save()
    for posture, direction in DIRECTIONS.items():
        held.simulation.restore(saved)
        yield posture, weighed(held, direction, mass)


def held_up(grasp: Grasp, mass: float) -> dict[str, Any]:
    """How a hand holds the cylinder of a mass [kg] in all directions; None if it does not hold
    it.
    """
    with HeldCylinder(grasp, mass) as held:
        touching = held.touching()
        holds = dict(in_postures(held, mass)) if touching else {}
    return {
        "mass": mass,
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


def kept(hold: dict[str, Any]) -> bool:
    """Whether the cylinder is at rest in the judged interval, and still touched."""
    return bool(hold["touching"]) and drift(hold) <= DRIFT


def report(results: Results, given: Parameters) -> Report:
    """How far the cylinder moves under its weight, and whether it comes to rest. The thesis states
    a payload for RBO Hand 2 only, and no pressure for it.
    """
    findings, words = [], []
    for hand, found in results["hands"].items():
        judged = hand == JUDGED_HAND and given.mass == PAYLOAD
        limit, seen = (f" (<= {1e3 * DRIFT:g})", f"{PAYLOAD:g} kg") if judged else ("", "-")
        if not found["touching"]:
            findings.append(Finding(hand, "-", LOST, False if judged else None))
        for posture, hold in found["holds"].items():
            way = 1e3 * np.linalg.norm(hold["way"][-1])
            ours = f"{way:.1f} mm, at last {1e3 * drift(hold):.2f} mm{limit}"
            name = f"{hand}{', ' if judged else ': '}{posture}"
            findings.append(Finding(name, seen, ours, kept(hold) if judged else None))
        held = sum(map(kept, found["holds"].values()))
        words.append(f"{hand} in {held} of {len(DIRECTIONS)}")
    mass = f"{given.mass:g} kg"
    for hand, limits in results["limits"].items():
        findings += [
            Finding(
                f"{hand}: least pressure for {mass}", "-", told(limits["pressures"], 1e3, "kPa")
            ),
            Finding(f"{hand}: largest mass", "-", told(limits["masses"], 1.0, "kg")),
        ]
    return Report(findings, f"Postures in which {mass} stays in the hand: {'; '.join(words)}.")


def told(limit: Sequence[float | None], unit: float, name: str) -> str:
    """Both ends of a limit (`pressure_limit`, `mass_limit`) in a unit with a name.

    >>> told([0.666, 0.732], 1.0, "kg")
    '0.666 kg held in all postures, 0.732 not'
    """
    held, lost = (end and f"{end / unit:.3g}" for end in limit)
    held = held and f"{held} {name} held in all postures"
    return ", ".join(
        [
            held or "none of those tried is held in all postures",
            f"{lost} not" if lost else "no more tried",
        ]
    )


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Displacement over time, for the grasps that hold the cylinder."""
    hands = {hand: found for hand, found in results["hands"].items() if found["holds"]}
    panels = figure.subplots(1, len(hands), sharex=True, sharey=True, squeeze=False)[0]
    for axes, (hand, found) in zip(panels, hands.items(), strict=True):
        for posture, hold in found["holds"].items():
            way = 1e3 * np.linalg.norm(hold["way"], axis=1)
            axes.plot(hold["time"], way, lw=1, label=posture)
        axes.axvline(LOADING, color="0.6", ls=":", lw=1)
        title = f"{hand}, {found['segments']} segments"
        axes.set_title("\n".join(wrap(title, TITLE_WIDTH)), fontsize=9)
        axes.set_xlabel("time [s]")
    mass = next(iter(hands.values()))["mass"]
    panels[0].set(ylabel=f"way of {mass:g} kg [mm]", xlim=(0, None), ylim=(0, None))
    panels[0].legend(fontsize=8, loc="upper left")
