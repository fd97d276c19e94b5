"""Motion at coarse steps: natural frequency, time of a bend, loss of energy, statics.

The poles of the damped first mode are found, so that the loss of the springs does not count as a
lower frequency. Actuators have no weight, and the valves are closed.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from importlib import resources
from typing import Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from bench.row import at_least, at_most
from bench.simulator import response_time
from pneuflex_sim.engines import PYBULLET
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig, config
from softhand_model.dynamics.chain import inertial_torque, not_placed, place_links
from softhand_trials.trials import TrialSettings
from thesis.chapter_3_and_5.planar import equilibrium, linear_springs, planar_finger

Array = NDArray[np.float64]

SEGMENTS = 10
FINE = 1e-4  # [s] step of the reference
FREQUENCY_TARGETS = {0.001: 0.95, 0.002: 0.85, 0.005: 0.55}  # over that at the fine step, by step
PARTS = {"finger": ("single_finger", "finger"), "palm with thumb": ("rbo_hand_2", "palm")}
SWING = 0.05  # [rad] bend of the joint that swings most
RING_TIME = 0.25  # [s]
SWING_END = 0.01  # of its start, where a swing is over
RESPONSE_STEP, RESPONSE_TARGET = 0.0005, 1.2
STATIC_STEPS, STATIC_TARGET = (0.001, 0.002, 0.005, 0.01), 1e-3
STATIC_PRESSURE, STATIC_TIME = 10e3, 12.0  # [Pa], [s]
LOSS_TARGET, GROWTH_TARGET = 0.10, 2e-4
DEFAULT_STEP = TrialSettings().step


def weightless(**settings: Any) -> Simulation:
    """A hand on a rigid stand whose actuators have no weight."""
    model = resources.files("softhand_model").joinpath("data/models/base.yaml")
    return Simulation(SimulationConfig(scene="stand", model=model, **settings))


# ------------------------------------------------------------------ ringing
def joint_inertia(simulation: Simulation) -> Array:
    """Inertia (3n, 3n) [kg m2] of all joints as they are now, of links without added inertia."""
    bodies, hand = simulation.bodies, simulation.bodies.layout
    links, placed = hand.links(0.0), not_placed(len(hand.mass))
    place_links(bodies.q, links, placed)
    columns = []
    for unit in np.eye(bodies.v.size):
        columns.append(np.empty_like(bodies.v))
        inertial_torque(unit.reshape(bodies.v.shape), links, placed, columns[-1])
    return np.array([column.ravel() for column in columns])


def first_mode(simulation: Simulation, body: str) -> tuple[float, Array, Array]:
    """First mode of a serial body whose springs swing without gas and damping: its natural
    frequency [Hz], rotations (n, 3) [rad] with the largest at `SWING`, and weights (n, 3) with
    which rotations give the mode's share.
    """
    bodies, hand = simulation.bodies, simulation.bodies.layout
    joints = next(found.joints for found in hand.bodies if found.name == body)
    own = np.zeros(bodies.v.shape, bool)
    own[joints] = True
    chosen = np.flatnonzero(own.ravel())
    inertia = joint_inertia(simulation)[np.ix_(chosen, chosen)]
    squares, shapes = eigh(np.diag(hand.stiffness.ravel()[chosen]), inertia)
    mode, weights = np.zeros(bodies.v.size), np.zeros(bodies.v.size)
    mode[chosen] = shapes[:, 0] * SWING / np.abs(shapes[:, 0]).max()
    weights[chosen] = inertia @ shapes[:, 0]
    shape = bodies.v.shape
    return np.sqrt(squares[0]) / (2 * np.pi), mode.reshape(shape), weights.reshape(shape)


def let_go(simulation: Simulation, rotations: Array) -> None:
    """Turn every joint by a rotation (n, 3) [rad] from rest, and let go."""
    bent = Rotation.from_rotvec(rotations)
    start = (Rotation.from_quat(simulation.bodies.layout.rest) * bent).as_quat()
    simulation.bodies.reset(simulation.wrist, start)


def recurrent_frequency(shares: Array, step: float) -> float:
    """Natural frequency [Hz] of a damped swing (k,): |pole| / 2 pi of the recurrence over two steps
    that fits best (Prony). Linear, it has no local minima where a swing is over after some steps.
    """
    swings = shares[: 1 + int(np.flatnonzero(np.abs(shares) > SWING_END * abs(shares[0]))[-1])]
    before = np.stack([swings[1:-1], swings[:-2]], axis=1)
    factors = np.linalg.lstsq(before, swings[2:], rcond=None)[0]
    poles = np.log(np.roots([1.0, *-factors]).astype(complex)) / step
    return float(np.sqrt(np.abs(np.prod(poles))) / (2 * np.pi))


def ringing(hand: str, body: str, step: float, segments: int = SEGMENTS) -> float:
    """First natural frequency [Hz] of a body of a hand, let go with its valves closed."""
    simulation = weightless(hand=hand, step=step, segments=segments, engine=PYBULLET)
    _, mode, weights = first_mode(simulation, body)
    let_go(simulation, mode)
    simulation.set_air_masses(np.zeros(len(simulation.channels)))
    swing = [np.sum(weights * simulation.bodies.rotations)]
    for _ in range(round(RING_TIME / step)):
        simulation.step()
        swing.append(np.sum(weights * simulation.bodies.rotations))
    simulation.close()
    return recurrent_frequency(np.array(swing), step)


def frequencies() -> list[dict[str, Any]]:
    """Rows of natural frequencies over those at the fine step."""
    found = []
    for name, part in PARTS.items():
        fine = ringing(*part, FINE)
        for step, least in FREQUENCY_TARGETS.items():
            label = f"{name}, {SEGMENTS} segments, {1e3 * step:g} ms: frequency over that at 0.1 ms"
            found.append(at_least(label, ringing(*part, step) / fine, "", least))
    return found


# ------------------------------------------------------------------ energy
def energy(simulation: Simulation) -> float:
    """Kinetic and elastic energy [J] of a weightless hand at ambient pressure whose springs are
    linear; its links have no added inertia.
    """
    bodies = simulation.bodies
    v = bodies.v.ravel()
    elastic = 0.5 * np.sum(bodies.layout.stiffness * bodies.rotations**2)
    return float(0.5 * v @ joint_inertia(simulation) @ v + elastic)


def kept_at(simulation: Simulation, pressure: float) -> Callable[[Any], None]:
    """What keeps the chambers at a gauge pressure [Pa], in place of `Simulation._update_air`."""

    def impose(_valves: Any) -> None:
        simulation._volumes = simulation.air.volumes(simulation.bodies.rotations)
        simulation.pressures_abs = np.full(len(simulation.channels), simulation.ambient + pressure)

    return impose


def free_swing(step: float, segments: int) -> tuple[float, float]:
    """Loss of energy of a finger let go over what its dampers take in the same time, D*v^2 summed;
    and the largest growth within a step over the energy at the start [-].
    """
    simulation = weightless(hand="single_finger", step=step, segments=segments)
    simulation.air.total_gain[:] = 0.0  # enclosed gas would act within a step
    let_go(simulation, first_mode(simulation, "finger")[1])
    damping = simulation.bodies.layout.springs().damping
    levels, lost = [energy(simulation)], 0.0
    with mock.patch.object(simulation, "_update_air", kept_at(simulation, 0.0)):
        while simulation.time < RING_TIME:
            simulation.step()
            lost += step * float(np.sum(damping * simulation.bodies.v**2))
            levels.append(energy(simulation))
    simulation.close()
    return (levels[0] - levels[-1]) / lost, float(np.diff(levels).max()) / levels[0]


# ------------------------------------------------------------------ statics
def sag_error(step: float, segments: int) -> float:
    """Relative error of the angle of a level finger under its weight at 10 kPa against the static
    solver, which knows no step.
    """
    level = dataclasses.replace(load_scene("stand"), wrist_rpy=(0.0, np.pi / 2, 0.0))
    with mock.patch.object(config, "load_scene", lambda *_: level):
        simulation = Simulation(
            SimulationConfig(hand="single_finger", scene="stand", step=step, segments=segments)
        )
    model = simulation.bodies.layout.models["finger"]
    with mock.patch.object(simulation, "_update_air", kept_at(simulation, STATIC_PRESSURE)):
        while simulation.time < STATIC_TIME:
            simulation.step()
    chain, rest = model.segments, model.rest_rotation([STATIC_PRESSURE])[:, 1]
    springs = linear_springs(chain.stiffness[:, 1], rest)
    exact = equilibrium(planar_finger(chain), springs, gravity=(9.80665, 0.0)).angles.sum()
    found = simulation.tip_angles()["finger"]
    simulation.close()
    return abs(found / float(exact) - 1.0)


def rows(small: bool) -> list[dict[str, Any]]:
    """All rows; few when it is small."""
    found = frequencies()
    for segments in (5,) if small else (5, SEGMENTS):
        times = [response_time(segments, step) for step in (DEFAULT_STEP, RESPONSE_STEP)]
        name = f"finger, {segments} segments, default step: time to 90 % of a bend over 0.5 ms"
        found.append(at_most(name, times[0] / times[1], "", RESPONSE_TARGET))
    for step in (0.001, DEFAULT_STEP):
        ratio, growth = free_swing(step, SEGMENTS)
        name = f"free swing, {1e3 * step:g} ms"
        found.append(
            at_most(f"{name}: loss over that stated, off 1", abs(ratio - 1), "", LOSS_TARGET)
        )
        found.append(at_most(f"{name}: largest growth in a step", growth, "", GROWTH_TARGET))
    for step in (0.001, 0.01) if small else STATIC_STEPS:
        name = f"level finger, {SEGMENTS} segments, {1e3 * step:g} ms: error at rest"
        found.append(at_most(name, sag_error(step, SEGMENTS), "", STATIC_TARGET))
    return found
