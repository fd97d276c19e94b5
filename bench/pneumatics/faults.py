"""Faults of the bench, one after the other: does the box survive them, and does it say so?

    python -m bench.pneumatics.faults

prints the table of docs/understand/fault-times.md.
"""

from __future__ import annotations

import copy
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.command_line import command_line
from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.box.diagnostics import LinkState, ValveActivity, box_reports
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.safety import BURST_MARGIN
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.pneumatics import load_pneumatics

CHANNELS = ("a", "b", "c")
LIMIT = 80e3  # gauge [Pa]
PERIOD = 2e-3  # of the samples [s]
PATIENCE = 4.0  # for a fault to be noticed [s]
VENTING = 2.0  # for the outlets to let the air out, or for the box to say that they do not [s]
EMPTY = 1e3  # gauge [Pa]
TOO_MUCH = 1e-3  # more than a channel can hold below its limit [kg]
STORM = 10_000  # commands
PLANT_SAYS = "hand_sim: no pneumaticbox/valves: outlets are open"


class Trial:
    """A box on the simulated box, filled; channel `hit` is the one that breaks.

    Args:
        seed: of volumes, masses, noise, and of which channel breaks.
    """

    def __init__(self, seed: int) -> None:
        drawn = np.random.default_rng(seed)
        volumes = drawn.uniform(20e-6, 60e-6, len(CHANNELS))
        self.parameters = load_pneumatics()
        relief = self.parameters.relief.pressures([LIMIT] * len(CHANNELS))
        self.bench = EmbeddedRig(CHANNELS, volumes, None, seed, relief)
        self.faults = self.bench.plant.faults
        settings = BoxSettings(
            CHANNELS, tuple(volumes.tolist()), (LIMIT,) * len(CHANNELS), ("mass",) * len(CHANNELS)
        )
        self.box = PneumaticBox(settings, load_calibration(None, len(CHANNELS)))
        self.link = LinkState(sensors_seen=True)
        self.hit = int(drawn.integers(len(CHANNELS)))
        self.masses = 0.4 * volumes / volumes.max() * 50e-6
        self.clock_ahead = 0.0
        self.alive = True
        self.run(1.2)
        self.command(self.masses)
        self.run(2.5)
        self.peak = self.gauge

    @property
    def opened(self) -> np.ndarray:
        """Where the spools are (n,): +1 inflating, -1 deflating, 0 closed."""
        return self.bench.plant.valve_states

    @property
    def gauge(self) -> np.ndarray:
        """True pressures (n,) [Pa]."""
        return self.bench.plant.pressures - self.parameters.ambient_pressure

    def command(self, masses: np.ndarray) -> None:
        """Command masses (n,) [kg]."""
        point = TrajectoryPoint(0.0, positions=masses.tolist())
        self.box.command(CHANNELS, [point], 0.0, self.box.time)

    def more(self) -> None:
        """Command more mass on the channel that breaks."""
        masses = self.masses.copy()
        masses[self.hit] += 12e-6
        self.command(masses)

    def run(self, duration: float) -> None:
        """Let time [s] pass."""
        for _ in range(round(duration / PERIOD)):
            self.step()

    def step(self) -> None:
        """Let the time of one sample pass, and the box answer it."""
        readings = self.bench.advance(PERIOD)
        if self.alive:
            self.bench.command(self.box.on_sample(self.bench.time + self.clock_ahead, readings))
        self.peak = np.maximum(getattr(self, "peak", 0.0), self.gauge)

    def said(self) -> str:
        """What stands in /diagnostics beyond OK, in one line."""
        activity = ValveActivity(len(CHANNELS))
        reports = box_reports(self.box, self.link, activity)
        return "; ".join(f"{r.name}: {r.message}" for r in reports if r.level > 0)


@dataclass(frozen=True)
class Case:
    """What breaks, what happens then, and by which words the box has to name it.

    `relieved` marks what only mechanical relief valves can hold, `warned` what is to be warned of
    while work goes on, `driverless` what leaves no driver that could say anything.
    """

    fault: str
    act: Callable[[Trial], None]
    words: str
    relieved: bool = False
    warned: bool = False
    driverless: bool = False


def _stuck(state: int) -> Callable[[Trial], None]:
    def act(trial: Trial) -> None:
        trial.faults.stick_valve(trial.hit, state)
        if state == 0:
            trial.more()

    return act


def _sensor_stuck(trial: Trial) -> None:
    trial.faults.stick_sensor(trial.hit)
    trial.more()


def _storm(trial: Trial) -> None:
    """Commands as fast as they can be made, the last of them sensible."""
    drawn = np.random.default_rng(trial.hit)
    for number in range(STORM):
        trial.command(drawn.uniform(0, TOO_MUCH, len(CHANNELS)))
        trial.link.traffic.note(1e-4 * number, "command", number, lambda: 1)
        if number % 20 == 0:
            trial.step()
    trial.link.storm = trial.link.traffic.storm(1e-4 * STORM)
    trial.command(trial.masses)


