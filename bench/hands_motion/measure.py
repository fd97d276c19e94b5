"""A measured set of a hand in motion: MuJoCo's hand on an arm, with noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from bench.hands_motion.cases import CONTROL, Hidden
from model_lab.bench.hand_motion_set import HAND_MOTIONS, hand_motion_set
from model_lab.measurements.hands import MARKER_AXES, WRIST_POSE
from model_lab.measurements.measurement_set import MeasurementSet, Run
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import to_rpy
from softhand_model.effects.load import Gravity
from softhand_model.model_file import Model

ENGINE, SEGMENTS, STEP = "mujoco", 15, 0.00025  # of the simulated hand; [s]
SETTLED = 0.6  # [s] before the first sample
MARKER_NOISE, GAUGE_NOISE = 0.5e-3, 50.0  # one sigma of a coordinate [m], of a pressure [Pa]
MODULUS_SCALES = (0.93, 1.07)


def measured(hidden: Hidden, random: np.random.Generator) -> MeasurementSet:
    """Two noisy repeats of six protocols of the lab's planned set."""
    empty = hand_motion_set()
    scale = float(random.uniform(*MODULUS_SCALES))
    truth = {
        run.protocol: moved(hidden, empty, run, scale) for run in empty.runs[: len(HAND_MOTIONS)]
    }
    runs = []
    for run in empty.runs:
        places, wrist = truth[run.protocol]
        seen = places + MARKER_NOISE * random.standard_normal(places.shape)
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


def moved(hidden: Hidden, empty: MeasurementSet, run: Run, scale: float) -> tuple[Array, Array]:
    """Fingertips (samples, tips, 3) [m] in the frame of the wrist, and poses of the wrist (samples,
    7), of the simulated hand that an arm moves as a run wants it.
    """
    time = run.columns["time"]
    pose = np.stack([run.columns[name] for name in WRIST_POSE], axis=1)
    way = CubicSpline(time, pose[:, :3])
    turning = RotationSpline(time, Rotation.from_quat(pose[:, 3:]))
    rpy = tuple(to_rpy(pose[0, 3:]).tolist())
    scene = replace(load_scene("stand"), rigid_wrist=False, wrist_rpy=rpy)
    config = SimulationConfig(
        scene=scene,
        model=Model(effects=(Gravity(mass_scale=1.0), *hidden.effects)),
        segments=SEGMENTS,
        step=STEP,
        modulus_scale=scale,
        engine=ENGINE,
    )
    simulation = Simulation(config)
    start = simulation.wrist.position - pose[0, :3]
    pressures = np.array([run.columns[name] for name in empty.pressures])
    for _ in range(round(SETTLED / STEP)):
        impose(simulation, pressures[:, 0])
        simulation.step()
    tips, wrist = [], []
    between = round(float(time[1] - time[0]) / STEP)
    steps = np.arange(1, between * (len(time) - 1) + 1) * STEP
    courses = np.array([np.interp(steps, time, one) for one in pressures]).T
    places, turns = start + way(steps), turning(steps).as_quat()
    for number in range(len(steps) + 1):
        if number % between == 0:
            tips.append([place for place, _ in simulation.fingertips().values()])
            wrist.append(np.concatenate(simulation.wrist_pose()))
        if number < len(steps):
            simulation.command_wrist(places[number], turns[number])
            impose(simulation, courses[number])
            simulation.step()
    simulation.close()
    return np.array(tips), np.array(wrist)


def impose(simulation: Simulation, pressures: Array) -> None:
    """Impose gauge pressures (channels,) [Pa] on the channels in the next step."""
    wanted = simulation.ambient + pressures
    rotations = simulation.bodies.rotations
    masses = simulation.air.masses(wanted, simulation.ambient, simulation.temperature, rotations)
    simulation.set_air_masses(masses)
