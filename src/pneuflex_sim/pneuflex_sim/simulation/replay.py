"""Replay of a recorded grasp: wrist and air follow the record, hand and object move freely."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pneuflex_sim.hand.wrist import WristParameters
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation.config import SimulationConfig
from pneuflex_sim.simulation.simulation import Simulation
from pneuflex_sim.world import Diverged
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import to_rpy

FOLLOWING_ARM = WristParameters(
    stiffness=1e5, rotational_stiffness=3e3, force_limit=1e4, torque_limit=1e3, mass=1.0
)  # an arm that yields nothing: the path was recorded where the wrist really was
REPLAY_SETTLED = 0.2  # [s] before the first sample
MOST_TILTED = 0.2  # [rad] between an object as recorded and as it rests in the scene


def replay_grasp(
    time: Array, wrist: Array, masses: Array, start: Array, scene: str, **config: Any
) -> Array:
    """Simulate a recorded grasp; returns (samples, 13 + channels): force [N] and torque [N m] on
    the wrist in world axes, gauge pressures [Pa], position [m] and quaternion of the object.
    Forces, torques and pressures are averaged over the time that is closer to the sample than to
    any other. All are NaN if the simulation diverges.

    time: (samples,) [s]. wrist: poses (samples, 7). masses: air masses above the fill at rest
    (samples, channels) [kg]. start: pose (7,) of the resting object, of which x, y and the rotation
    about the vertical are used. scene, config: as in `SimulationConfig`.

    Raises ValueError for an object that is tilted against its description, and as
    `SimulationConfig` does.
    """
    stood = replace(
        load_scene(scene),
        wrist_position=tuple(wrist[0, :3].tolist()),
        wrist_rpy=tuple(to_rpy(wrist[0, 3:]).tolist()),
    )
    simulation = Simulation(SimulationConfig(scene=stood, wrist=FOLLOWING_ARM, **config))
    simulation.place_object(*_resting(simulation, start))
    step = simulation.step_size
    steps = time[0] + step * np.arange(1, round((time[-1] - time[0]) / step) + 1)
    way = np.array([np.interp(steps, time, column) for column in wrist[:, :3].T]).T
    turn = Slerp(time, Rotation.from_quat(wrist[:, 3:]))(np.minimum(steps, time[-1])).as_quat()
    air = np.array([np.interp(steps, time, column) for column in masses.T]).T
    seen = np.empty((len(steps), 13 + masses.shape[1]))
    try:
        for _ in range(round(REPLAY_SETTLED / step)):
            simulation.set_air_masses(masses[0])
            simulation.step()
        for number in range(len(steps)):
            simulation.command_wrist(way[number], turn[number])
            simulation.set_air_masses(air[number])
            simulation.step()
            seen[number] = np.concatenate(
                [*simulation.wrist_wrench(), simulation.pressures(), *simulation.object_pose()]
            )
    except Diverged:
        seen[:] = np.nan
    simulation.close()
    nearest = np.searchsorted(0.5 * (time[1:] + time[:-1]), steps)
    first = np.searchsorted(nearest, np.arange(len(time)))
    means = np.add.reduceat(seen, first) / np.bincount(nearest)[:, None]
    at = np.clip(np.searchsorted(steps, time), 0, len(steps) - 1)
    return np.hstack([means[:, :-7], seen[at, -7:]])


def _resting(simulation: Simulation, start: Array) -> tuple[tuple[float, ...], float, float]:
    """Offset (2,) [m] of the object, factor on its mass, and yaw [rad]."""
    described = simulation.object
    if described is None:
        raise ValueError(f"scene: expected a scene with an object, got {simulation.scene.name}")
    rest = Rotation.from_euler("xyz", described.rpy)
    turned = (Rotation.from_quat(start[3:]) * rest.inv()).as_rotvec()
    tilt = float(np.hypot(*turned[:2]))
    if tilt > MOST_TILTED:
        raise ValueError(
            f"object: expected {described.name} to rest in the orientation of its description, "
            f"got a tilt of {np.degrees(tilt):.3g} deg against it"
        )
    return tuple(start[:2].tolist()), 1.0, float(turned[2])
