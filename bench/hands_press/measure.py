"""A measured set of a hand that is pressed on a plate: MuJoCo's hand on an arm, with noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from bench.hands_motion.measure import ENGINE, GAUGE_NOISE, MODULUS_SCALES, SEGMENTS, STEP, impose
from bench.hands_press.cases import CONTROL, PLATE_HEIGHT, TARED, Hidden
from bench.kept import revision_of
from model_lab.bench.hand_press_set import PRESS_FRICTION, PRESSES, Press, hand_press_set
from model_lab.measurements.hands import WRENCH_COLUMNS, WRIST_POSE
from model_lab.measurements.measurement_set import MeasurementSet, Run
from pneuflex_sim.engines.mujoco.compliance import PER_COMPLIANCE, RIGID_COMPLIANCE
from pneuflex_sim.scene.friction import RUBBER_MATERIAL, load_friction
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.numerics.arrays import Array
from softhand_common.numerics.rotations import to_rpy
from softhand_model.effects.hand import effects_of_hand
from softhand_model.effects.load import Gravity
from softhand_model.model_file import Model

SETTLED = 0.4  # [s] before the first sample
FORCE_NOISE, TORQUE_NOISE = 0.01, 0.001  # one sigma [N], [N m]
KEPT = Path("out/bench/hands_press")
AVERAGED = 0.5  # share of the time between samples over which the gauge averages


def measured(
    hidden: Hidden, random: np.random.Generator, presses: Mapping[str, Press] = PRESSES
) -> MeasurementSet:
    """Two noisy repeats of some protocols, those of the lab's planned set if none are given."""
    empty = hand_press_set(presses=presses)
    scale = float(random.uniform(*MODULUS_SCALES))
    truth = {run.protocol: kept(hidden, empty, run, scale) for run in empty.runs[: len(presses)]}
    for protocol, (wrench, wrist) in truth.items():
        if hidden.name == PLATE_HEIGHT and hidden.value is not None:  # the wrist stands for it
            truth[protocol] = wrench, wrist + np.eye(len(WRIST_POSE))[2] * hidden.value
        if hidden.name == TARED:
            truth[protocol] = wrench - wrench[0], wrist
    return noisy(empty, truth, random, shuffled=hidden.name == CONTROL)


def measured_as_drawn(hidden: Hidden, random: np.random.Generator) -> MeasurementSet:
    """Four to six protocols of the planned set, each changed: every pressure by up to 10 %, the
    lowest height by 3 mm, the tilt by 0.1 rad, and the way along the plate by a third and 30 deg.
    """
    chosen = random.choice([*PRESSES], random.integers(4, 7), replace=False)
    return measured(hidden, random, {str(name): _changed(PRESSES[name], random) for name in chosen})


def _changed(press: Press, random: np.random.Generator) -> Press:
    turn, longer = random.uniform(-np.pi / 6, np.pi / 6), random.uniform(2 / 3, 4 / 3)
    forward, aside = press.slide
    return replace(
        press,
        pressures=tuple((random.uniform(0.9, 1.1, 4) * press.pressures).tolist()),
        end=press.end + float(random.uniform(-3e-3, 3e-3)),
        slide=(
            longer * float(np.cos(turn) * forward - np.sin(turn) * aside),
            longer * float(np.sin(turn) * forward + np.cos(turn) * aside),
        ),
        tilt=press.tilt + float(random.uniform(-0.1, 0.1)),
    )


def noisy(
    empty: MeasurementSet,
    truth: Mapping[str, tuple[Array, Array]],
    random: np.random.Generator,
    shuffled: bool = False,
) -> MeasurementSet:
    """The set with wrenches and poses of the wrist by protocol, with noise, or samples shuffled."""
    level = np.repeat([FORCE_NOISE, TORQUE_NOISE], 3)
    runs = []
    for run in empty.runs:
        wrench, wrist = truth[run.protocol]
        seen = wrench + level * random.standard_normal(wrench.shape)
        if shuffled:
            seen = seen[random.permutation(len(seen))]
        columns = dict(run.columns) | dict(zip(WRIST_POSE, wrist.T, strict=True))
        columns |= dict(zip(WRENCH_COLUMNS, seen.T, strict=True))
        for name in empty.pressures:
            columns[name] = run.columns[name] + GAUGE_NOISE * random.standard_normal(run.samples)
        runs.append(replace(run, columns=columns))
    return replace(empty, title="simulated hand", runs=tuple(runs))


