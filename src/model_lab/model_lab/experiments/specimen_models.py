"""Models of the specimens of a set: sections, segment chains, and their memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.samples import SampleRows, Step
from model_lab.measurements.measurement_set import MeasurementSet, Specimen
from model_lab.measurements.specimens import require_keys
from softhand_model.bending.loaded_finger import running_integral
from softhand_model.chain.segments import SegmentChain, cut_chain
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import SectionShape
from softhand_model.effects.whole_runs import LONG
from softhand_model.hand import section
from softhand_model.hand.actuator import PROFILES, Actuator
from softhand_model.hand.hand import ChainDescription, Mount
from softhand_model.hand.joint_stiffness import THESIS, SpringModel
from softhand_model.hand.profile import ConstantProfile, Profile, TableProfile

Entry = tuple[str, str]  # name of an effect and of what it keeps
Largest = Mapping[Entry, Array]
"""Largest values (lanes, runs, sections) so far."""

PASSES = 3  # over all runs, until these values agree at ends and starts
UNCHANGED = 1e-9
GAUSS_POINTS = 8  # Gauss points of a size that changes in one straight line, or of a given number
GAUSS_POINTS_A_PIECE = 3  # of a size that changes in several
SPECIMEN_KEYS = ("length", "height", "width", "wall", "side_wall", "shear_modulus")
GAUSS_POINTS_A_SEGMENT = 4  # Gauss points on each segment of an actuator whose section varies


# ---------------------------------------------------------------------- what they remember
class SpecimenMemory:
    """Steps through the runs of a set, where specimens carry their largest values over to later
    runs.

    All runs are stepped at the same time. So the values with which a run starts are first taken
    from the peaks of the inputs of earlier runs, and corrected in further passes if these differ in
    time.
    """

    def __init__(self, rows: SampleRows) -> None:
        self._rows = rows
        self.runs = rows.runs
        self._before = rows.runs.before.tolist()

    def in_steps(self, begin: Callable[[], Step], staged: StagedEffects, values: Array) -> Array:
        """Outputs (lanes, rows, 1) for inputs (lanes, rows, 1). begin: resets the memory and
        returns the step function.
        """
        kept = {
            (effect.name, key): virgin
            for effect in staged.elastic
            for key, virgin in effect.largest.items()
        }
        if not kept:
            return self._rows.in_steps(begin(), values)
        begin()(self._rows.peaks(values), np.full((len(self._before), 1), LONG))
        carried = self._carried(_largest(staged, kept), kept)
        for _ in range(PASSES):
            outputs = self._pass(begin, staged, values, carried)
            guessed, carried = carried, self._carried(_largest(staged, kept), kept)
            if all(np.all(np.abs(carried[k] - guessed[k]) <= UNCHANGED) for k in carried):
                break
        return outputs

    def _pass(
        self, begin: Callable[[], Step], staged: StagedEffects, values: Array, carried: Largest
    ) -> Array:
        step = begin()
        for (name, key), value in carried.items():
            staged.memory[name][key] = value
        return self._rows.in_steps(step, values)

    def _carried(self, ends: Largest, virgin: Mapping[Entry, float]) -> Largest:
        """What runs start with, given what they end with and what a virgin specimen has."""
        starts = {}
        for key, end in ends.items():
            start = np.full_like(end, virgin[key])
            for run, before in enumerate(self._before):
                if before >= 0:
                    start[:, run] = np.maximum(start[:, before], end[:, before])
            starts[key] = start
        return starts


def _largest(staged: StagedEffects, kept: Iterable[Entry]) -> Largest:
    return {(name, key): np.asarray(staged.memory[name][key]) for name, key in kept}


# ---------------------------------------------------------------------- sections
class SpecimenSections:
    """Sections along the specimen of each run; arrays are (1, runs, sections).

    Args:
        data: the measurement set.
        uniform: whether one section is enough for a specimen of constant height, width and walls.

    Attributes: x, weight [m], Gauss points from the base and their weights (0 where a specimen has
    fewer points than others); length (1, runs, 1) [m]; shape, with the nominal shear modulus;
    running (runs, sections, sections) [m], weights of integrals from the base to each point.

    Raises DocumentError for a specimen without the keys of SPECIMEN_KEYS.
    """

    def __init__(self, data: MeasurementSet, uniform: bool) -> None:
        names = dict.fromkeys(run.specimen for run in data.runs)
        for name in names:
            require_keys(
                data, data.specimens[name], SPECIMEN_KEYS, f"the model of {data.experiment}"
            )
        rules = {name: _rule(data.specimens[name], uniform) for name in names}
        longest = max(len(rule.x) for rule in rules.values())
        runs = [data.specimens[run.specimen] for run in data.runs]
        padded = [rules[run.name].padded(longest) for run in runs]
        self.x = np.array([rule.x for rule in padded])[None]
        self.weight = np.array([rule.weight for rule in padded])[None]
        self.running = np.array([rule.running for rule in padded])
        self.length = numbers(runs, "length")
        self.shape = self._shape(runs)

    def _shape(self, runs: list[Specimen]) -> SectionShape:
        height, width = (self._along(runs, key) for key in ("height", "width"))
        wall, side_wall = (
            self._along(runs, key)
            if any(np.ndim(run.values[key]) for run in runs)
            else numbers(runs, key)
            for key in ("wall", "side_wall")
        )
        ratio = section.side_wall_ratio(height, width, wall, side_wall)
        return SectionShape(height, width, wall, side_wall, ratio, numbers(runs, "shear_modulus"))

    def _along(self, runs: list[Specimen], key: str) -> Array:
        """A size (1, runs, sections) [m] of each run's specimen."""
        return np.array([_at(run, key, x) for run, x in zip(runs, self.x[0], strict=True)])[None]


