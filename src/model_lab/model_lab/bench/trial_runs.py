"""Runs that could be measured next, within the limits of a set's test rig, with one change at a
time.

A change is another mount, a warmer room, another specimen of the set, or a new one with another
wall; for a hand, an orientation of the wrist that is not in the set. Another protocol or duration
does not count as a change.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model_lab.aliases import Array
from model_lab.bench.layouts import PUSHES, SAMPLES_A_RUN, held_columns, pulse_columns
from model_lab.bench.protocols import PROTOCOLS
from model_lab.measurements.hands import HAND_POSE
from model_lab.measurements.measurement_set import (
    INFLATE,
    MODES,
    MeasurementSet,
    Run,
    Specimen,
    down_of,
)
from model_lab.measurements.specimens import MOUNTS

SLOW_RAMP = "slow_ramp"  # which is called slow only if it is slower than all runs so far
SAME_PACE = 1.001
DURATION_FACTORS = (1.0, 3.0, 10.0, 30.0)  # durations over the shortest that the rate allows
LONGEST_FACTOR = 4.0  # of the longest run so far
USUAL_DURATION = 20.0  # [s] of a run by hand, where no time was recorded
FASTEST_RISE = {"uniaxial": 4.0, "rubber": 4.0}  # [s] from rest to the peak that any bench manages
USUAL_RISE = 1.0
TEMPERATURE_STEP = 20.0  # [K]
WALL_FACTOR = 1.6  # wall of another specimen
THICKEST_WALL = 0.9  # of half the height
LENGTH_FACTOR = 0.6  # length of another specimen
PLANNED_HELD_SAMPLES, HELD_PEAKS = 60, (1.0, 0.5)
PROTOCOL_SEED = 0  # of the pulses
LEAST_SUPPLY = 120e3  # [Pa] absolute, with which a channel can be filled a little
RIGHT_ANGLE = float(np.pi / 2.0)
WRIST_ATTITUDES = {  # roll, pitch, yaw [rad] of the wrist of the shipped hands
    "fingers up": (0.0, 0.0, 0.0),
    "palm down": (0.0, RIGHT_ANGLE, 0.0),
    "palm up": (0.0, -RIGHT_ANGLE, 0.0),
    "thumb up": (-RIGHT_ANGLE, 0.0, 0.0),
    "thumb down": (RIGHT_ANGLE, 0.0, 0.0),
    "fingers down": (2.0 * RIGHT_ANGLE, 0.0, 0.0),
}
POSE_STEPS = (0.0, 0.25, 0.5, 0.75, 1.0)  # pressures of a gesture over the highest
ATTITUDE_APART = 0.3  # between directions of gravity: 17 deg, chosen by hand


@dataclass(frozen=True)
class TrialRun:
    """A run that could be measured.

    columns (samples,): its inputs, in SI units by name. temperature [K]. specimen: as it would be
    mounted. changes: what is new besides the protocol, in words. mode: in which rubber is
    stretched, else "". wrist_rpy (3,) [rad]: how the wrist of a hand is held.
    """

    protocol: str
    description: str
    specimen: Specimen
    temperature: float
    columns: Mapping[str, Array]
    changes: tuple[str, ...] = ()
    mode: str = ""
    wrist_rpy: tuple[float, ...] = (0.0, 0.0, 0.0)


def trial_runs(data: MeasurementSet, base: str) -> list[TrialRun]:
    """Runs of the same experiment as the set that could be measured, within its range of pressures.
    base: name of the base model.
    """
    if data.of_hand:
        return list(_gestures(data)) if data.experiment == HAND_POSE else []
    if data.experiment == "valve_pulse":
        return list(_pulses(data))
    if data.experiment == "base_torque":
        return list(_held(data))
    if data.experiment == "rubber":
        return [trial for mode in MODES for trial in _in_mode(data, base, mode)]
    return list(_driven(data, base))


# ---------------------------------------------------------------------- one driven input
def _in_mode(data: MeasurementSet, base: str, mode: str) -> Iterator[TrialRun]:
    """Stretches of rubber in a mode: as far as it was stretched in it, or as in the least one."""
    same = tuple(run for run in data.runs if run.mode == mode)
    least = min(data.runs, key=lambda run: abs(_peak([run], "stretch", 1.0)))
    words = () if same else (f"stretched in {mode.replace('_', ' ')}",)
    for trial in _driven(replace(data, runs=same or (least,)), base):
        yield replace(trial, mode=mode, changes=(*trial.changes, *words))


def _peak(runs: Iterable[Run], driving: str, rest: float) -> float:
    """Where the input went furthest from rest, less that."""
    ways = [run.columns[driving] - rest for run in runs]
    return max((float(way[np.argmax(np.abs(way))]) for way in ways), key=abs)


def _driven(data: MeasurementSet, base: str) -> Iterator[TrialRun]:
    driving = "stretch" if data.stretched else "pressure"
    rest = 1.0 if data.stretched else 0.0
    peak = _peak(data.runs, driving, rest)
    courses = [
        (protocol, {"time": time, driving: rest + course})
        for protocol in PROTOCOLS
        for duration in _durations(data, protocol.fastest() * abs(peak), abs(peak), driving)
        for time, course in [protocol.course(duration, peak, SAMPLES_A_RUN)]
    ]
    slowest = _slowest(data, driving)
    for specimen, temperature, changes in _settings(data, base):
        for protocol, columns in courses:
            name, words = protocol.name, protocol.description
            pace = protocol.fastest() * abs(peak) / columns["time"][-1]
            if name == SLOW_RAMP and pace > SAME_PACE * slowest:
                name, words = "ramp", "one ramp up and down"
            yield TrialRun(name, words, specimen, temperature, columns, changes)


def _durations(data: MeasurementSet, steepest: float, peak: float, driving: str) -> list[float]:
    """Durations [s] of a protocol whose largest rate is `steepest` over its duration."""
    if not data.has_time:
        return [USUAL_DURATION]
    longest = max(float(np.ptp(run.columns["time"])) for run in data.runs)
    rise = FASTEST_RISE.get(data.experiment, USUAL_RISE)
    shortest = steepest / max(peak / rise, _fastest(data, driving, longest / 50.0))
    return [shortest] + [
        shortest * factor
        for factor in DURATION_FACTORS[1:]
        if shortest * factor <= LONGEST_FACTOR * longest
    ]


def _fastest(data: MeasurementSet, driving: str, window: float) -> float:
    """Largest rate of the input over a window [s]."""
    return max(_rates(data, driving, window))


def _slowest(data: MeasurementSet, driving: str) -> float:
    """Largest rate of the input in the run in which that is least."""
    if not data.has_time:
        return np.inf
    longest = max(float(np.ptp(run.columns["time"])) for run in data.runs)
    return min(_rates(data, driving, longest / 50.0))


def _rates(data: MeasurementSet, driving: str, window: float) -> list[float]:
    """Largest rate of the input over a window [s] in each run."""
    changes = [
        np.abs(np.interp(run.columns["time"] + window, run.columns["time"], values) - values)
        for run in data.runs
        for values in [run.columns[driving]]
    ]
    return [float(change.max()) / window for change in changes]


def _settings(data: MeasurementSet, base: str) -> Iterator[tuple[Specimen, float, tuple[str, ...]]]:
    """Specimens, temperatures, and what is new about them."""
    usual = Counter(run.temperature for run in data.runs).most_common(1)[0][0]
    used = [data.specimens[name] for name in dict.fromkeys(run.specimen for run in data.runs)]
    first = used[0]
    for specimen in _unlike(used):
        yield specimen, usual, ()
    yield first, usual + TEMPERATURE_STEP, (f"{TEMPERATURE_STEP:g} K warmer",)
    if data.experiment == "free_bending" and "mass" in first.values and base == "pneuflex":
        seen = {specimen.mount for specimen in used}
        for mount in (mount for mount in MOUNTS if mount not in seen):
            named = f"{first.name}_{mount}"
            words = f"mounted {mount.replace('_', ' ')}"
            yield replace(first, name=named, mount=mount), usual, (words,)
    if not data.stretched and base == "pneuflex":
        yield from ((other, usual, words) for other, words in _other_wall(used))
    if data.experiment == "blocked_tip" and base == "pneuflex":
        yield from ((other, usual, words) for other, words in _other_length(used))


def _unlike(specimens: list[Specimen]) -> list[Specimen]:
    """At most four specimens, each with another mount or other sizes."""
    found: dict[tuple, Specimen] = {}
    for specimen in specimens:
        sizes = tuple((key, np.asarray(v).tobytes()) for key, v in specimen.values.items())
        found.setdefault((specimen.mount, sizes), specimen)
    return list(found.values())[:4]


def _other_wall(used: list[Specimen]) -> Iterator[tuple[Specimen, tuple[str, ...]]]:
    """A new specimen of another wall, where the set has only one."""
    walls = {specimen.mean_wall for specimen in used}
    first, wall = used[0], next(iter(walls))
    if len(walls) > 1 or not np.isfinite(wall) or np.ndim(first.values["wall"]):
        return
    height = float(np.min(np.reshape(first.values["height"], (-1, 1))[:, -1]))
    most = THICKEST_WALL * height / 2.0
    other = min(WALL_FACTOR * wall, most) if WALL_FACTOR * wall < 1.2 * most else wall / WALL_FACTOR
    values = {**first.values, "wall": other}
    words = f"another specimen, like {first.name} with a wall of {1e3 * other:.3g} mm"
    yield replace(first, name=f"{first.name}_wall_{1e3 * other:.3g}_mm", values=values), (words,)


def _other_length(used: list[Specimen]) -> Iterator[tuple[Specimen, tuple[str, ...]]]:
    """A new specimen that is shorter, where the set has only one length: its blocked tip pushes
    harder at the same pressure.
    """
    first = used[0]
    if len({float(s.values["length"]) for s in used}) > 1 or any(
        map(np.ndim, first.values.values())
    ):
        return
    length = LENGTH_FACTOR * float(first.values["length"])
    values = {**first.values, "length": length}
    if "mass" in values:
        values["mass"] = LENGTH_FACTOR * values["mass"]
    words = f"another specimen, like {first.name} but {1e3 * length:.3g} mm long"
    yield replace(first, name=f"{first.name}_{1e3 * length:.3g}_mm_long", values=values), (words,)


# ---------------------------------------------------------------------- held tips
def _held(data: MeasurementSet) -> Iterator[TrialRun]:
    first = data.specimens[data.runs[0].specimen]
    if any(np.ndim(value) for value in first.values.values()):
        return  # the poses of `held_columns` are those of a uniform actuator
    usual = Counter(run.temperature for run in data.runs).most_common(1)[0][0]
    peak = max(float(run.columns["pressure"].max()) for run in data.runs)
    longest = max(float(np.ptp(run.columns["time"])) for run in data.runs)
    for protocol in PUSHES:
        for share in HELD_PEAKS:
            columns = held_columns(first, protocol, share * peak, longest, PLANNED_HELD_SAMPLES)
            words = f"tip {protocol.replace('_', ' ')}, up to {share:g} of the pressure so far"
            yield TrialRun(protocol, words, first, usual, columns)


# ---------------------------------------------------------------------- pulses
def _pulses(data: MeasurementSet) -> Iterator[TrialRun]:
    first, usual = data.specimens[data.runs[0].specimen], data.runs[0].temperature
    joined = {
        name: np.concatenate([run.columns[name] for run in data.runs])
        for name in ("direction", "duration", "p_in")
    }
    inflating = joined["direction"] == INFLATE
    if not inflating.any():
        return
    supplies = np.unique(np.round(joined["p_in"][inflating], -3))[[0, -1]].tolist()
    durations = joined["duration"][inflating]
    low, high = float(durations.min()), float(durations.max())
    middle = float(np.sqrt(low * high))
    random = np.random.default_rng(PROTOCOL_SEED)
    for supply in dict.fromkeys([supplies[0], supplies[1], 0.75 * supplies[0]]):
        if supply < LEAST_SUPPLY:
            continue
        for name, length in {"short": (low, middle), "long": (middle, high)}.items():
            words = (
                f"{name} pulses both ways, each from a pressure of its own, at a supply of "
                f"{supply / 1e3:.0f} kPa absolute"
            )
            yield TrialRun(
                f"{name}_pulses", words, first, usual, pulse_columns(supply, length, random)
            )


# ---------------------------------------------------------------------- poses of a hand
def _gestures(data: MeasurementSet) -> Iterator[TrialRun]:
    """Channels filled together, in turn, each alone, or one alone in steps, up to the highest share
    of their limits so far, with the wrist in each of WRIST_ATTITUDES. None where the frame of the
    markers is free: how it moves with the explanation is not known.
    """
    if data.free_frame:
        return
    first, usual = data.specimens[data.runs[0].specimen], data.runs[0].temperature
    limits = data.hand.max_pressures()
    highest = [max(float(np.max(run.columns[c])) for run in data.runs) for c in data.pressures]
    peaks = float(np.max(np.array(highest) / limits)) * limits
    held = [down_of(run) for run in data.runs]
    for attitude, rpy in WRIST_ATTITUDES.items():
        down = down_of(replace(data.runs[0], wrist_rpy=rpy))
        known = any(np.linalg.norm(down - other) < ATTITUDE_APART for other in held)
        changes = () if known else (f"the wrist turned: {attitude}",)
        for name, shares in _filled(data.hand.channels):
            columns = dict(zip(data.pressures, (shares * peaks).T, strict=True))
            protocol = f"{name}_{attitude}".replace(" ", "_")
            words = f"{name}, {attitude}"
            yield TrialRun(protocol, words, first, usual, columns, changes, wrist_rpy=rpy)


def _filled(channels: Sequence[str]) -> Iterator[tuple[str, Array]]:
    """Gestures by name: pressures (poses, channels) over the highest, the first pose empty."""
    empty, alone = np.zeros((1, len(channels))), np.eye(len(channels))
    steps = np.array(POSE_STEPS)[:, None]
    yield "each channel alone", np.vstack([empty, alone])
    yield "channels one after the other", np.vstack([empty, np.tri(len(channels))])
    yield "all channels in steps", steps * np.ones(len(channels))
    for name, shares in zip(channels, alone, strict=True):
        yield f"channel {name} alone in steps", steps * shares


def run_of(trial: TrialRun, name: str, outputs: tuple[str, ...]) -> Run:
    """The trial as a run with zero outputs."""
    samples = len(next(iter(trial.columns.values())))
    zeros = {output: np.zeros(samples) for output in outputs}
    columns = {**trial.columns, **zeros}
    return Run(
        name,
        trial.specimen.name,
        name,
        trial.temperature,
        columns,
        mode=trial.mode,
        wrist_rpy=trial.wrist_rpy,
    )
