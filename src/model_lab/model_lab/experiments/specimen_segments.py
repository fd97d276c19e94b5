"""Specimens of a set as the segment chains of the simulator."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from model_lab.measurement import MeasurementSet, Specimen
from model_lab.specimens import require_keys
from softhand_model.actuator import Actuator
from softhand_model.effects.stages import SectionShape
from softhand_model.hands import ChainDescription, Mount
from softhand_model.profile import ConstantProfile, Profile, TableProfile
from softhand_model.segments import SegmentChain, cut_chain
from softhand_model.spring_model import THESIS, SpringModel

Array = NDArray[np.float64]

KEYS = ("length", "height", "width", "wall", "side_wall", "shear_modulus")
SEGMENT_POINTS = 4  # Gauss points on each segment of an actuator whose section varies


class SpecimenSegments:
    """Straight actuators cut into equal segments, and the sections at which these are evaluated.

    chains: by specimen, of the nominal modulus. shape: sections (1, runs, segments*points) of each
    run's specimen, segment after segment; weight [m] (1, runs, segments, points). Where no section
    varies one stands for all: segments and points are 1.

    Raises DocumentError for a specimen without the keys of the model.
    """

    def __init__(self, data: MeasurementSet, segments: int, joints: SpringModel = THESIS) -> None:
        names = dict.fromkeys(run.specimen for run in data.runs)
        specimens = {name: data.specimens[name] for name in names}
        for specimen in specimens.values():
            require_keys(data, specimen, KEYS, f"the model of {data.experiment}")
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
    return any(np.ndim(specimen.values[key]) for key in ("height", "width"))


def _one_section(actuator: Actuator, segments: int) -> tuple[Array, Array]:
    return np.zeros((1, 1)), np.full((1, 1), actuator.length / segments)


def _gauss(actuator: Actuator, segments: int) -> tuple[Array, Array]:
    """Points and weights (segments, points) [m]."""
    nodes, weights = np.polynomial.legendre.leggauss(SEGMENT_POINTS)
    half = actuator.length / segments / 2.0
    middle = half * (2.0 * np.arange(segments) + 1.0)
    return middle[:, None] + half * nodes, np.tile(half * weights, (segments, 1))


def _shape(actuators: list[Actuator], x: Array) -> SectionShape:
    """Sections (1, runs, sections) at positions x (runs, sections) [m]."""
    pairs = list(zip(actuators, x, strict=True))
    height, width, ratio = (
        np.array([size(actuator, at) for actuator, at in pairs])[None]
        for size in (
            lambda actuator, at: actuator.height(at),
            lambda actuator, at: actuator.width(at),
            lambda actuator, at: actuator.side_wall_ratio(at),
        )
    )
    wall, side_wall, modulus = (
        np.array([getattr(actuator, name) for actuator in actuators])[None, :, None]
        for name in ("wall", "side_wall", "shear_modulus")
    )
    return SectionShape(height, width, wall, side_wall, ratio, modulus)


def _actuator(specimen: Specimen) -> Actuator:
    values = specimen.values
    height, width = (np.asarray(values[key], float) for key in ("height", "width"))
    wall, side_wall, modulus, length = (
        float(values[key]) for key in ("wall", "side_wall", "shear_modulus", "length")
    )
    return Actuator(
        specimen.name,
        length,
        _profile(height),
        _profile(width),
        _around(height, width),
        wall,
        side_wall,
        modulus,
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