def numbers(specimens: list[Specimen], key: str) -> Array:
    """The value (1, specimens, 1) of a key of each specimen."""
    return np.array([specimen.values[key] for specimen in specimens], float)[None, :, None]


def circumference(data: MeasurementSet, sections: SpecimenSections) -> Array:
    """Circumference (1, runs, sections) [m]: as the specimen states it, else that of the rectangle
    of height and width.
    """
    around = 2.0 * (sections.shape.height + sections.shape.width)
    for row, run in enumerate(data.runs):
        specimen = data.specimens[run.specimen]
        if "circumference" in specimen.values:
            around[0, row] = _at(specimen, "circumference", sections.x[0, row])
    return around


def _at(specimen: Specimen, key: str, x: Array) -> Array:
    """A size [m] at x [m]: a number, or straight lines between points."""
    size = specimen.values[key]
    if np.ndim(size) == 0:
        return np.full_like(x, size)
    return np.interp(x, *np.asarray(size).T)


@dataclass(frozen=True)
class _Rule:
    """Gauss points and weights (n,) [m], and integrals (n, n) [m] from the base to each point."""

    x: Array
    weight: Array
    running: Array

    def padded(self, count: int) -> _Rule:
        """The rule with more points that weigh nothing."""
        more = count - len(self.x)
        if not more:
            return self
        return _Rule(
            np.append(self.x, np.repeat(self.x[-1:], more)),
            np.append(self.weight, np.zeros(more)),
            np.pad(self.running, (0, more)),
        )


