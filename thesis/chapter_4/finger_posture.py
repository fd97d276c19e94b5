"""Posture of four fingers before and after a minute of sinusoidal motion (Fig. 4.10).

The thesis: two fingers return, two deviate slightly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pneumaticbox_driver.backends.embedded import EmbeddedRig
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.observer.coefficients import ChannelCalibration
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.chain.chain import ChainModel, discretise
from softhand_model.chain.volumes import FreeVolumes
from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model
from softhand_model.pneumatics import Pneumatics
from thesis.chapter_4 import CHANNELS, MG, SEED, THESIS_LINE
from thesis.chapter_4.boxes import OUTLETS, SUPPLIES, box_of, calibrated
from thesis.chapter_4.rig_run import RigRun, Sine, final_drift, pulses_in_sine
from thesis.frame import Array, Axes, Figure, Job, Report, Results, number, option

NAMES = ("index", "middle", "ring", "little")
SIZE = (8.5, 4.2)
SLIGHT = 10.0  # a deviation that shows in a picture [deg]
HAND, CHAIN = "single_finger", "finger"
SEGMENTS = 20  # of the drawn finger
BEND = 1  # index of the bending axis (y)
SMALL = {"duration": 2.0, "period": 2.0, "points": 24}


class Fingers:
    """`count` equal fingers without contact, one per channel; pressures are gauge (n,) [Pa].

    Used as the plant's chambers (`volumes` of absolute pressures, through `chambers`) and, in the
    driver, as the model of a channel's volume.

    >>> fingers = Fingers(2)
    >>> (1e6 * fingers.volumes(np.array([0.0, 30e3]))).round(1).tolist()
    [18.8, 24.5]
    """

    def __init__(self, count: int) -> None:
        self.hand = load_hand(HAND)
        self._free = FreeVolumes(self.hand)
        self.rest: Array = np.repeat(self._free.rest, count)
        self.limit = float(self.hand.max_pressures()[0])

    def volumes(self, gauge: Array) -> Array:
        """Volumes with tubes (n,) [m3]."""
        return np.array([self._free.volumes(p)[0] for p in gauge[:, None]])

    def slopes(self, gauge: Array) -> Array:
        """Derivatives of the volumes by the pressures (n,) [m3/Pa]."""
        return np.array([self._free.slopes(p)[0] for p in gauge[:, None]])

    def mass(self, gauge: Array) -> Array:
        """Air above the fill at rest (n,) [kg]."""
        rest = air_mass(AMBIENT_PRESSURE, self.rest)
        return np.asarray(air_mass(gauge + AMBIENT_PRESSURE, self.volumes(gauge)) - rest)

    @cached_property
    def _chain(self) -> ChainModel:
        return discretise(self.hand.chain(CHAIN), SEGMENTS, Model())

    def bends(self, gauge: float) -> Array:
        """Angle of the tangent against the base along the finger (SEGMENTS + 1,) [rad]."""
        joints = self._chain.rest_rotation([max(gauge, 0.0)])[:, BEND]
        return np.concatenate([[0.0], np.cumsum(joints)])

    def tip_angles(self, gauge: Array) -> Array:
        """Angles of the tips against the bases (n,) [rad]."""
        return np.array([self.bends(p)[-1] for p in gauge])

    @property
    def length(self) -> float:
        """Length of a finger [m]."""
        return next(iter(self.hand.chain(CHAIN).actuators.values())).length


class _AtPressures:
    """The fingers as chambers of the plant, which knows absolute pressures."""

    def __init__(self, fingers: Fingers) -> None:
        self._fingers = fingers

    def volumes(self, pressures_abs: Array) -> Array:
        """Volumes (n,) [m3] at absolute pressures (n,) [Pa]."""
        return self._fingers.volumes(pressures_abs - AMBIENT_PRESSURE)


def on_fingers(
    fingers: Fingers,
    constants: Pneumatics,
    calibrations: Sequence[ChannelCalibration],
    seed: int,
    drift_correction: bool = False,
    sensor_offset: float = 0.0,
) -> RigRun:
    """A run in mass control with a finger on each channel, tared once, at its start.

    Args:
        fingers: one per channel.
        constants: of the plant.
        calibrations: one per channel.
        seed: of noise and jitter.
        drift_correction: whether the box weighs the fingers by pressure and volume when they are
            still.
        sensor_offset: that the channels' sensors have besides their own errors [Pa].
    """
    n = len(calibrations)
    settings = BoxSettings(
        tuple(OUTLETS[:n]), tuple(fingers.rest.tolist()), (fingers.limit,) * n, ("mass",) * n
    )
    box = PneumaticBox(settings, calibrations, fingers)
    box.zeroing.drift_correction = drift_correction
    rig = EmbeddedRig(OUTLETS[:n], _AtPressures(fingers), constants, seed)
    return RigRun(box, rig, fingers.mass, sensor_offset)


@dataclass(frozen=True)
class Parameters(Sine):
    """Options of the experiment."""

    seed: int = option(0, SEED)
    mean: float = option(10e-6, "mean air mass of the sine above the fill at rest [kg]")
    amplitude: float = option(6e-6, "amplitude of the sine [kg]")
    period: float = option(6.0, "period of the sine [s]")
    fill: float = option(4.0, "time to fill the fingers to where the sine starts [s]")
    points: int = option(1600, "calibration pulses per channel, both directions together [-]")
    correct: int = option(0, "1 corrects the drift by pressure and volume of still fingers [-]")


def run(given: Parameters, job: Job) -> Results:
    """Calibrate a box, let four fingers follow the sine; how they bend before and after."""
    box, fingers = box_of(given.seed), Fingers(len(NAMES))
    own = calibrated(box, len(NAMES), given.points, given.seed, job.progress, SUPPLIES)
    run = on_fingers(fingers, box, own, given.seed, bool(given.correct))
    results = run.follow(given, job.progress)
    true_gauge = run.rig.plant.pressures - box.ambient_pressure
    start = int(np.searchsorted(results["time"], given.fill))
    before = [_gauge_of(fingers, mass) for mass in results["truth"][start].tolist()]
    return {
        **results,
        "bend_before": np.array([fingers.bends(p) for p in before]),
        "bend_after": np.array([fingers.bends(p) for p in true_gauge]),
        "length": np.array([fingers.length]),
    }


def _gauge_of(fingers: Fingers, mass: float) -> float:
    """Gauge pressure at which a finger holds this air above rest [Pa], by bisection."""
    low, high = 0.0, 2 * fingers.limit
    for _ in range(50):
        middle = 0.5 * (low + high)
        n = len(fingers.rest)
        low, high = (middle, high) if fingers.mass(np.full(n, middle))[0] < mass else (low, middle)
    return low


def report(results: Results, given: Parameters) -> Report:
    """Deviation of the tip angles from those before the motion, drift and pulses."""
    before, after = (np.degrees(results[f"bend_{k}"][:, -1]) for k in ("before", "after"))
    off = after - before
    drifts = final_drift(results) / MG
    findings = [number("tip angle before, mean of the fingers", float(before.mean()), "deg")]
    for k, name in enumerate(NAMES):
        findings.append(number(f"{name}: deviation of the tip angle", float(off[k]), "deg"))
        findings.append(number(f"{name}: drift of the air mass", float(drifts[k]), "mg"))
    returned = int((np.abs(off) < SLIGHT).sum())
    pulses = float(np.median(pulses_in_sine(results, given)))
    findings += [
        number("fingers that return within 10 deg", returned, "", "2 of 4, two slightly off"),
        number("pulses per finger, median", pulses, ""),
    ]
    conclusion = (
        f"After {given.duration:g} s and {pulses:.0f} pulses {returned} of 4 fingers stand "
        f"within 10 deg of where they began, the worst is {np.abs(off).max():.1f} deg off (thesis: "
        "two return, two deviate slightly)."
    )
    return Report(findings, conclusion)


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Side views of the fingers before and after, and their air over time."""
    places = figure.subplot_mosaic([[*NAMES], ["mass"] * 4], height_ratios=(1.3, 1))
    length = 1e3 * float(results["length"][0])
    for k, name in enumerate(NAMES):
        panel = places[name]
        for when, style in (
            ("before", {"color": THESIS_LINE, "lw": 5, "alpha": 0.6}),
            ("after", {"color": CHANNELS[k], "lw": 2}),
        ):
            panel.plot(*_side_view(results[f"bend_{when}"][k], length), label=when, **style)
        panel.set(title=name, aspect="equal", xlim=(-0.35 * length, 0.75 * length))
        panel.set(ylim=(-0.05 * length, 1.05 * length), xlabel="[mm]")
    places[NAMES[0]].set_ylabel("[mm]")
    places[NAMES[0]].legend(loc="lower right", fontsize=7)
    _draw_masses(places["mass"], results)


def _side_view(bends: Array, length: float) -> tuple[Array, Array]:
    """Centre line of a finger that points up, from its base (2, points) [as length]."""
    middle = 0.5 * (bends[1:] + bends[:-1])
    step = length / len(middle)
    start = np.zeros(1)
    across = np.concatenate([start, np.cumsum(step * np.sin(middle))])
    along = np.concatenate([start, np.cumsum(step * np.cos(middle))])
    return across, along


def _draw_masses(panel: Axes, results: Results) -> None:
    panel.plot(results["time"], results["target"] / MG, color="#333333", lw=0.8, label="target")
    for k, name in enumerate(NAMES):
        panel.plot(
            results["time"], results["truth"][:, k] / MG, color=CHANNELS[k], lw=0.8, label=name
        )
    panel.set(xlabel="time [s]", ylabel="true air mass [mg]")
    panel.legend(ncols=5, loc="lower center", bbox_to_anchor=(0.5, 1.0))
