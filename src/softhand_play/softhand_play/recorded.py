"""Recorded runs as files: written and read as bags, written as films."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.pictures.render import HandState, Renderer
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.scenes import SceneDescription
from pneuflex_sim.urdf import joint_names, joint_positions
from softhand_bringup.bags.reading import Bag, JointSeries, latest_index
from softhand_bringup.bags.states import HandStates, write_states
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
from softhand_common.documents.quoted import listed
from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from softhand_play.frames import INTERVAL, NO_ARROWS, Frame, StaticScene, Track

FILM_SIZE = (640, 480)  # [pixels]
LONGEST_RUN = 3600.0  # read from a bag [s]


def film(track: Track, path: Path, progress: Callable[[str, int, int], None]) -> None:
    """Write a run as an MP4 or GIF; `progress` is called with the name of the step, its number and
    the number of all steps.

    Raises ValueError for a path that exists or has another suffix.
    """
    static_scene = track.static_scene
    renderer = Renderer(
        static_scene.layout.description, None, static_scene.scene, static_scene.layout.segments
    )
    renderer.object = static_scene.object
    states = [frame.state for frame in track.frames]
    pressures = np.array([frame.pressures for frame in track.frames])
    recording = Recording(states, pressures, INTERVAL, renderer, track.ending)
    view = argparse.Namespace(view="oblique", camera=None, size=FILM_SIZE, distance=None)
    with open_film(path, 1.0 / INTERVAL, FILM_SIZE) as written:
        draw(recording, written, FILM_SIZE, camera_of(view, recording), True, progress)


def write_bag(track: Track, folder: Path) -> None:
    """Write a run as a rosbag2 folder; raises the errors of `write_states`."""
    frames, static_scene = track.frames, track.static_scene
    states = [frame.state for frame in frames]
    recorded = HandStates(
        np.array([frame.time for frame in frames]),
        joint_names(static_scene.layout),
        np.array([joint_positions(state.joints) for state in states]),
        static_scene.channels,
        np.array([frame.masses for frame in frames]),
        np.array([frame.pressures for frame in frames]),
        _poses(states, "wrist"),
        None if static_scene.object is None else _poses(states, "object"),
        [frame.phase for frame in frames],
    )
    write_states(recorded, folder)


def _poses(states: list[HandState], what: str) -> Array:
    """Poses (k, 7) [m, -] of `wrist` or `object`."""
    parts = f"{what}_position", f"{what}_orientation"
    return np.array([np.hstack([getattr(state, part) for part in parts]) for state in states])


def read_bag(folder: Path, hand: str, object_name: str, scene: SceneDescription) -> Track:
    """Read a run from a bag that was recorded with this hand, object and scene.

    Raises ValueError for a bag that cannot be read, lacks a topic or was recorded with another
    hand.
    """
    with Bag(folder) as bag:
        joints, air = bag.joints(JOINTS_TOPIC), bag.joints(STATE_TOPIC)
        start = max(joints.time[0], bag.poses(OBJECT_TOPIC).time[0])
        if not 0.0 < joints.time[-1] - start <= LONGEST_RUN:
            span = joints.time[-1] - start
            raise ValueError(
                f"{folder.name}: expected a recording longer than 0 and up to {LONGEST_RUN:g} s, "
                f"got {span:g} s in which both joints and object are known"
            )
        times = np.arange(start, joints.time[-1] + 1e-9, INTERVAL)
        states, texts = recorded_states(bag, times), bag.texts(PHASE_TOPIC)
    segments = recorded_segments(hand, joints.names)
    layout = build_layout(load_hand(hand), segments, load_model(None))
    static_scene = StaticScene(layout, load_object(object_name), scene)
    _check_air(air, static_scene.channels)
    row = latest_index(air.time, times)
    began = np.array([time for time, _ in texts])
    frames = []
    for k, time in enumerate(times):
        latest = np.searchsorted(began, time + 1e-9, side="right") - 1
        phase = texts[latest][1] if latest >= 0 else ""
        pressures, masses = air.effort[row[k]], air.position[row[k]]
        volumes = static_scene.volumes(masses, pressures)
        frames.append(Frame(float(time), states[k], pressures, masses, volumes, NO_ARROWS, phase))
    return Track(frames, static_scene, "from a bag")


def _check_air(air: JointSeries, channels: tuple[str, ...]) -> None:
    """Raise ValueError unless each state has a finite number for each channel of the hand."""
    if air.names != channels:
        raise ValueError(
            f"{STATE_TOPIC}: expected the channels of the chosen hand, {listed(channels)}, "
            f"got {listed(air.names)}"
        )
    for name in ("position", "effort"):
        values = getattr(air, name)
        if values.shape != (len(air.time), len(channels)) or not np.isfinite(values).all():
            raise ValueError(
                f"{STATE_TOPIC}: {name}: expected one finite number for each channel, got other "
                "counts, NaN or infinity"
            )
