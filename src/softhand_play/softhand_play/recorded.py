"""Recorded runs as files: a bag to and from them, and a film."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.pictures.render import HandState, Renderer
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.scenes import SceneDescription
from pneuflex_sim.urdf import joint_names, joint_positions
from softhand_bringup.bags.course import Course, write_course
from softhand_bringup.bags.reading import Bag, latest_index
from softhand_bringup.figures import (
    JOINTS_TOPIC,
    OBJECT_TOPIC,
    PHASE_TOPIC,
    STATE_TOPIC,
    recorded_segments,
    recorded_states,
)
from softhand_bringup.film.command import camera_of, draw
from softhand_bringup.film.recording import Recording
from softhand_bringup.film.writing import open_film
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from softhand_play.shots import INTERVAL, NO_ARROWS, Shot, Stage, Track

Array = NDArray[np.float64]

FILM_SIZE = (640, 480)  # [pixels]


def film(track: Track, path: Path, told: Callable[[str, int, int], None]) -> None:
    """Write a run as an MP4 or GIF; `told` gets what, how many are done, of how many.

    Raises ValueError for a path that is taken or a kind that is none.
    """
    stage = track.stage
    renderer = Renderer(stage.layout.description, None, stage.scene, stage.layout.segments)
    renderer.object = stage.object
    states = [shot.state for shot in track.shots]
    pressures = np.array([shot.pressures for shot in track.shots])
    recording = Recording(states, pressures, INTERVAL, renderer, track.ending)
    view = argparse.Namespace(view="oblique", camera=None, size=FILM_SIZE, distance=None)
    written = open_film(path, 1.0 / INTERVAL, FILM_SIZE)
    try:
        draw(recording, written, FILM_SIZE, camera_of(view, recording), True, told)
    finally:
        written.close()


def write_bag(track: Track, folder: Path) -> None:
    """Write a run as a rosbag2 folder; raises what `write_course` does."""
    shots, stage = track.shots, track.stage
    states = [shot.state for shot in shots]
    course = Course(
        np.array([shot.time for shot in shots]),
        joint_names(stage.layout),
        np.array([joint_positions(state.joints) for state in states]),
        stage.channels,
        np.array([shot.masses for shot in shots]),
        np.array([shot.pressures for shot in shots]),
        _poses(states, "wrist"),
        None if stage.object is None else _poses(states, "object"),
        [shot.phase for shot in shots],
    )
    write_course(course, folder)


def _poses(states: list[HandState], what: str) -> Array:
    """Poses (k, 7) [m, -] of `wrist` or `object`."""
    parts = f"{what}_position", f"{what}_orientation"
    return np.array([np.hstack([getattr(state, part) for part in parts]) for state in states])


def read_bag(folder: Path, hand: str, object_name: str, scene: SceneDescription) -> Track:
    """A run from a bag; hand, object and scene are those that it was recorded with.

    Raises ValueError for a bag that cannot be read or lacks a topic, or for another hand.
    """
    with Bag(folder) as bag:
        joints, air = bag.joints(JOINTS_TOPIC), bag.joints(STATE_TOPIC)
        start = max(joints.time[0], bag.poses(OBJECT_TOPIC).time[0])
        times = np.arange(start, joints.time[-1] + 1e-9, INTERVAL)
        states, texts = recorded_states(bag, times), bag.texts(PHASE_TOPIC)
    segments = recorded_segments(hand, joints.names)
    layout = build_layout(load_hand(hand), segments, load_model(None))
    stage = Stage(layout, load_object(object_name), scene)
    row = latest_index(air.time, times)
    began = np.array([time for time, _ in texts])
    shots = []
    for k, time in enumerate(times):
        told = np.searchsorted(began, time + 1e-9, side="right") - 1
        phase = texts[told][1] if told >= 0 else ""
        pressures, masses = air.effort[row[k]], air.position[row[k]]
        volumes = stage.volumes(masses, pressures)
        shots.append(Shot(float(time), states[k], pressures, masses, volumes, NO_ARROWS, phase))
    return Track(shots, stage, "from a bag")
