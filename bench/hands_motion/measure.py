"""A measured set of a hand in motion: MuJoCo's hand on an arm, with noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from bench.hands.cases import Hidden
from bench.hands.slips import SLIPS, with_slip
from bench.hands_motion.cases import CONTROL
from model_lab.bench.hand_motion_set import HAND_MOTIONS, Protocol, hand_motion_set
from model_lab.measurements.hands import MARKER_AXES, WRIST_POSE
from model_lab.measurements.measurement_set import MeasurementSet, Run
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import to_rpy

ENGINE, SEGMENTS, STEP = "mujoco", 15, 0.00025  # of the simulated hand; [s]
SETTLED = 0.6  # [s] before the first sample
MARKER_NOISE, GAUGE_NOISE = 0.5e-3, 50.0  # one sigma of a coordinate [m], of a pressure [Pa]
MARKER_NOISES = (0.3e-3, 0.8e-3)  # between which that of a drawn set lies
MODULUS_SCALES = (0.93, 1.07)
MOVED = 0.4  # share of drawn motions in which the wrist moves


class Simulated(NamedTuple):
    """Engine of the simulated hand, segments of an actuator, and time step [s]."""

    engine: str = ENGINE
    segments: int = SEGMENTS
    step: float = STEP


USUAL = Simulated()


def measured(
    hidden: Hidden,
    random: np.random.Generator,
    motions: Mapping[str, Protocol] = HAND_MOTIONS,
    marker_noise: float = MARKER_NOISE,
    simulated: Simulated = USUAL,
) -> MeasurementSet:
    """Two noisy repeats of some protocols, those of the lab's planned set if none are given."""
    empty = hand_motion_set(motions=motions)
    scale = float(random.uniform(*MODULUS_SCALES))
    truth = {
        run.protocol: moved(hidden, empty, run, scale, simulated)
        for run in empty.runs[: len(motions)]
    }
    runs = []
    for run in empty.runs:
        places, wrist = truth[run.protocol]
        seen = places + marker_noise * random.standard_normal(places.shape)
        if hidden.name == CONTROL:
            seen = np.stack([row[random.permutation(len(row))] for row in seen])
        columns = dict(run.columns) | dict(zip(WRIST_POSE, wrist.T, strict=True))
        for name in empty.pressures:
            columns[name] = run.columns[name] + GAUGE_NOISE * random.standard_normal(run.samples)
        for index, name in enumerate(empty.markers):
            parts = zip(MARKER_AXES, seen[:, index].T, strict=True)
            columns |= {f"{name}.{axis}": part for axis, part in parts}
        runs.append(replace(run, columns=columns))
    return replace(empty, title="simulated hand", runs=tuple(runs))


def measured_as_drawn(hidden: Hidden, random: np.random.Generator) -> tuple[Hidden, MeasurementSet]:
    """What is hidden and its set, with the slip if it is one: four to six protocols in which the
    wrist is held in any way, and moved in MOVED of them; pressures step two to four times, together
    or in turn.
    """
    motions = {f"motion_{number}": _drawn_motion(random) for number in range(random.integers(4, 7))}
    data = measured(hidden, random, motions, float(random.uniform(*MARKER_NOISES)))
    if hidden.name not in SLIPS:
        return hidden, data
    data, slip = with_slip(data, hidden.name, random)
    return replace(hidden, slip=slip), data


def _drawn_motion(random: np.random.Generator) -> Protocol:
    moves = float(random.uniform() < MOVED)
    begun = np.cumsum([0.1, *random.uniform(0.15, 0.3, random.integers(1, 4))])
    course = [(float(at), float(random.uniform())) for at in (0.0, *begun)]
    return Protocol(
        rpy=tuple(Rotation.random(random_state=random).as_euler("xyz").tolist()),
        turn=tuple((moves * random.uniform(-0.5, 0.5, 3)).tolist()),
        way=tuple((moves * random.uniform(-0.03, 0.03, 3)).tolist()),
        rate=float(random.uniform(1.5, 3.0)),
        course=tuple(course),
        apart=float(random.choice([0.0, random.uniform(-0.12, 0.12)])),
    )


def moved(
    hidden: Hidden,
    empty: MeasurementSet,
    run: Run,
    scale: float,
    simulated: Simulated = USUAL,
) -> tuple[Array, Array]:
    """Fingertips (samples, tips, 3) [m] in the frame of the wrist, and poses of the wrist (samples,
    7), of the simulated hand that an arm moves as a run wants it.
    """
    time, step = run.columns["time"], simulated.step
    pose = np.stack([run.columns[name] for name in WRIST_POSE], axis=1)
    way = CubicSpline(time, pose[:, :3])
    turning = RotationSpline(time, Rotation.from_quat(pose[:, 3:]))
    rpy = tuple(to_rpy(pose[0, 3:]).tolist())
    scene = replace(load_scene("stand"), rigid_wrist=False, wrist_rpy=rpy)
    config = SimulationConfig(
        hand=hidden.hand,
        scene=scene,
        model=hidden.model,
        segments=simulated.segments,
        step=step,
        modulus_scale=scale,
        engine=simulated.engine,
    )
    simulation = Simulation(config)
    start = simulation.wrist.position - pose[0, :3]
    pressures = np.array([run.columns[name] for name in empty.pressures])
    pressures = np.apply_along_axis(hidden.acting, 0, pressures)
    for _ in range(round(SETTLED / step)):
        impose(simulation, pressures[:, 0])
        simulation.step()
    tips, wrist = [], []
    between = round(float(time[1] - time[0]) / step)
    steps = np.arange(1, between * (len(time) - 1) + 1) * step
    courses = np.array([np.interp(steps, time, one) for one in pressures]).T
    places, turns = start + way(steps), turning(steps).as_quat()
    for number in range(len(steps) + 1):
        if number % between == 0:
            wrist.append(np.concatenate(simulation.wrist_pose()))
            tips.append(_seen(hidden, simulation, wrist[-1][3:]))
        if number < len(steps):
            simulation.command_wrist(places[number], turns[number])
            impose(simulation, courses[number])
            simulation.step()
    simulation.close()
    return np.array(tips), np.array(wrist)


def _seen(hidden: Hidden, simulation: Simulation, orientation: Array) -> Array:
    """Where the fingertips (tips, 3) [m] are seen, in the frame of the wrist."""
    places, turns = zip(*simulation.fingertips().values(), strict=True)
    down = Rotation.from_quat(orientation).inv().apply([0.0, 0.0, -1.0])
    return hidden.seen(np.array(places), Rotation.from_quat(turns).as_matrix(), down)


def impose(simulation: Simulation, pressures: Array) -> None:
    """Impose gauge pressures (channels,) [Pa] on the channels in the next step."""
    wanted = simulation.ambient + pressures
    rotations = simulation.bodies.rotations
    masses = simulation.air.masses(wanted, simulation.ambient, simulation.temperature, rotations)
    simulation.set_air_masses(masses)
