"""A finger pressed on a table under mass, pressure and volume control, over ROS (Figs 4.1, 4.2).

The thesis: the push moves pressure and volume along the line of equal air mass; the valves stay
closed under mass control alone. The folder of the result gets bag/ and log/ of the session.
"""

from __future__ import annotations

import shutil
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from threading import Event

import numpy as np

from softhand_bringup.processes.waiting import Interrupted
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, ROOM_TEMPERATURE
from thesis.equilibrium_point.recording import Push, Recording, read_recordings
from thesis.equilibrium_point.session import MODES, Session
from thesis.frame import Array, Axes, Figure, Finding, Job, Report, Results, option

SIZE = (9.5, 8.5)
SMALL = None  # real nodes, in their own time
COLOURS = {"mass": "tab:purple", "pressure": "tab:orange", "volume": "tab:blue"}
LABELS = ("gauge pressure [kPa]", "[kPa]", "volume\n[cm3]", "air, estimated\n[mg]", "force\n[N]")
AIR, AIR_SPAN = 2, 6.0  # row of the air mass, and what it shows to both sides [mg]
LINE_SPACING = 1e-6  # of the lines of equal air mass [kg]
EXPECTED = {  # valve openings; course of pressure and volume; more air than before
    "mass": ("none", "along the line of equal air mass", "none"),
    "others": ("some", "-", "-"),
}
RECORDED = ("time", "pressure", "volume", "mass", "force", "openings")


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    seed: int = option(0, "of sensor noise and valve jitter [-]")
    modes: tuple[str, ...] = option(MODES, "controllers, in the order in which they are shown [-]")

    def __post_init__(self) -> None:
        if unknown := set(self.modes) - set(MODES):
            raise ValueError(f"modes: expected of {', '.join(MODES)}, got {', '.join(unknown)}")


def run(given: Parameters, job: Job) -> Results:
    """Push once under every controller; the pushes and their recordings."""
    with stopped_by_signals() as stopped:
        session = Session(job.folder, given.seed, job.progress, given.modes, stopped)
        shutil.rmtree(session.bag, ignore_errors=True)  # of the run that this one replaces
        try:
            return as_results(read_recordings(session.bag, session.run()))
        except Interrupted:
            raise KeyboardInterrupt from None


@contextmanager
def stopped_by_signals() -> Iterator[Event]:
    """An event that SIGINT and SIGTERM set, so that the nodes end in order."""
    stopped = Event()
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda *_: stopped.set()) for number in numbers]
    try:
        yield stopped
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


def as_results(recordings: Sequence[Recording]) -> Results:
    """Recordings as plain results."""
    results: Results = {"pushes": [asdict(recording.push) for recording in recordings]}
    for recording in recordings:
        results |= {f"{recording.push.mode}_{key}": getattr(recording, key) for key in RECORDED}
    return results


def recordings_of(results: Results) -> list[Recording]:
    """Recordings from plain results."""
    pushes = [Push(**entry) for entry in results["pushes"]]
    return [
        Recording(push, *(results[f"{push.mode}_{key}"] for key in RECORDED)) for push in pushes
    ]


def report(results: Results, given: Parameters) -> Report:
    """Behaviour of each controller; only mass control should leave the valves closed."""
    findings, told = [], []
    for recording in recordings_of(results):
        mode, count = recording.push.mode, len(recording.openings)
        opened, line, same = EXPECTED["mass" if mode == "mass" else "others"]
        pressure, volume = (
            1e-3 * looks(recording, recording.pressure),
            1e6 * looks(recording, recording.volume),
        )
        change, left = 1e6 * enclosed_changes(recording)
        shown = ", ".join(f"{value:.1f}" for value in pressure) + " kPa; "
        shown += ", ".join(f"{value:.2f}" for value in volume) + " cm3; "
        shown += f"pressed with {recording.pressed(recording.force):.2f} N"
        met = (count == 0) == (mode == "mass")
        more = f"{mode} control: more air than before, by pressure and shape"
        findings += [
            Finding(f"{mode} control: valve openings", opened, f"{count}", met, count),
            Finding(f"{mode} control: free, pressed, free again", line, shown),
            Finding(more, same, f"{change:+.2f} mg while pressed, {left:+.2f} mg after"),
        ]
        told.append(
            f"{mode} control opened a valve {count} times, {pressure[0]:.1f} to {pressure[1]:.1f} "
            f"kPa and {volume[0]:.2f} to {volume[1]:.2f} cm3, {change:+.2f} mg while pressed"
        )
    words = "; ".join(told)
    return Report(findings, f"{words[0].upper()}{words[1:]}.")


