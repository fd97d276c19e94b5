"""A hand in time: against a damped oscillator, MuJoCo, and itself at smaller steps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from softhand_model.chain.chain import discretise
from softhand_model.chain.segments import link_inertia
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model
from softhand_model.motion.moving_body import MovingBody
from softhand_model.motion.wrist_path import held_wrist, moved_wrist, steps_between

HAND = load_hand("single_finger")
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
STEPPED = np.array([0.0, 0.0, 20e3, 20e3, 8e3])  # [Pa]
AT = np.array([0.0, 0.05, 0.07, 0.25, 0.27])  # [s]


def finger(segments, damping_time=0.01):
    chain = discretise(HAND.chain("finger"), segments, Model())
    return MovingBody(HAND, {"finger": chain}, damping_time), chain


def waved(time):
    """A wrist that starts to swing: places [m] and orientations."""
    growing = np.clip(time / 0.1, 0.0, 1.0) ** 3
    swing = growing * np.sin(15.0 * time)
    place = np.outer(swing, [0.03, -0.02, 0.01])
    turn = np.stack([0.2 * swing, -0.5 * swing, 0.3 * growing], axis=1)
    return place, Rotation.from_rotvec(turn).as_quat()


def test_one_link_swings_as_a_damped_oscillator():
    damping_time, first = 0.002, 100.0  # [s], [Pa]
    body, chain = finger(1, damping_time)
    time = np.concatenate([[0.0, 1e-6], np.arange(0.0005, 0.3, 0.0005)])
    pressure = np.where(time > 0.0, 0.0, first)[None]
    path = held_wrist(time, UPRIGHT, 1e-4)
    shape = body.roll(path, time, pressure, gravity=0.0)
    angle = np.arctan2(shape.frames[:, 0, 0, 2], shape.frames[:, 0, 2, 2])

    link, joint = chain.segments, 1  # y
    arm = link.body_center[0]
    inertia = link_inertia(link.body_size, link.mass)[0, joint] + link.mass[0] * (
        arm[0] ** 2 + arm[2] ** 2
    )
    speed = np.sqrt(link.stiffness[0, joint] / inertia)  # undamped [rad/s]
    decay = 0.5 * damping_time * speed**2
    swing = np.sqrt(speed**2 - decay**2)
    since = time[1:] - time[1]
    free = np.exp(-decay * since) * (np.cos(swing * since) + decay / swing * np.sin(swing * since))
    assert decay < 0.5 * swing
    assert angle[0] > 1e-3
    assert angle[2:] / angle[0] == pytest.approx(np.interp(time[2:], time[1:], free), abs=0.005)


def test_steps_are_of_second_order():
    time = np.arange(0.0, 0.4, 0.01)
    pressure = np.interp(time, AT, STEPPED)[None]
    place, turn = waved(time)
    body, _ = finger(6)

    def tips(step):
        shape = body.roll(moved_wrist(time, place, turn, step), time, pressure)
        return body.point(shape, "finger", 1.0, np.zeros(3))

    exact = tips(0.000125)
    errors = [float(np.sqrt(np.mean((tips(step) - exact) ** 2))) for step in (0.002, 0.001, 0.0005)]
    assert errors[0] < 1e-4
    assert np.all(np.array(errors[1:]) < 0.45 * np.array(errors[:-1]))


def test_motion_is_that_of_mujoco_in_the_limit_of_its_step():
    pytest.importorskip("mujoco")
    from pneuflex_sim.scene.scenes import load_scene
    from pneuflex_sim.simulation import Simulation, SimulationConfig

    time = np.arange(0.0, 0.4, 0.01)
    place, turn = waved(time)
    segments = 5

    def simulated(step):
        scene = replace(load_scene("stand"), rigid_wrist=False, wrist_rpy=(0.0, 0.0, 0.0))
        config = SimulationConfig(
            hand="single_finger", scene=scene, model=Model(), segments=segments, step=step,
            engine="mujoco",
        )  # fmt: skip
        simulation = Simulation(config)
        start = simulation.wrist.position.copy()
        way, turning = CubicSpline(time, place), RotationSpline(time, Rotation.from_quat(turn))
        tips, poses = [], []
        for number in range(round(time[-1] / step) + 1):
            now = number * step
            if number % round(0.01 / step) == 0:
                tips.append(simulation.fingertips()["finger"][0])
                poses.append([part.copy() for part in simulation.wrist_pose()])
            simulation.command_wrist(start + way(now), turning(now).as_quat())
            pressures_abs = simulation.ambient + np.array([np.interp(now + step, AT, STEPPED)])
            rotations = simulation.bodies.rotations
            simulation.set_air_masses(
                simulation.air.masses(
                    pressures_abs, simulation.ambient, simulation.temperature, rotations
                )
            )
            simulation.step()
        simulation.close()
        places, turns = (np.array(part) for part in zip(*poses, strict=True))
        body, chain = finger(segments)
        path = moved_wrist(time, places, turns, 5e-4)
        shape = body.roll(path, time, np.interp(time, AT, STEPPED)[None], gravity=0.0)
        own = shape.places[:, -1] + shape.frames[:, -1] @ chain.segments.tip_offset
        return np.array(tips) - own

    coarse, fine = simulated(4e-4), simulated(2e-4)
    error = [float(np.sqrt(np.mean(part**2))) for part in (coarse, fine, 2.0 * fine - coarse)]
    assert error[1] < 0.6 * error[0] < 3e-4
    assert error[2] < 0.15 * error[0]


def test_constant_acceleration_pulls_as_weight_does():
    time = np.arange(0.0, 1.0, 0.01)
    body, _ = finger(4)
    pressure = np.full((1, len(time)), 8e3)
    held = held_wrist(time, UPRIGHT, 0.002)
    pushed = replace(held, acceleration=held.acceleration + [4.0, 0.0, -2.0])
    moved = body.roll(pushed, time, pressure, gravity=0.0).frames[-1]
    rest = body.settle(pressure[:, :1], np.array([[-4.0, 0.0, 2.0]])).frames[0]
    assert moved == pytest.approx(rest, abs=1e-6)


def test_time_that_does_not_rise_is_refused():
    with pytest.raises(ValueError, match="time: expected rising values, got a change of 0 s"):
        steps_between(np.array([0.0, 0.01, 0.01]), 0.002)