def kept(hidden: Hidden, empty: MeasurementSet, run: Run, scale: float) -> tuple[Array, Array]:
    """As `pressed`; kept in a folder, as long as the simulator stays as it is, so that a case that
    was stopped goes on.
    """
    effects = [(effect.name, effect.values) for effect in hidden.effects]
    course = sha256(b"".join(run.columns[name].tobytes() for name in run.columns)).hexdigest()
    code = revision_of(["src/pneuflex_sim", "bench/hands_press"])
    what = repr((effects, hidden.where, scale, course, code))
    file = KEPT / f"{run.protocol}-{sha256(what.encode()).hexdigest()[:16]}.npz"
    if not file.is_file():
        wrench, wrist = pressed(hidden, empty, run, scale)
        KEPT.mkdir(parents=True, exist_ok=True)
        np.savez(file, wrench=wrench, wrist=wrist)
    found = np.load(file)
    return found["wrench"], found["wrist"]


def pressed(
    hidden: Hidden,
    empty: MeasurementSet,
    run: Run,
    scale: float,
    segments: int = SEGMENTS,
    step: float = STEP,
    compliance: float = RIGID_COMPLIANCE,
) -> tuple[Array, Array]:
    """Wrench (samples, 6) as the gauge reads it, and poses of the wrist (samples, 7), of the
    simulated hand that an arm moves as a run wants it. compliance [m/N]: of skin and plate each.
    """
    time = run.columns["time"]
    pose = np.stack([run.columns[name] for name in WRIST_POSE], axis=1)
    scene = replace(
        load_scene("press"),
        wrist_position=tuple(pose[0, :3].tolist()),
        wrist_rpy=tuple(to_rpy(pose[0, 3:]).tolist()),
    )
    of_scene = load_friction().pair(scene.table.material, RUBBER_MATERIAL) if scene.table else 1.0
    config = SimulationConfig(
        scene=scene,
        model=Model(effects=(Gravity(mass_scale=1.0), *hidden.effects)),
        segments=segments,
        step=step,
        modulus_scale=scale,
        rubber_friction_scale=PRESS_FRICTION / of_scene,
        engine=ENGINE,
    )
    simulation = Simulation(config)
    simulation.engine.model.body_invweight0[:, 0] = PER_COMPLIANCE * compliance
    pressures = np.array([run.columns[name] for name in empty.pressures])[:, 0]
    for _ in range(round(SETTLED / step)):
        impose(simulation, pressures)
        simulation.step()
    between = round(float(time[1] - time[0]) / step)
    steps = np.arange(1, between * (len(time) - 1) + 1) * step
    way = np.array([np.interp(steps, time, one) for one in pose[:, :3].T]).T
    sums, counted = np.zeros((len(time), 6)), np.zeros(len(time))
    wrist = [np.concatenate(simulation.wrist_pose())]
    for number, place in enumerate(way, 1):
        simulation.command_wrist(place, pose[0, 3:])
        impose(simulation, pressures)
        simulation.step()
        nearest = round(number / between)
        if abs(number / between - nearest) <= AVERAGED / 2.0:
            sums[nearest] += np.concatenate(simulation.wrist_wrench())
            counted[nearest] += 1.0
        if number % between == 0:
            wrist.append(np.concatenate(simulation.wrist_pose()))
    simulation.close()
    return _read(hidden, sums / counted[:, None], pose[0, 3:]), np.array(wrist)


def _read(hidden: Hidden, wrench: Array, orientation: Array) -> Array:
    """What a gauge with the hidden effects reads (samples, 6)."""
    turn = Rotation.from_quat(orientation)
    for effect in effects_of_hand(hidden.effects):
        bias = turn.apply(effect.wrench_bias().reshape(2, 3)).ravel()
        wrench = effect.wrench_gain() * (wrench + bias)
    return wrench