def _rule(specimen: Specimen, uniform: bool) -> _Rule:
    """The rule on the pieces between the corners of the section's sizes."""
    length = float(specimen.values["length"])
    sizes = [np.asarray(specimen.values[key]) for key in PROFILES]
    if uniform and all(size.ndim == 0 for size in sizes):
        middle = np.array([0.5 * length])
        return _Rule(middle, np.array([length]), middle[:, None])
    corners = np.concatenate([[0.0, length], *(size[:, 0] for size in sizes if size.ndim)])
    edges = np.unique(np.clip(corners, 0.0, length))
    count = max(GAUSS_POINTS_A_PIECE, -(-GAUSS_POINTS // (len(edges) - 1)))
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half = np.diff(edges)[:, None] / 2.0
    x = edges[:-1, None] + half * (nodes + 1.0)
    return _Rule(x.ravel(), (half * weights).ravel(), running_integral(edges, count))


# ---------------------------------------------------------------------- segments
class SpecimenSegments:
    """Straight actuators cut into equal segments, and the sections at which the segments are
    evaluated.

    chains: by specimen, with the nominal modulus. shape: sections (1, runs, segments*points) of the
    specimen of each run, segment after segment. weight [m]: (1, runs, segments, points). If no size
    varies along any specimen, segments and points are 1: one section stands for all.

    Raises DocumentError for a specimen without the keys of the model.
    """

    def __init__(self, data: MeasurementSet, segments: int, joints: SpringModel = THESIS) -> None:
        names = dict.fromkeys(run.specimen for run in data.runs)
        specimens = {name: data.specimens[name] for name in names}
        for specimen in specimens.values():
            require_keys(data, specimen, SPECIMEN_KEYS, f"the model of {data.experiment}")
        actuators = {name: _actuator(specimen) for name, specimen in specimens.items()}
        self.chains = {
            name: _chain(actuator, segments, joints) for name, actuator in actuators.items()
        }
        of_runs = [actuators[run.specimen] for run in data.runs]
        uniform = not any(_varies(specimen) for specimen in specimens.values())
        placed = [_one_section(a, segments) if uniform else _gauss(a, segments) for a in of_runs]
        x = np.array([where.ravel() for where, _ in placed])
        self.weight = np.array([weight for _, weight in placed])[None]
        self.shape = _shape(of_runs, x)


def _varies(specimen: Specimen) -> bool:
    return any(np.ndim(specimen.values[key]) for key in PROFILES)


def _one_section(actuator: Actuator, segments: int) -> tuple[Array, Array]:
    return np.zeros((1, 1)), np.full((1, 1), actuator.length / segments)


def _gauss(actuator: Actuator, segments: int) -> tuple[Array, Array]:
    """Points and weights (segments, points) [m]."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS_A_SEGMENT)
    half = actuator.length / segments / 2.0
    middle = half * (2.0 * np.arange(segments) + 1.0)
    return middle[:, None] + half * nodes, np.tile(half * weights, (segments, 1))


def _shape(actuators: list[Actuator], x: Array) -> SectionShape:
    """Sections (1, runs, sections) at positions x (runs, sections) [m]."""
    pairs = list(zip(actuators, x, strict=True))
    height, width, wall, side_wall = (
        np.array(size)[None]
        for size in zip(*(actuator.sides(at) for actuator, at in pairs), strict=True)
    )
    ratio = np.array([actuator.side_wall_ratio(at) for actuator, at in pairs])[None]
    modulus = np.array([actuator.shear_modulus for actuator in actuators])[None, :, None]
    return SectionShape(height, width, wall, side_wall, ratio, modulus)


def _actuator(specimen: Specimen) -> Actuator:
    values = specimen.values
    height, width, wall, side_wall = (np.asarray(values[key], float) for key in PROFILES)
    return Actuator(
        specimen.name,
        float(values["length"]),
        _profile(height),
        _profile(width),
        _around(height, width),
        _profile(wall),
        _profile(side_wall),
        float(values["shear_modulus"]),
        float(values.get("mass", 0.0)),
        max_pressure=np.inf,
    )


def _profile(size: Array) -> Profile:
    """A size [m] along the actuator: a number, or straight lines between points."""
    if size.ndim == 0 or len(size) == 1:
        return ConstantProfile(float(size.flat[-1]))
    return TableProfile(tuple(size[:, 0].tolist()), tuple(size[:, 1].tolist()))


def _around(height: Array, width: Array) -> Profile:
    """Circumference [m] of the rectangle, corners where one of its sides has them."""
    profiles = [_profile(size) for size in (height, width)]
    corners = [profile.x for profile in profiles if isinstance(profile, TableProfile)]
    if not corners:
        return ConstantProfile(2.0 * float(sum(profile(0.0) for profile in profiles)))
    x = np.unique(np.concatenate(corners))
    around = 2.0 * sum(profile(x) for profile in profiles)
    return TableProfile(tuple(x.tolist()), tuple(np.asarray(around).tolist()))


def _chain(actuator: Actuator, segments: int, joints: SpringModel) -> SegmentChain:
    mount = Mount("wrist", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    return cut_chain(
        ChainDescription(actuator.name, {actuator.name: actuator}, {}, mount), segments, joints
    )
