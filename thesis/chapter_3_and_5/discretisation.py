"""Segments that a finger needs: tip blocked, and free at every pressure (5.2.1, Fig. 5.8).

A PyBullet body reports at most 30 spherical joints, so 50 segments are the static discrete chain of
`thesis.chapter_3_and_5.planar`, which the simulator is compared with at all other numbers.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from softhand_model.chain.free_response import segment_angles
from softhand_model.hand.actuator import Actuator, load_actuator
from thesis.chapter_3_and_5.planar import planar_finger
from thesis.chapter_3_and_5.stand import FingerStand
from thesis.chapter_3_and_5.static_finger import blocked_finger, chain_of, line_of
from thesis.frame import Array, Axes, Figure, Finding, Job, Report, Results, at_most, option

SIZE = (13.0, 3.8)

PRESSURES = 101  # from 0 to the limit
MOST = 40  # segments that are tried
TARGET = 1.0  # [% of the length] that a tip may be off
ACTUATOR = "P10.finger"
SWEPT = ("P10.finger", "P10.thumb", "P5")
FINEST = 50  # as a static chain
JUDGED = 10  # segments that are held to a target
BLOCK_BOTTOM = 0.07  # [m]
SHARES = np.linspace(0.0, 1.0, 201)  # of the length, where shapes are compared
SMALL = {"segments": (10,)}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    pressure: float = option(40e3, "in the blocked finger [Pa]")
    gap: float = option(0.015, "from the straight finger to the block [m]")
    segments: tuple[int, ...] = option((3, 5, 10, 20), "in the simulator, 10 among them [-]")

    def __post_init__(self) -> None:
        if JUDGED not in self.segments:
            raise ValueError(f"segments must have {JUDGED} among them, got {self.segments}")


def free_tips(actuator: Actuator, segments: int, pressures: Array) -> Array:
    """Places (m, 2) [m], x and z, of the free tip at pressures (m,) [Pa]: a joint in the middle of
    each segment, as the simulator has them.

    >>> from softhand_model.hand.actuator import load_actuator
    >>> free_tips(load_actuator("P10.finger"), 5, np.array([0.0])).round(6).tolist()
    [[0.0, 0.09]]
    """
    angles = segment_angles(actuator, segments, pressures)[0]
    tangent = np.hstack([np.zeros((len(angles), 1)), np.cumsum(angles, axis=1)])
    along = np.full(segments + 1, actuator.length / segments)
    along[[0, -1]] /= 2.0
    return np.stack([np.sin(tangent) @ along, np.cos(tangent) @ along], axis=1)


def sweep(actuator: Actuator, segments: Sequence[int], finest: int) -> dict[str, Any]:
    """Pressures [Pa]; `off`, by number of segments: distance of the tip from that of the finest
    chain [% of the length]; `enough`: least number of segments with which TARGET holds up to each
    pressure.
    """
    pressures = np.linspace(0.0, actuator.max_pressure, PRESSURES)
    fine = free_tips(actuator, finest, pressures)

    def off(count: int) -> Array:
        apart = np.linalg.norm(free_tips(actuator, count, pressures) - fine, axis=1)
        return 100.0 * apart / actuator.length

    tried = np.array([np.maximum.accumulate(off(count)) for count in range(2, MOST + 1)])
    beyond = np.vstack([np.ones(PRESSURES, bool), tried > TARGET])
    # the last number that misses it, so that all larger ones keep it as well
    last = len(beyond) - 1 - np.argmax(beyond[::-1], axis=0)
    return {
        "pressure": pressures.tolist(),
        "off": {str(count): off(count).tolist() for count in segments},
        "enough": (last + 2).tolist(),
    }


def worst(swept: dict[str, Any], segments: int) -> tuple[float, float]:
    """Greatest distance of the tip [% of the length], and the pressure [Pa] at which it occurs."""
    off = swept["off"][str(segments)]
    return max(off), swept["pressure"][int(np.argmax(off))]


def holds_up_to(swept: dict[str, Any], segments: int) -> float:
    """Pressure [Pa] up to which TARGET holds.

    >>> holds_up_to({"pressure": [0.0, 1e3, 2e3, 3e3], "off": {"5": [0.0, 0.5, 1.5, 0.2]}}, 5)
    1000.0
    """
    beyond = np.flatnonzero(np.array(swept["off"][str(segments)]) > TARGET)
    return float(swept["pressure"][beyond[0] - 1 if len(beyond) else -1])


def run(given: Parameters, job: Job) -> Results:
    """Fingers that press on a block (force, tip, line of the passive layer), and free ones."""
    length = load_actuator(ACTUATOR).length
    counts = given.segments
    fingers = {str(count): {"static": _static(count, given)} for count in (*counts, FINEST)}
    for k, count in enumerate(counts):
        job.progress(f"{count} segments", k / len(counts))
        fingers[str(count)]["simulated"] = _simulated(count, given)
    return {
        "pressure": given.pressure,
        "gap": given.gap,
        "length": length,
        "fingers": fingers,
        "free_at_limit": _free_at_limit(),
        "swept": {name: sweep(load_actuator(name), counts, FINEST) for name in SWEPT},
    }


def _simulated(segments: int, given: Parameters) -> dict[str, Any]:
    with FingerStand(load_actuator(ACTUATOR), segments) as stand:
        stand.settle(given.pressure)
        free_tip = stand.line()[-1, [0, 2]]
        stand.settle(0.0)
        block = stand.block(given.gap, BLOCK_BOTTOM)
        stand.settle(given.pressure)
        touch = stand.touch(block)
        return {
            "force": touch.force,
            "touched_at": touch.place.tolist(),
            "tip_angle": float(stand.bends().sum()),
            "line": stand.line()[:, [0, 2]].tolist(),
            "free_tip": free_tip.tolist(),
        }


def _free_at_limit() -> dict[str, Any]:
    """Free tip of JUDGED segments at the pressure limit: simulator and static chain."""
    actuator = load_actuator(ACTUATOR)
    with FingerStand(actuator, JUDGED) as stand:
        stand.settle(actuator.max_pressure)
        simulated = stand.line()[-1, [0, 2]]
    model = chain_of(actuator, JUDGED)
    rest = model.rest_rotation([actuator.max_pressure])[:, 1]
    static = line_of(planar_finger(model.segments), rest)[-1]
    return {"simulated": simulated.tolist(), "static": static.tolist()}


def _static(segments: int, given: Parameters) -> dict[str, Any]:
    actuator = load_actuator(ACTUATOR)
    found = blocked_finger(actuator, segments, given.pressure, given.gap)
    model = chain_of(actuator, segments)
    finger = planar_finger(model.segments)
    line = line_of(finger, found.angles)
    free_line = line_of(finger, model.rest_rotation([given.pressure])[:, 1])
    return {
        "force": found.tip_force,
        "tip_angle": float(found.angles.sum()),
        "line": line.tolist(),
        "free_tip": free_line[-1].tolist(),
    }


def report(results: Results, given: Parameters) -> Report:
    """Each number of segments against 50, blocked and free; the simulator against the static
    chain.
    """
    return Report(
        [
            *(_blocked_row(results, count) for count in _counts(results)),
            *(_swept_row(name, swept) for name, swept in results["swept"].items()),
            *_simulator_rows(results),
        ],
        conclude(results),
    )


def _blocked_row(results: Results, count: int) -> Finding:
    """Finding about the blocked finger. Its tip is held in place by the block, so the whole shape
    and the contact force are compared.
    """
    fingers = results["fingers"]
    finger, finest = fingers[str(count)]["simulated"], fingers[str(FINEST)]["static"]
    force = 100.0 * abs(finger["force"] / finest["force"] - 1.0)
    gaps = _gaps(results, count)
    angle = np.degrees(finger["tip_angle"] - finest["tip_angle"])
    return Finding(
        f"{count} against {FINEST} segments, blocked at {results['pressure'] / 1e3:g} kPa",
        "deviates at the tip" if count == 3 else "same shape but at the tip",
        f"shape off by {gaps.max():.2g} % of the length at most, at "
        f"{100.0 * SHARES[gaps.argmax()]:.0f} % of it; tip {gaps[-1]:.2g} %, force {force:.2g} %, "
        f"tip angle {angle:+.2g} deg"
        + (f" (all but the angle <= {TARGET:g} %)" if count == JUDGED else ""),
        bool(max(gaps.max(), force) <= TARGET) if count == JUDGED else None,
    )


def _swept_row(name: str, swept: dict[str, Any]) -> Finding:
    off, pressure = worst(swept, JUDGED)
    return Finding(
        f"{name}, {JUDGED} against {FINEST} segments, free to {swept['pressure'][-1] / 1e3:g} kPa",
        "-",
        f"tip off by {off:.2g} % of the length at {pressure / 1e3:.0f} kPa (<= {TARGET:g}); "
        f"{TARGET:g} % holds to {holds_up_to(swept, JUDGED) / 1e3:.0f} kPa, and with "
        f"{swept['enough'][-1]} segments over the whole range",
        bool(off <= TARGET),
    )


def _counts(results: Results) -> list[int]:
    return [int(count) for count in results["fingers"] if int(count) != FINEST]


def _simulator_rows(results: Results) -> list[Finding]:
    errors = [
        100.0 * abs(pair["simulated"]["force"] / pair["static"]["force"] - 1.0)
        for pair in (results["fingers"][str(count)] for count in _counts(results))
    ]
    free = results["free_at_limit"]
    apart = 100.0 * float(np.hypot(*np.subtract(free["simulated"], free["static"])))
    return [
        at_most("force, simulator against the same static chain", "-", max(errors), 0.1, "%"),
        at_most(
            f"free tip at the pressure limit, {JUDGED} segments, against the same chain",
            "-",
            apart / results["length"],
            0.1,
            "%",
        ),
    ]


def _gaps(results: Results, count: int) -> Array:
    """Distances [% of the length] to the shape of FINEST segments at SHARES of the length."""
    fingers = results["fingers"]
    lines = (fingers[str(count)]["simulated"]["line"], fingers[str(FINEST)]["static"]["line"])
    coarse, fine = (_at(line, SHARES) for line in lines)
    return 100.0 * np.linalg.norm(coarse - fine, axis=1) / results["length"]


def _at(line: list[list[float]], share: Array) -> Array:
    places = np.array(line)
    gone = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1)))
    return np.stack([np.interp(share, gone / gone[-1], column) for column in places.T], axis=1)


def conclude(results: Results) -> str:
    """The conclusion of the report."""
    blocked = ", ".join(
        f"{count}: {_gaps(results, count).max():.2g} %" for count in _counts(results)
    )
    free = "; ".join(
        f"{name} to {holds_up_to(swept, JUDGED) / 1e3:.0f} of {swept['pressure'][-1] / 1e3:g} kPa "
        f"({swept['enough'][-1]} segments do to the end)"
        for name, swept in results["swept"].items()
    )
    return (
        f"Blocked at {results['pressure'] / 1e3:g} kPa, largest distance to the shape of {FINEST} "
        f"segments, of the length: {blocked}. Free, {JUDGED} segments keep the tip within "
        f"{TARGET:g} %: {free}."
    )


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Distance of the blocked shapes to that of 50 segments, and of free tips over pressure."""
    blocked, *free = figure.subplots(1, 1 + len(results["swept"]), width_ratios=(1.3, 1, 1, 1))
    for color, count in enumerate(_counts(results)):
        blocked.plot(100.0 * SHARES, _gaps(results, count), f"C{color}", label=f"{count} segments")
    blocked.set(
        xlabel="place along the finger [%]",
        ylabel=f"distance to {FINEST} segments [% of length]",
        ylim=(0, None),
    )
    blocked.set_title(f"{ACTUATOR}, tip blocked at {results['pressure'] / 1e3:g} kPa", fontsize=9)
    blocked.legend(fontsize=8)
    for axes, (name, swept) in zip(free, results["swept"].items(), strict=True):
        _draw_free(axes, name, swept)
    free[0].set_ylabel(f"tip, distance to {FINEST} segments [%]")


def _draw_free(axes: Axes, name: str, swept: dict[str, Any]) -> None:
    pressure = np.array(swept["pressure"]) / 1e3
    for color, off in enumerate(swept["off"].values()):
        axes.semilogy(pressure, off, f"C{color}", lw=1)
    axes.axhline(TARGET, color="0.5", ls=":", lw=1)
    axes.set_title(f"{name}, free tip", fontsize=9)
    axes.set(xlabel="pressure [kPa]", xlim=(0, pressure[-1]), ylim=(0.01, 100.0))
    enough = axes.twinx()
    enough.plot(pressure, swept["enough"], "k", lw=1, ls="--")
    enough.set(ylim=(0, 40), ylabel=f"segments for {TARGET:g} % (dashed)")