def looks(recording: Recording, values: Array) -> Array:
    """Means (3,) before the push, pressed, and after it."""
    return np.array([recording.before(values), recording.pressed(values), recording.after(values)])


def enclosed_changes(recording: Recording) -> Array:
    """Change of the enclosed air (2,) [kg], by pressure and shape: in the pressed finger, and after
    the push, relative to before; 0 under mass control.
    """
    before, pressed, after = looks(recording, recording.enclosed)
    return np.array([pressed - before, after - before])


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Pushes over lines of equal air mass as in Figs 4.1 and 4.2, and over time."""
    recordings = recordings_of(results)
    panels = figure.subplots(
        5, len(recordings), sharey="row", squeeze=False, height_ratios=(5, 2, 2, 2, 2)
    )
    for column, recording in enumerate(recordings):
        _draw_plane(panels[0, column], recording)
        _draw_recording(list(panels[1:, column]), recording)
    for panel in panels[0]:
        panel.set_xlim(*_span(np.concatenate([1e6 * recording.volume for recording in recordings])))
        _draw_lines(panel)
    for panel, label in zip(panels[:, 0], LABELS, strict=True):
        panel.set_ylabel(label)
    figure.supxlabel("grey: pressed; dotted: a valve opens", fontsize=9)


def _span(values: Array) -> tuple[float, float]:
    margin = 0.08 * float(np.ptp(values))
    return float(values.min()) - margin, float(values.max()) + margin


def _draw_plane(panel: Axes, recording: Recording) -> None:
    colour = COLOURS[recording.push.mode]
    volume, pressure = 1e6 * recording.volume, 1e-3 * recording.pressure
    panel.plot(volume, pressure, color=colour, linewidth=0.6, alpha=0.5)
    for word, look in (("free", recording.before), ("pressed", recording.pressed)):
        place = (1e6 * look(recording.volume), 1e-3 * look(recording.pressure))
        panel.plot(*place, "o", color=colour, markersize=6)
        panel.annotate(word, place, textcoords="offset points", xytext=(6, 4), fontsize=9)
    count = len(recording.openings)
    times = {0: "no valve opened", 1: "a valve opened once"}.get(count, f"{count} valve openings")
    panel.set_title(f"{recording.push.mode} control: {times}", fontsize=10)
    panel.set_xlabel("volume of the bent finger [cm3]")


def _draw_lines(panel: Axes) -> None:
    """Lines of equal air mass, on which the finger stays while its valves are closed (violet in
    Fig. 4.2).
    """
    low, high = panel.get_xlim()
    bottom, top = panel.get_ylim()
    volume = 1e-6 * np.linspace(low, high, 50)
    heat = GAS_CONSTANT * ROOM_TEMPERATURE
    least = (AMBIENT_PRESSURE + 1e3 * bottom) * volume[0] / heat
    most = (AMBIENT_PRESSURE + 1e3 * top) * volume[-1] / heat
    for mass in np.arange(least, most, LINE_SPACING):
        pressure = mass * heat / volume - AMBIENT_PRESSURE
        panel.plot(1e6 * volume, 1e-3 * pressure, color="0.8", linewidth=0.7, zorder=0)
    panel.set_xlim(low, high)
    panel.set_ylim(bottom, top)


def _draw_recording(panels: Sequence[Axes], recording: Recording) -> None:
    colour, push = COLOURS[recording.push.mode], recording.push
    rows = (
        1e-3 * recording.pressure,
        1e6 * recording.volume,
        1e6 * recording.mass,
        recording.force,
    )
    for panel, values in zip(panels, rows, strict=True):
        panel.axvspan(push.pressed - push.start, push.released - push.start, color="0.92")
        for opening in recording.openings:
            panel.axvline(opening, color="black", linewidth=0.8, linestyle=":")
        panel.plot(recording.time, values, color=colour, linewidth=1)
    middle = 1e6 * recording.before(recording.mass)
    span = max(AIR_SPAN, 1.1 * float(np.abs(1e6 * recording.mass - middle).max()))
    panels[AIR].set_ylim(middle - span, middle + span)
    panels[-1].set_xlabel("time [s]")
