"""Recordings of a hand in motion, as sets of `hand_motion`."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hand_bag import FIST, OPEN, PALM_UP, recorded

from model_lab.experiments.hand_motion import HandMotion
from model_lab.importing.hand_courses import HandCourse
from model_lab.importing.hand_motions import set_of_motions
from model_lab.importing.hand_sets import set_of_hand
from model_lab.measurements.hands import HandSpecimen, default_markers
from model_lab.measurements.load import load_measurements
from pneuflex_sim.engines import MUJOCO
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model

HAND = "rbo_hand_2"
STEP, EVERY = 1e-3, 10  # [s] of the physics; steps a sample
RISE, HELD = 0.04, 1.2  # [s] of a step of the pressure, and between two
LAG = 0.06  # [s] of channel b
CLASSES = effect_classes()
GRAVITY = CLASSES["gravity"](mass_scale=1.0)
LATE = CLASSES["channel_lag"].at(channel="b")(time_constant=LAG)


def simulated(peaks, effects=()):
    """The course of a hand on a stand whose channels step to shares (peaks, channels) of 40 kPa, as
    another engine moves it.
    """
    config = SimulationConfig(
        hand=load_hand(HAND),
        scene=load_scene("stand"),
        model=Model(effects=(GRAVITY, *effects)),
        segments=10,
        step=STEP,
        engine=MUJOCO,
    )
    simulation = Simulation(config)
    wanted = 40e3 * np.vstack([np.zeros(4), peaks])
    corners = np.cumsum([0.0, 1.0, *[RISE, HELD] * len(peaks)])
    held = np.repeat(wanted, 2, axis=0)
    rows = []
    for number in range(round(corners[-1] / STEP)):
        now = [np.interp(number * STEP, corners, column) for column in held.T]
        masses = simulation.air.masses(
            simulation.ambient + np.array(now),
            simulation.ambient,
            simulation.temperature,
            simulation.bodies.rotations,
        )
        simulation.set_air_masses(masses)
        simulation.step()
        if number % EVERY == 0:
            tips = [place for place, _ in simulation.fingertips().values()]
            rows.append(
                (simulation.time, simulation.pressures(), np.array(tips), simulation.wrist_pose())
            )
    simulation.close()
    time, pressures, tips, wrist = (np.array(part) for part in zip(*[
        (*row[:3], np.concatenate(row[3])) for row in rows
    ], strict=True))  # fmt: skip
    places = dict(zip(default_markers(load_hand(HAND)), tips.transpose(1, 0, 2), strict=True))
    files = (Path("simulated"),)
    return HandCourse(files, time, pressures, places, wrist[:, 3:], (), wrist[:, :3])


def set_in(folder, *courses):
    found = set_of_motions(courses, HandSpecimen(HAND, load_hand(HAND)))
    found.write(folder)
    return load_measurements(folder)


def error(data, *effects):
    """Distance [m], root mean square, of predicted from measured coordinates."""
    predicted = HandMotion(data).predict({}, [GRAVITY, *effects])[0]
    return float(np.sqrt(np.mean((predicted - data.table.value) ** 2)))


@pytest.fixture(scope="module")
def steps(tmp_path_factory):
    """Two repeats of two steps, of a hand whose channel b is late."""
    course = simulated([[0.6, 0.6, 0.6, 0.6], [0.2, 0.9, 0.2, 0.5]], [LATE])
    return course, set_in(tmp_path_factory.mktemp("steps") / "set", course, course)


def test_each_step_is_a_run_that_begins_at_rest_and_its_repeats_share_a_protocol(steps):
    course, data = steps
    assert [run.protocol for run in data.runs] == ["motion_1", "motion_2"] * 2
    for run, begun in zip(data.runs[:2], (1.0, 1.0 + RISE + HELD), strict=True):
        pressures = np.array([run.columns[name] for name in data.pressures])
        at = int(np.searchsorted(course.time, begun))
        assert np.allclose(pressures[:, 0], course.pressures[at - 30], atol=500.0)
        assert np.ptp(run.columns["time"]) < HELD
        assert np.allclose(run.wrist_rpy, 0.0, atol=np.deg2rad(2.0))


def test_the_lab_predicts_what_another_engine_moved_only_with_the_lag_that_it_had(steps):
    data = steps[1]
    with_it, without = error(data, LATE), error(data)
    assert without > 3.0 * with_it
    assert with_it < 1e-3


def test_a_wrist_that_moves_comes_with_its_path(steps, tmp_path):
    course = steps[0]
    sway = 0.02 * np.sin(2.0 * course.time)[:, None] * [1.0, 0.0, 0.0]
    data = set_in(tmp_path / "set", replace(course, wrist_places=course.wrist_places + sway))
    path = np.concatenate([run.columns["wrist.x"] for run in data.runs])
    assert np.ptp(path) > 0.01
    with pytest.raises(DocumentError, match="expected wrist.x.* of a wrist that moves"):
        turn = course.wrist + sway * 10.0 @ np.eye(3, 4)
        set_in(tmp_path / "other", replace(course, wrist=turn, wrist_places=None))


def test_a_recording_that_is_too_slow_or_never_at_rest_is_refused(tmp_path, steps):
    bag = recorded(tmp_path / "bag", [(OPEN, PALM_UP), (FIST, PALM_UP)])
    with pytest.raises(DocumentError, match="100 samples a second or more .* got 50.*joint_rate"):
        set_of_hand([bag], HAND, "hand_motion")
    course = steps[0]
    sways = {
        name: place + 0.05 * np.sin(3.0 * course.time)[:, None]
        for name, place in course.places.items()
    }
    with pytest.raises(DocumentError, match="begin with hand and wrist at rest, got none"):
        set_in(tmp_path / "set", replace(course, places=sways))


def test_a_motion_in_which_samples_are_missing_is_left_out(tmp_path, steps):
    course = steps[0]
    kept = np.abs(course.time - 1.0 - RISE) > 0.03  # in the first step
    places = {name: place[kept] for name, place in course.places.items()}
    lost = replace(
        course,
        time=course.time[kept],
        pressures=course.pressures[kept],
        places=places,
        wrist=course.wrist[kept],
        wrist_places=course.wrist_places[kept],
    )
    found = set_of_motions([lost], HandSpecimen(HAND, load_hand(HAND)))
    assert len(found.runs) == 1
    assert "1 of 2 motions are left out" in found.remarks[-1]


def test_a_recording_of_one_sample_has_no_motion(tmp_path, steps):
    course = steps[0]
    places = {name: place[:1] for name, place in course.places.items()}
    one = replace(
        course,
        time=course.time[:1],
        pressures=course.pressures[:1],
        places=places,
        wrist=course.wrist[:1],
        wrist_places=course.wrist_places[:1],
    )
    with pytest.raises(DocumentError, match="begin with hand and wrist at rest, got none"):
        set_in(tmp_path / "set", one)
