"""Planned sets, before anything is measured: runs with one input, held tips, valve pulses, poses of
a hand.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from model_lab.aliases import Array, Mask
from model_lab.bench.protocols import PROTOCOLS
from model_lab.experiments.base_torque import FINGER_SEGMENTS
from model_lab.experiments.specimen_models import SpecimenSegments
from model_lab.measurements.hands import (
    HandSpecimen,
    default_markers,
    marker_columns,
    pressure_columns,
)
from model_lab.measurements.measurement_set import (
    DEFLATE,
    INFLATE,
    MODES,
    OUTPUTS,
    TIP_POSE,
    MeasurementSet,
    Run,
    Specimen,
)
from softhand_model.chain.segments import SegmentChain
from softhand_model.effects.effect import STRETCHED
from softhand_model.gas import AMBIENT_PRESSURE, psi
from softhand_model.hand.hand import load_hand
from softhand_model.hand.section import free_curvature

DURATION = 24.0  # [s] of a run
SAMPLES_A_RUN = 200
PEAKS = {"free_bending": 45e3, "blocked_tip": 45e3, "uniaxial": 2.0}  # [Pa], or stretch above 1
MODE_PEAKS = {"uniaxial": 3.5, "pure_shear": 2.5, "equibiaxial": 1.6}  # stretch above 1 of rubber
DURATION_SHARES = (1.0, 1.0, 0.5, 0.5, 1.0, 2.0)  # of DURATION, by protocol
SPECIMENS = {
    "thin": {"length": 0.09, "height": 0.02, "width": 0.02, "wall": 0.0025, "side_wall": 0.0025},
    "thick": {"length": 0.09, "height": 0.02, "width": 0.02, "wall": 0.004, "side_wall": 0.0025},
}
SHARED = {"shear_modulus": 67e3, "mass": 0.035}
BAR = {"gauge_length": 0.033, "shear_modulus": 67e3}
SETTINGS = (  # temperature [K] and mount of each protocol in turn
    (293.15, "bending_plane_level"),
    (293.15, "base_up"),
    (313.15, "bending_plane_level"),
)
HAND_POSES, HAND_PEAK = 12, 0.3  # poses of a run; highest pressure over the limit of the channel
HAND_PROTOCOLS = {  # roll, pitch, yaw [rad] of the wrist
    "together_fingers_up": (0.0, 0.0, 0.0),
    "together_palm_down": (0.0, 1.5707963267948966, 0.0),
    "in_turn_fingers_up": (0.0, 0.0, 0.0),
    "in_turn_thumb_up": (-1.5707963267948966, 0.0, 0.0),
    "backwards_palm_up": (0.0, -1.5707963267948966, 0.0),
    "backwards_fingers_down": (3.141592653589793, 0.0, 0.0),
}
HELD_RUN_SAMPLES, HELD_DURATION = 200, 20.0  # of a run [s]
PEAK_PRESSURE = 40e3  # [Pa]
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
PUSH_COURSE = (
    (0.0, 0.0),
    (0.2, 0.0),
    (0.35, 1.0),
    (0.5, 0.0),
    (0.65, -1.0),
    (0.8, 0.0),
    (1.0, 0.7),
)
PRESSURES = {  # share of the peak over share of the duration
    "pumped": ((0.0, 0.0), (0.2, 1.0), (0.4, 0.4), (0.6, 0.9), (0.8, 0.3), (1.0, 0.7)),
    "held": ((0.0, 0.0), (0.1, 0.4), (0.5, 0.4), (0.6, 1.0), (0.95, 1.0), (1.0, 0.8)),
}
PULSES = 200
SUPPLIES = {"supply_150_kPa": 150e3, "supply_250_kPa": 250e3, "supply_350_kPa": 350e3}  # gauge
PULSE_DURATIONS = {"short": (0.05, 0.3), "long": (0.2, 1.2)}  # [s] inflating, shortest and longest
DEFLATION_SPEEDUP = 6.0  # times shorter deflating
CHANNEL_PRESSURES = (10e3, 150e3)  # [Pa] gauge
PRESSURE_DRIFT = (
    0.05  # of the pressures within a pulse, falling on the one side and rising on the other
)
INTEGRAL_POINTS = 9  # of the integrals over a pulse


# ---------------------------------------------------------------------- driven by an input
def driven_set(experiment: str) -> MeasurementSet:
    """Planned set of two actuators (or one strip) under the first protocols; some runs are warm,
    some actuators hang.
    """
    runs = []
    specimens: dict[str, Specimen] = {}
    for repeat in "ab":
        for order, (protocol, share) in enumerate(zip(PROTOCOLS, DURATION_SHARES, strict=False)):
            warm, mount = SETTINGS[order % len(SETTINGS)]
            specimen = _specimen(experiment, order, mount)
            specimens[specimen.name] = specimen
            mode = MODES[order // 2 % len(MODES)] if experiment == "rubber" else ""
            peak = MODE_PEAKS[mode] if mode else PEAKS[experiment]
            time, course = protocol.course(share * DURATION, peak, SAMPLES_A_RUN)
            columns = {"time": time, **_driving(experiment, course)}
            columns[OUTPUTS[experiment][0]] = np.zeros(SAMPLES_A_RUN)
            name = f"r{order + 1}{repeat}"
            runs.append(Run(name, specimen.name, protocol.name, warm, columns, mode=mode))
    title = f"synthesised {experiment.replace('_', ' ')}"
    return MeasurementSet(experiment, title, specimens, tuple(runs))


def _driving(experiment: str, course: Array) -> dict[str, Array]:
    return {"stretch": 1.0 + course} if experiment in STRETCHED else {"pressure": course}


def _specimen(experiment: str, order: int, mount: str) -> Specimen:
    if experiment in STRETCHED:
        return Specimen("bar", BAR, batch="A")
    kind = "thick" if order % 2 else "thin"
    if experiment == "blocked_tip":
        return Specimen(kind, {**SPECIMENS[kind], **SHARED}, batch="A")
    name = kind if mount == "bending_plane_level" else f"{kind}_{mount}"
    return Specimen(name, {**SPECIMENS[kind], **SHARED}, mount, "A")


# ---------------------------------------------------------------------- held tips
def held_tip_set() -> MeasurementSet:
    """Planned set of one actuator whose tip is pushed and turned in six ways."""
    finger = Specimen("finger", {**SPECIMENS["thin"], **SHARED}, batch="A")
    outputs = {name: np.zeros(HELD_RUN_SAMPLES) for name in OUTPUTS["base_torque"]}
    columns = {
        protocol: held_columns(finger, protocol, PEAK_PRESSURE, HELD_DURATION, HELD_RUN_SAMPLES)
        | outputs
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
    """Inputs (samples,) of a run of base_torque under a protocol of PUSHES, for a specimen that
    does not vary along its length. peak [Pa], duration [s].
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
    return SpecimenSegments(alone, FINGER_SEGMENTS).chains[finger.name]


