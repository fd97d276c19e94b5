"""Mass moved by single pulses: full model against baseline and ground truth (Fig. 4.6).

The thesis: the full model's error is about 7 times smaller in deflation.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.calibration.recording import AVERAGING
from pneumaticbox_driver.calibration.regression import Pulse, fit_channel, regressors
from pneumaticbox_driver.observer.coefficients import ChannelCalibration
from softhand_model.gas import air_mass
from softhand_model.pneumatics import Pneumatics
from thesis.chapter_4 import FULL, MG, OTHER, SEED, TARGET, THESIS_LINE, rms
from thesis.chapter_4.boxes import BOTTLE, OUTLETS, PERIOD, box_of, record
from thesis.frame import Array, Axes, Figure, Job, Report, Results, number, option

DIRECTIONS = {"inflation": 1.0, "deflation": 0.0}
SIZE = (8.5, 6.4)
RATIO = 7.0  # of the thesis
WINDOWS = 100  # of averaged readings, from which their noise is taken
SMALL = {"points": 32, "tests": 16, "channels": 1}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    seed: int = option(0, SEED)
    points: int = option(400, "calibration pulses per channel, both directions together [-]")
    tests: int = option(200, "pulses per channel that no calibration has seen [-]")
    channels: int = option(4, "outlets of the box [-]")
    supplies: tuple[float, ...] = option(
        (260e3, 320e3), "supply pressures of the calibration [Pa gauge]"
    )
    tested: tuple[float, ...] = option(
        (275e3, 305e3), "supply pressures of the pulses to predict [Pa gauge]"
    )


def run(given: Parameters, job: Job) -> Results:
    """Calibrate a box, then predict other pulses of it; a row a pulse."""
    return on_box(box_of(given.seed), given, job)


def on_box(box: Pneumatics, given: Parameters, job: Job) -> Results:
    """The same with a box of other constants."""
    n = given.channels
    known = record(box, n, given.points, given.supplies, 2 * given.seed, job.progress)
    fresh = record(box, n, given.tests, given.tested, 2 * given.seed + 1, job.progress)
    columns = [_columns(k, known[k], fresh[k]) for k in range(n)]
    results = {name: np.concatenate([c[name] for c in columns]) for name in columns[0]}
    results["floor"] = floor_of(box, n, given.seed)
    return results


def _columns(channel: int, known: Sequence[Pulse], fresh: Sequence[Pulse]) -> Results:
    full = predicted(fit_channel(known), fresh)
    mass = np.array([pulse.mass for pulse in fresh])
    return {
        "channel": np.full(len(fresh), float(channel)),
        "inflating": np.array([float(pulse.inflating) for pulse in fresh]),
        "mass": mass,
        "full": full,
        "baseline": baseline(known, fresh),
    }


def predicted(calibration: ChannelCalibration, pulses: Sequence[Pulse]) -> Array:
    """Mass that equation 4.1 has each pulse move (pulses,) [kg]."""
    inflating = np.array([[pulse.inflating] for pulse in pulses])
    up, down = calibration.inflate.as_array(), calibration.deflate.as_array()
    return np.asarray((regressors(pulses) * np.where(inflating, up, down)).sum(axis=1))


def baseline(known: Sequence[Pulse], pulses: Sequence[Pulse]) -> Array:
    """Mass of each pulse by `c p_in(t_on) dt` (section 4.4.3), `c` fitted over `known` [kg]."""
    result = np.zeros(len(pulses))
    for inflating in (True, False):
        learned = [pulse for pulse in known if pulse.inflating == inflating]
        size, mass = _naive_size(learned), np.array([pulse.mass for pulse in learned])
        share = size @ mass / (size @ size)
        here = np.array([pulse.inflating == inflating for pulse in pulses])
        result = np.where(here, share * _naive_size(pulses), result)
    return result


def _naive_size(pulses: Sequence[Pulse]) -> Array:
    return np.array([pulse.pressure_in_abs * pulse.duration for pulse in pulses])


def floor_of(box: Pneumatics, channels: int, seed: int) -> Array:
    """Standard deviation of the ground truth due to sensor noise, per channel (channels,) [kg].

    Computed as `dp V/(R T)` over pulses that move no air, with each pressure averaged as for a test
    pulse.
    """
    rig = EmbeddedRig(OUTLETS[:channels], np.full(channels, BOTTLE), box, seed)
    count = round(AVERAGING / PERIOD)
    means = []
    for _ in range(WINDOWS + 1):
        rig.command(np.zeros(channels))
        means.append(np.mean([rig.advance(PERIOD)[:-1] for _ in range(count)], axis=0))
    return np.asarray(rms(air_mass(np.diff(means, axis=0), BOTTLE), axis=0))


def report(results: Results, given: Parameters) -> Report:
    """RMS errors of both models per direction, their ratio and that to the noise."""
    floor = float(rms(results["floor"])) / MG
    findings = [number("noise of the ground truth", floor, "mg")]
    for name, inflating in DIRECTIONS.items():
        here = results["inflating"] == inflating
        full, naive = (
            float(rms((results[m] - results["mass"])[here])) for m in ("full", "baseline")
        )
        thesis = f"about {RATIO:.0f}" if name == "deflation" else "almost as good"
        findings += [
            number(f"{name}: RMS error, baseline", naive / MG, "mg"),
            number(f"{name}: RMS error, full model", full / MG, "mg"),
            number(f"{name}: baseline / full model", naive / full, "", thesis),
            number(f"{name}: full model / noise", full / MG / floor, ""),
        ]
    made = Report(tuple(findings), "")
    ratio, noise = made["deflation: baseline / full model"], made["deflation: full model / noise"]
    conclusion = (
        f"Deflation is predicted {ratio:.1f} times better than by the baseline (thesis: about 7), "
        f"{noise:.2f} times the sensors' noise."
    )
    return Report(made.findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Predicted over measured mass, and errors over measured mass, as in Fig. 4.6."""
    axes = figure.subplots(2, 2)
    for column, (name, inflating) in enumerate(DIRECTIONS.items()):
        here = results["inflating"] == inflating
        mass = results["mass"][here] / MG
        top, bottom = axes[0, column], axes[1, column]
        top.plot([0, mass.max()], [0, mass.max()], color=TARGET, lw=0.8)
        for model, colour, marker in (("baseline", OTHER, "x"), ("full", FULL, ".")):
            value = results[model][here] / MG
            label = "full model" if model == "full" else model
            style = {"color": colour, "marker": marker, "ls": "", "ms": 4, "alpha": 0.7}
            top.plot(mass, value, label=label, **style)
            bottom.plot(mass, value - mass, **style)
        _draw_bands(bottom, name, report)
        top.set(title=name, xlabel="mass moved [mg]", ylabel="predicted [mg]")
        bottom.set(xlabel="mass moved [mg]", ylabel="error [mg]")
    axes[0, 0].legend()


def _draw_bands(axes: Axes, name: str, report: Report) -> None:
    naive = report[f"{name}: RMS error, baseline"]
    noise = report["noise of the ground truth"]
    for sign in (-1, 1):
        axes.axhline(sign * naive / RATIO, color=THESIS_LINE, lw=1.0)
        axes.axhline(sign * noise, color=THESIS_LINE, lw=0.8, ls=":")
    words = "grey: RMS of the baseline / 7 (thesis); dotted: noise of the truth"
    axes.set_title(words, fontsize=7.5, color="#555555")
