"""Low inertia, no delay, small forces, harmless collisions: soft and rigid finger (6.1.3, 6.4)."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from softhand_model.hand.hand import load_hand
from softhand_model.motion.pressed_body import SKIN_NORMAL
from thesis.chapter_6.blow import LONGEST_BLOW, Blow, Finger, finger_of, strike
from thesis.frame import Figure, Finding, Job, Report, Results, at_most, number, option

SIZE = (9.5, 3.4)
SOFT, RIGID = "soft", "rigid"
# criteria, set before the first run
INERTIA_SHARE = 1 / 3  # of the rod's apparent mass, at most
REACTION_TIME = 0.005  # [s] until the soft finger gives way as fast as it is struck, at most
FORCE_SHARE = 1 / 3  # of the force of the rigid finger, at most
SKIN_SHARE = 0.2  # of the ball's energy, that the skin has to take, at most
RIGID_SKIN_SHARE = 0.95  # that the rigid finger's skin takes, at least: the negative control
BALANCE = 1e-4  # of energies, at most
OWN_ERROR = 0.01  # of a rigid finger's force against that of a wall, at most
DELAYS = (0.0, 0.001, 0.002, 0.003, 0.004, 0.005, 0.007, 0.010)  # [s]


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    mass: float = option(0.06, "of the ball, that of an egg [kg]")
    speed: float = option(0.2, "at which it meets the finger [m/s]")
    place: float = option(0.9, "where it meets it, over the finger's length [-]")
    stiffness: float = option(1e5, "modulus of the rigid finger over that of the soft [-]")
    segments: int = option(10, "of the finger [-]")

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not value > 0.0:
                raise ValueError(f"{name}: expected a number above 0, got {value:g}")


def run(given: Parameters, job: Job) -> Results:
    """Blows on both fingers, and on the soft one if it gave way only after a delay."""
    soft = finger_of(load_hand("single_finger"), given.place, given.segments)
    fingers = {SOFT: soft, RIGID: soft.scaled(given.stiffness)}
    found: Results = {}
    for number_, (name, finger) in enumerate(fingers.items()):
        job.progress(name, number_ / 3)
        found[name] = _told(finger, strike(finger, given.mass, given.speed))
    job.progress("delays", 2 / 3)
    delayed = [strike(soft, given.mass, given.speed, delay) for delay in DELAYS]
    found["delayed_force"] = [float(blow.force.max()) for blow in delayed]
    return found


def _told(finger: Finger, blow: Blow) -> dict[str, Any]:
    first = blow.time < blow.time[-1] / 6.0
    return {
        "apparent_mass": finger.apparent_mass,
        "locked_mass": finger.locked_mass,
        "tip_stiffness": finger.tip_stiffness,
        "follows_after": blow.follows_after if np.isfinite(blow.follows_after) else None,
        "force": float(blow.force.max()),
        "skin_energy": float(blow.energies["skin"].max()),
        "lost_energy": float(blow.energies["lost"][-1]),
        "balance": blow.balance,
        "course": {"time": blow.time[first].tolist(), "force": blow.force[first].tolist()},
    }


def report(results: Results, given: Parameters) -> Report:
    """The four principles, each against the rigid finger; the thesis states no numbers."""
    soft, rigid = results[SOFT], results[RIGID]
    energy = given.mass * given.speed**2 / 2.0
    wall = given.speed * np.sqrt(SKIN_NORMAL * given.mass)
    follows = soft["follows_after"]
    findings = [
        number("apparent mass of the soft finger", 1e3 * soft["apparent_mass"], "g"),
        number("of a rod of its mass on a hinge", 1e3 * soft["locked_mass"], "g"),
        at_most(
            "low inertia: soft over rod", "low", soft["apparent_mass"] / soft["locked_mass"],
            INERTIA_SHARE, "",
        ),
        at_most(
            "no delay: the soft finger gives way as fast as it is struck after", "none",
            1e3 * (LONGEST_BLOW if follows is None else follows), 1e3 * REACTION_TIME, "ms",
        ),
        Finding(
            "negative control: the rigid finger does so", "-",
            "never" if rigid["follows_after"] is None else f"{1e3 * rigid['follows_after']:.1f} ms",
            rigid["follows_after"] is None or rigid["follows_after"] > REACTION_TIME,
        ),
        number("force on the ball, soft", soft["force"], "N"),
        number("force on the ball, rigid", rigid["force"], "N"),
        at_most(
            "small force: soft over rigid", "small", soft["force"] / rigid["force"], FORCE_SHARE, ""
        ),
        number("the same, if it gave way only after 5 ms", results["delayed_force"][5], "N"),
        number("energy of the ball", 1e3 * energy, "mJ"),
        at_most(
            "harmless collision: energy in the skin over the ball's, soft", "small",
            soft["skin_energy"] / energy, SKIN_SHARE, "",
        ),
        Finding(
            "negative control: the same, rigid", "-",
            f"{rigid['skin_energy'] / energy:.3f} (>= {RIGID_SKIN_SHARE:g})",
            rigid["skin_energy"] / energy >= RIGID_SKIN_SHARE,
        ),
        at_most(
            "check: force of the rigid finger against v*sqrt(k*m) of a wall", "-",
            abs(rigid["force"] / wall - 1.0), OWN_ERROR, "",
        ),
        at_most("check: energies, largest error of their sum", "-",
                max(soft["balance"], rigid["balance"]), BALANCE, ""),
        number("force per mm that the hand is too far, soft", soft["tip_stiffness"] / 1e3, "N"),
        number("the same, the skin of a rigid finger", SKIN_NORMAL / 1e3, "N"),
    ]  # fmt: skip
    return Report(findings, conclude(results))


def conclude(results: Results) -> str:
    """The conclusion of the report."""
    soft, rigid = results[SOFT], results[RIGID]
    return (
        f"Struck by an egg's mass, the soft finger presses on it with {soft['force']:.2g} N, the "
        f"rigid one with {rigid['force']:.2g} N."
    )


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Force over time on both fingers, and the largest force over the delay of a reaction."""
    course, delays = figure.subplots(1, 2)
    for name, color in ((SOFT, "C2"), (RIGID, "C3")):
        shown = results[name]["course"]
        course.plot(1e3 * np.array(shown["time"]), shown["force"], color=color, label=name)
    course.set(xlabel="time since the touch [ms]", ylabel="force on the ball [N]", xlim=(0, 60))
    course.legend(fontsize=8)
    delays.plot(1e3 * np.array(DELAYS), results["delayed_force"], "o-", color="C0", ms=3)
    delays.axhline(results[RIGID]["force"], color="C3", ls=":", lw=1)
    delays.set(xlabel="delay until the soft finger gives way [ms]", ylabel="largest force [N]")
    delays.set_ylim(bottom=0.0)
