"""A measured set of a hand: the simulator at rest in drawn poses, with noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from bench.hands.cases import HIGHEST, Hidden, shuffled
from bench.hands.slips import SLIPS, with_slip
from model_lab.measurements.hands import (
    HandSpecimen,
    default_markers,
    marker_columns,
    pressure_columns,
)
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from pneuflex_sim.engines import PYBULLET
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import load_hand

HAND = "rbo_hand_2"
SEGMENTS, STEP = 14, 0.002  # of the simulated hand; [s]
REPEATS = 2
LONGEST, STILL, LOOK = 10.0, 2e-3, 0.05  # [s] of a pose; [rad/s] of a joint at rest; [s]
GAUGE_NOISE = 50.0  # [Pa], one sigma of a pressure
WRIST_NOISE = 0.002  # one sigma [rad] by which the frame of the wrist differs from run to run
MODULUS_SCALES = (0.93, 1.07)


@dataclass(frozen=True)
class Protocols:
    """How many protocols, poses of each, noise of a coordinate (one sigma) [m], and share of the
    highest pressures that is reached.
    """

    count: int
    poses: int
    marker_noise: float
    reach: float


USUAL = Protocols(count=5, poses=8, marker_noise=0.5e-3, reach=1.0)


def measured(
    hidden: Hidden,
    random: np.random.Generator,
    scales: tuple[float, float] = MODULUS_SCALES,
    engine: str = PYBULLET,
    step: float = STEP,
    protocols: Protocols = USUAL,
) -> MeasurementSet:
    """Two noisy repeats of some protocols; each holds the wrist in another way and passes from one
    drawn set of pressures to another. scales: between which the factor [-] on the modulus of all
    rubber is drawn; engine and step [s]: of the simulated hand.
    """
    stated = load_hand(HAND)
    markers, scale = default_markers(stated), float(random.uniform(*scales))
    runs = []
    for number in range(protocols.count):
        rpy = tuple(Rotation.random(random_state=random).as_euler("xyz").tolist())
        ends = random.uniform(0.0, 1.0, (3, len(stated.channels))) * HIGHEST * protocols.reach
        ends[0] *= number % 2  # every other one begins without pressure
        at = np.linspace(0.0, 2.0, protocols.poses)
        pressures = np.stack([np.interp(at, range(3), column) for column in ends.T], axis=1)
        true = poses(hidden, pressures, rpy, scale, engine, step)
        for repeat in "ab"[:REPEATS]:
            frame = Rotation.from_rotvec(WRIST_NOISE * random.standard_normal(3)).as_matrix()
            seen = true @ frame.T + protocols.marker_noise * random.standard_normal(true.shape)
            read = hidden.read(pressures) + GAUGE_NOISE * random.standard_normal(pressures.shape)
            columns = dict(zip(pressure_columns(stated), read.T, strict=True))
            places = seen.transpose(1, 2, 0).reshape(-1, protocols.poses)
            columns |= dict(zip(marker_columns(markers), places, strict=True))
            name, protocol = f"r{number}{repeat}", f"poses_{number}"
            runs.append(Run(name, "h1", protocol, 293.15, columns, wrist_rpy=rpy))
    specimens = {"h1": Specimen("h1", hand=HandSpecimen(HAND, stated))}
    title = "simulated hand"
    made = MeasurementSet("hand_pose", title, specimens, tuple(runs), markers=markers)
    return shuffled(made, hidden.name, random)


def measured_with_slip(
    hidden: Hidden, random: np.random.Generator, protocols: Protocols = USUAL
) -> tuple[Hidden, MeasurementSet]:
    """What is hidden and its measured set, in which the slip is if it is one."""
    data = measured(hidden, random, protocols=protocols)
    if hidden.name not in SLIPS:
        return hidden, data
    data, slip = with_slip(data, hidden.name, random)
    return replace(hidden, slip=slip), data


def poses(
    hidden: Hidden,
    pressures: Array,
    rpy: tuple[float, ...],
    scale: float,
    engine: str = PYBULLET,
    step: float = STEP,
) -> Array:
    """Fingertips (poses, tips, 3) [m] at rest in the wrist frame at pressures (poses, channels)
    [Pa].
    """
    scene = replace(load_scene("stand"), wrist_rpy=rpy)
    config = SimulationConfig(
        hand=hidden.hand,
        scene=scene,
        model=hidden.model,
        segments=SEGMENTS,
        step=step,
        modulus_scale=scale,
        engine=engine,
    )
    simulation = Simulation(config)
    down = Rotation.from_euler("xyz", rpy).inv().apply([0.0, 0.0, -1.0])
    found = []
    for row in pressures:
        tips = _at_rest(simulation, hidden.acting(row))
        places = np.array([place for place, _ in tips])
        frames = Rotation.from_quat([turn for _, turn in tips]).as_matrix()
        found.append(hidden.seen(places, frames, down))
    simulation.close()
    return np.array(found)


def _at_rest(simulation: Simulation, pressures: Array) -> list[tuple[Array, Array]]:
    """Place [m] and quaternion of each fingertip once the joints rest; raises RuntimeError
    if they do not.
    """
    pressures_abs, looks = simulation.ambient + pressures, round(LONGEST / LOOK)
    for _ in range(looks):
        for _ in range(round(LOOK / simulation.step_size)):
            rotations = simulation.bodies.rotations
            masses = simulation.air.masses(
                pressures_abs, simulation.ambient, simulation.temperature, rotations
            )
            simulation.set_air_masses(masses)
            simulation.step()
        if np.abs(simulation.bodies.v).max() < STILL:
            return list(simulation.fingertips().values())
    raise RuntimeError(f"the hand still moves after {LONGEST:g} s at {pressures} Pa")