def _free_angle(finger: Specimen, pressure: Array) -> Array:
    """Angle (samples,) [rad] of the base model's tip when nothing touches it."""
    keys = ("height", "width", "wall", "side_wall", "shear_modulus")
    sizes = [float(finger.values[key]) for key in keys]
    return np.asarray(free_curvature(pressure, *sizes)) * float(finger.values["length"])


def _pose(
    chain: SegmentChain, angle: Array, push: tuple[float, float, float, float], time: Array
) -> dict[str, Array]:
    """Pose of the tip (samples,) [m], quaternion: as the chain lies when its joints are rotated."""
    *most, forced = push
    course = _course(PUSH_COURSE, time)
    place, rotation = np.zeros((len(time), 3)), Rotation.identity(len(time))
    for joint in range(FINGER_SEGMENTS):
        # a force at the tip bends the base more than the tip, a moment all alike
        share = 1.0 + forced * (1.0 - (2.0 * joint + 1.0) / FINGER_SEGMENTS)
        place = place + rotation.apply(chain.offset[joint])
        bend = np.outer(course * share, most) / FINGER_SEGMENTS
        bend[:, 1] += angle / FINGER_SEGMENTS
        rotation = rotation * Rotation.from_rotvec(bend)
    place = place + rotation.apply(chain.tip_offset)
    return dict(zip(TIP_POSE, [*place.T, *rotation.as_quat().T], strict=True))