def _two_commanders(trial: Trial) -> None:
    """One wants more than the limit allows, the other little; it has the last word."""
    trial.link.traffic.commanders = 2
    for number in range(40):
        trial.command(trial.masses if number % 2 else np.full(len(CHANNELS), TOO_MUCH))
        trial.run(0.05)


def _set(name: str, value: Any) -> Callable[[Trial], None]:
    return lambda trial: setattr(trial, name, value)


CASES = (
    Case("valve stuck closed", _stuck(0), "pulses do not move its pressure"),
    Case("valve stuck inflating", _stuck(1), "shut off the supply", relieved=True),
    Case("valve stuck deflating", _stuck(-1), "has lost its pressure"),
    Case("tube burst", lambda t: t.faults.burst(t.hit), "has lost its pressure"),
    Case("channel's sensor stuck", _sensor_stuck, "its reading is constant"),
    Case("supply's sensor stuck", lambda t: t.faults.stick_sensor(len(CHANNELS)), "sensor supply"),
    Case("channel's sensor NaN", lambda t: t.faults.lose_sensor(t.hit), "not a number"),
    Case("supply's sensor NaN", lambda t: t.faults.lose_sensor(len(CHANNELS)), "sensor supply"),
    Case("supply lost", lambda t: t.faults.lose_supply(), "supply lost"),
    Case("driver killed", _set("alive", False), "", driverless=True),
    Case("clock set ahead by 5 s", _set("clock_ahead", 5.0), "no sensor sample for 250 ms"),
    Case("clock set back by 2 s", _set("clock_ahead", -2.0), "clock was set back"),
    Case("10,000 commands at once", _storm, "command storm", warned=True),
    Case("two commanders", _two_commanders, "two nodes command the box", warned=True),
)


def scenarios(seed: int) -> list[dict[str, Any]]:
    """Let each fault happen to a filled box, always the same one.

    Args:
        seed: of volumes, masses and noise, and of the channel that breaks.

    Returns:
        A row per fault: `fault`; `held`: the true pressure stayed below 1.2 times the limit, with
        a valve stuck inflating below where the relief valve is wide open; `opened`: every channel
        was let empty, or the box said which it could not; `named`: the fault stood in
        /diagnostics; `kept`: once repaired, only reset left the vent (for a warning: the last
        command was followed); `survived`: all of these; `silent`: not named; `after` [s] until it
        was noticed, NaN without a vent; `said` in /diagnostics.
    """
    filled = Trial(seed)
    return [_outcome(case, copy.deepcopy(filled)) for case in CASES]


def _outcome(case: Case, trial: Trial) -> dict[str, Any]:
    start = trial.bench.time
    case.act(trial)
    after = math.nan if case.warned or case.driverless else _until_vented(trial, start)
    trial.run(VENTING)
    said = PLANT_SAYS if case.driverless else trial.said()
    # without a driver it is the plant that opens the outlets, and the simulator that says so
    named = bool((trial.opened == -1).all()) if case.driverless else case.words in said
    row = {"fault": case.fault, "held": _held(case, trial), "opened": _opened(case, trial, said)}
    row |= {"named": named, "kept": _kept(case, trial)}
    survived = all(row[key] for key in ("held", "opened", "named", "kept"))
    return row | {"survived": survived, "silent": not named, "after": after, "said": said}


def _until_vented(trial: Trial, start: float) -> float:
    while not trial.box.latch and trial.bench.time < start + PATIENCE:
        trial.step()
    return trial.bench.time - start


def _held(case: Case, trial: Trial) -> bool:
    relief = trial.parameters.relief
    margin = relief.margin * (1 + relief.accumulation) if case.relieved else BURST_MARGIN
    return bool((trial.peak < margin * LIMIT).all())


def _opened(case: Case, trial: Trial, said: str) -> bool:
    if case.warned:
        return True
    full = np.flatnonzero(trial.gauge > EMPTY)
    return all(f"channel {CHANNELS[channel]}: pressure does not fall" in said for channel in full)


def _kept(case: Case, trial: Trial) -> bool:
    if case.warned:
        return bool(np.allclose(trial.bench.mass, trial.masses, atol=2.5e-6))
    if case.driverless:
        return bool((trial.gauge < EMPTY).all())
    trial.faults.clear()
    trial.run(0.6)
    vented = bool(trial.box.latch) and bool((trial.box.valves == -1).all())
    trial.box.reset()
    trial.run(0.5)
    return vented and not trial.box.latch


def main() -> int:
    """Print what becomes of each fault, over three seeds; 0 if all are survived."""
    command_line("bench.pneumatics.faults", __doc__).parse_args()
    rows = [scenarios(seed) for seed in range(3)]
    print("| fault | survived | noticed within [s] | /diagnostics |\n|---|---|---|---|")
    for outcomes in zip(*rows, strict=True):
        survived = sum(outcome["survived"] for outcome in outcomes)
        after = max(outcome["after"] for outcome in outcomes)
        shown = "-" if math.isnan(after) else f"{after:.2f}"
        first = outcomes[0]
        print(f"| {first['fault']} | {survived} of {len(rows)} | {shown} | {first['said']} |")
    return 0 if all(outcome["survived"] for row in rows for outcome in row) else 1


if __name__ == "__main__":
    sys.exit(main())
