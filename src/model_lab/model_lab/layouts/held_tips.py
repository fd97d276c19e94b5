"""An actuator whose tip is held in ever other poses, its base on a force-torque sensor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from model_lab.experiments.specimen_segments import SpecimenSegments
from model_lab.layouts.driven import SHARED, SPECIMENS
from model_lab.measurement import OUTPUTS, MeasurementSet, Run, Specimen
from softhand_model.section import free_curvature
from softhand_model.segments import SegmentChain

Array = NDArray[np.float64]

HELD_SAMPLES, HELD_DURATION = 200, 20.0  # of a run [s]
SEGMENTS = 10
PEAK = 40e3  # [Pa]
# protocol: the tip is turned by so much about x, y and z [rad] at the most (lateral bending,
# bending, twist), and the share of it that a force does instead of a moment, nearer the base
PUSHES = {
    "sideways": (0.5, 0.0, 0.0, 1.0),
    "up_and_down": (0.0, 0.5, 0.0, 1.0),
    "rolled": (0.0, 0.0, 0.5, 0.0),
    "turned": (0.4, -0.3, 0.0, 0.0),
    "pushed_and_rolled": (0.3, 0.3, -0.4, 0.5),
    "pumped": (-0.3, 0.0, 0.3, 0.5),
}
TURNS = ((0.0, 0.0), (0.2, 0.0), (0.35, 1.0), (0.5, 0.0), (0.65, -1.0), (0.8, 0.0), (1.0, 0.7))
PRESSURES = {  # share of the peak over share of the duration
    "pumped": ((0.0, 0.0), (0.2, 1.0), (0.4, 0.4), (0.6, 0.9), (0.8, 0.3), (1.0, 0.7)),
    "held": ((0.0, 0.0), (0.1, 0.4), (0.5, 0.4), (0.6, 1.0), (0.95, 1.0), (1.0, 0.8)),
}


def held_tip_set() -> MeasurementSet:
    """One actuator under six ways to push and turn its tip."""
    finger = Specimen("finger", {**SPECIMENS["thin"], **SHARED}, batch="A")
    outputs = {name: np.zeros(HELD_SAMPLES) for name in OUTPUTS["base_torque"]}
    columns = {
        protocol: held_columns(finger, protocol, PEAK, HELD_DURATION, HELD_SAMPLES) | outputs
        for protocol in PUSHES
    }
    runs = [
        Run(f"r{order + 1}{repeat}", "finger", protocol, 293.15, columns[protocol])
        for repeat in "ab"
        for order, protocol in enumerate(PUSHES)
    ]
    return MeasurementSet("base_torque", "synthesised base torque", {"finger": finger}, tuple(runs))


def held_columns(
    specimen: Specimen, protocol: str, peak: float, duration: float, samples: int
) -> dict[str, Array]:
    """Inputs (samples,) of a run of base_torque under one of PUSHES, of a specimen that does not
    vary along its length.
    """
    time = np.linspace(0.0, duration, samples)
    pressure = peak * _course(PRESSURES.get(protocol, PRESSURES["held"]), time)
    columns = {"time": time, "pressure": pressure}
    chain = _chain(specimen, columns)
    return columns | _pose(chain, _free_angle(specimen, pressure), PUSHES[protocol], time)


def _course(corners: tuple[tuple[float, float], ...], time: Array) -> Array:
    at, level = np.array(corners).T
    return np.interp(time / time[-1], at, level)


def _chain(finger: Specimen, columns: dict[str, Array]) -> SegmentChain:
    run = Run("r", finger.name, "r", 293.15, columns)
    alone = MeasurementSet("base_torque", "", {finger.name: finger}, (run,))
    return SpecimenSegments(alone, SEGMENTS).chains[finger.name]


def _free_angle(finger: Specimen, pressure: Array) -> Array:
    """Angle (samples,) [rad] of the base model's tip when nothing touches it."""
    keys = ("height", "width", "wall", "side_wall", "shear_modulus")
    sizes = [float(finger.values[key]) for key in keys]
    return np.asarray(free_curvature(pressure, *sizes)) * float(finger.values["length"])


def _pose(
    chain: SegmentChain, angle: Array, push: tuple[float, float, float, float], time: Array
) -> dict[str, Array]:
    """Pose of the tip (samples,) [m], quaternion: as the chain lies when its joints are turned."""
    *most, forced = push
    course = _course(TURNS, time)
    place, turn = np.zeros((len(time), 3)), Rotation.identity(len(time))
    for joint in range(SEGMENTS):
        # a force at the tip bends the base more than the tip, a moment all alike
        share = 1.0 + forced * (1.0 - (2.0 * joint + 1.0) / SEGMENTS)
        place = place + turn.apply(chain.offset[joint])
        bend = np.outer(course * share, most) / SEGMENTS
        bend[:, 1] += angle / SEGMENTS
        turn = turn * Rotation.from_rotvec(bend)
    place = place + turn.apply(chain.tip_offset)
    named = dict(zip(("tip_x", "tip_y", "tip_z"), place.T, strict=True))
    return named | dict(
        zip(("tip_qx", "tip_qy", "tip_qz", "tip_qw"), turn.as_quat().T, strict=True)
    )