# ---------------------------------------------------------------------- poses of a hand
def hand_pose_set(name: str = "rbo_hand_2") -> MeasurementSet:
    """Planned set of a hand that is held in several ways while its channels are inflated together
    and one by one.
    """
    hand = load_hand(name)
    markers, limits = default_markers(hand), HAND_PEAK * hand.max_pressures()
    zeros = {column: np.zeros(HAND_POSES) for column in marker_columns(markers)}
    runs = []
    for repeat in "ab":
        for order, (protocol, rpy) in enumerate(HAND_PROTOCOLS.items()):
            shares = hand_shares(protocol, len(hand.channels))
            driven = dict(zip(pressure_columns(hand), (shares * limits).T, strict=True))
            columns = {**driven, **zeros}
            name_of_run = f"r{order + 1}{repeat}"
            runs.append(Run(name_of_run, "h1", protocol, 293.15, columns, wrist_rpy=rpy))
    specimens = {"h1": Specimen("h1", batch="A", hand=HandSpecimen(name, hand))}
    title = f"synthesised poses of {name}"
    return MeasurementSet("hand_pose", title, specimens, tuple(runs), markers=markers)


def hand_shares(protocol: str, channels: int) -> Array:
    """Pressures (poses, channels) of a protocol over their peaks: all channels rise together, or
    one after the other.
    """
    steps = np.linspace(0.0, 1.0, HAND_POSES)
    if protocol.startswith("together"):
        return np.tile(steps[:, None], (1, channels))
    order = np.arange(channels) if protocol.startswith("in_turn") else np.arange(channels)[::-1]
    return np.clip(steps[:, None] * channels - order, 0.0, 1.0)


# ---------------------------------------------------------------------- valve pulses
def pulse_set(random: np.random.Generator) -> MeasurementSet:
    """Planned set of short and long valve pulses at three supply pressures, inflating and
    deflating.
    """
    columns = {
        f"{supply}_{length}": pulse_columns(
            SUPPLIES[supply] + AMBIENT_PRESSURE, PULSE_DURATIONS[length], random
        )
        | {"mass": np.zeros(PULSES)}
        for supply in SUPPLIES
        for length in PULSE_DURATIONS
    }
    runs = [
        Run(f"r{order + 1}{repeat}", "channel", protocol, 293.15, columns[protocol])
        for repeat in "ab"
        for order, protocol in enumerate(columns)
    ]
    specimens = {"channel": Specimen("channel", {}, batch="A")}
    return MeasurementSet("valve_pulse", "synthesised valve pulses", specimens, tuple(runs))


def pulse_columns(
    supply: float, length: tuple[float, float], random: np.random.Generator
) -> dict[str, Array]:
    """Inputs (pulses,) for an absolute supply pressure [Pa] and durations drawn between two limits
    [s].
    """
    inflating = random.uniform(size=PULSES) < 0.5
    shortest, longest = length
    duration = shortest * (longest / shortest) ** random.uniform(size=PULSES)
    duration = np.where(inflating, duration, duration / DEFLATION_SPEEDUP)
    low, high = CHANNEL_PRESSURES
    high = min(high, 0.9 * supply - 101e3)
    channel = AMBIENT_PRESSURE + random.uniform(min(low, 0.5 * high), high, PULSES)
    sagging = supply * random.uniform(0.94, 1.0, PULSES)  # other channels draw from it as well
    p_in = np.where(inflating, sagging, channel)
    p_out = np.where(inflating, channel, AMBIENT_PRESSURE)
    friction, injector = _integrals(inflating, p_in, p_out)
    return {
        "direction": np.where(inflating, INFLATE, DEFLATE),
        "duration": duration,
        "p_in": p_in,
        "p_out": p_out,
        "friction_integral": friction * duration,
        "injector_integral": injector * duration,
    }


def _integrals(inflating: Mask, p_in: Array, p_out: Array) -> tuple[Array, Array]:
    """Means (pulses,) [Pa] of p_in - p_out and of p_in*Psi while the channel's pressure moves."""
    along = PRESSURE_DRIFT * np.linspace(0.0, 1.0, INTEGRAL_POINTS)[:, None]
    into = np.where(inflating, p_in, p_in * (1.0 - along))
    out = np.where(inflating, p_out * (1.0 + along), p_out)
    return np.mean(into - out, axis=0), np.mean(into * psi(out / into), axis=0)
