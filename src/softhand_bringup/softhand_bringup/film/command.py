"""The command `softhand film`: pictures, GIF or MP4 of a grasp, from a trial or a bag."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from grasp_strategies.sweep.results import find_record
from grasp_strategies.sweep.trial_line import trial_of
from grasp_strategies.trials import (
    Placement,
    TrialSettings,
    add_settings,
    draw_placement,
    read_settings,
)
from pneuflex_sim.pictures.render import Camera
from pneuflex_sim.pictures.surfaces import actuator_colors
from pneuflex_sim.scene.scenes import load_scene
from softhand_bringup.film.recording import Recording, film_bag, film_trial
from softhand_bringup.film.writing import Film, open_film
from softhand_model.progress import Progress

VIEWS = {"oblique": (62.0, -16.0), "front": (90.0, -8.0), "side": (0.0, -8.0), "top": (90.0, -75.0)}
RESULTS = (Path("out/thesis"), Path("out/sweeps"))  # folders of sweeps, each by its name
MARGIN = 0.08  # around the ways of wrist and object [m]


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(
        prog="softhand film",
        description="Run one trial of a grasp without ROS, or read a bag, and draw it. A second of "
        "film is a second of simulated time, unless --slow or --every say otherwise.",
    )
    add = found.add_argument
    add("-o", "--out", type=Path, required=True, help="a .gif, a .mp4, or a folder for PNG files")
    add("--bag", type=Path, help="draw this recording instead of a trial")
    add("--cell", help="play this trial of a sweep, such as push_map/marker/10,-30 or .../10,-30/2")
    add("--results", type=Path, help="folder of the sweep's results (that of its name in out/)")
    add("--hand", help="of the bag (rbo_hand_2), or instead of that which the strategy names")
    add_settings(found)
    add("--seed", type=int, default=0, help="draws the object's shift and mass, as in trials")
    add("--offset", nargs=2, type=float, metavar=("X", "Y"), help="shift [m], not the drawn one")
    add("--mass-scale", type=_positive, help="factor on the object's mass, not the drawn one")
    add("--fps", type=_positive, default=25.0, help="pictures a second of film (%(default)s)")
    pace = found.add_mutually_exclusive_group()
    pace.add_argument("--slow", type=_positive, default=1.0, help="4: slow motion, 4 times as long")
    pace.add_argument("--every", type=_positive, help="simulated time between pictures [s]")
    add("--size", type=_size, default=(640, 480), metavar="WxH", help="in pixels (640x480)")
    add("--view", choices=VIEWS, default="oblique", help="where it is seen from (%(default)s)")
    add("--camera", nargs=2, type=float, metavar=("YAW", "PITCH"), help="[deg], instead of a view")
    add("--distance", type=_positive, help="of the camera [m]; else the hand's way is seen")
    add("--pressure", action="store_true", help="colour actuators by pressure: sand to red")
    add("--force", action="store_true", help="overwrite an earlier film")
    return found


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text}")
    return value


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit() and int(width) and int(height)):
        raise argparse.ArgumentTypeError(f"expected WIDTHxHEIGHT, got {text}")
    return int(width), int(height)


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw a film; 0, or 2 when the options cannot be used."""
    options = parser().parse_args(arguments)
    try:
        return _run(options)
    except (ValueError, OSError) as error:
        print(f"softhand film: {error}", file=sys.stderr)
        return 2


def _run(options: argparse.Namespace) -> int:
    film = open_film(options.out, options.fps, options.size, options.force)
    recording = _record(options)
    count, shown = len(recording.states), recording.interval * len(recording.states)
    print(f"softhand film: {recording.ending}; {count} pictures of {shown:.2f} s", file=sys.stderr)
    camera = camera_of(options, recording)
    try:
        with Progress("drawing") as progress:
            draw(recording, film, options.size, camera, options.pressure, progress)
    finally:
        film.close()
    if options.out.suffix:
        print(f"{options.out}: {count / options.fps:.2f} s at {options.fps:g} pictures a second")
    else:
        print(f"{options.out}: {count} PNG files, one each {recording.interval:g} s of simulation")
    return 0


def _record(options: argparse.Namespace) -> Recording:
    """The trial or the bag that the options ask for."""
    interval = options.every or 1.0 / (options.fps * options.slow)
    if options.bag is not None:
        scene = load_scene(options.scene).inclined(options.wall_inclination)
        hand = options.hand or "rbo_hand_2"
        return film_bag(options.bag, interval, hand, options.object, scene)
    settings, placement = trial_asked_for(options)
    return film_trial(settings, placement, interval)


def trial_asked_for(options: argparse.Namespace) -> tuple[TrialSettings, Placement]:
    """The trial of a cell, or that of the settings and the seed."""
    if options.cell is not None:
        name = options.cell.partition("/")[0]
        folders = [options.results] if options.results else [root / name for root in RESULTS]
        folder = next((found for found in folders if found.is_dir()), folders[0])
        return trial_of(find_record(options.cell, folder))
    settings = read_settings(options)
    offset, mass_scale = draw_placement(options.seed, settings.offset, settings.mass_spread)
    chosen = offset if options.offset is None else tuple(options.offset)
    return settings, Placement(chosen, options.mass_scale or mass_scale)


def camera_of(options: argparse.Namespace, recording: Recording) -> Camera:
    """The chosen view; unless its distance is given, the wrist is always seen, and the object
    while the hand is near.
    """
    yaw, pitch = VIEWS[options.view]
    if recording.renderer.scene.wall is not None:
        yaw = -yaw  # else the wall stands between
    yaw, pitch = options.camera or (yaw, pitch)
    way = recording.way
    low, high = way.min(axis=0) - MARGIN, way.max(axis=0) + MARGIN
    width, height = options.size
    opening = math.tan(math.radians(0.5 * Camera.view_angle)) * min(1.0, width / height)
    distance = options.distance or 0.5 * float(np.max(high - low)) / opening
    x, y, z = (0.5 * (low + high)).tolist()
    return Camera(target=(x, y, z), distance=distance, yaw=yaw, pitch=pitch)


def draw(
    recording: Recording,
    film: Film,
    size: tuple[int, int],
    camera: Camera,
    by_pressure: bool = False,
    tell: Callable[[str, int, int], None] = lambda step, done, count: None,
) -> None:
    """Draw all states of a recording, actuators in one colour or by their pressure; `tell` gets how
    many are done, of how many.
    """
    renderer = recording.renderer
    for done, state in enumerate(recording.states, start=1):
        if by_pressure:
            hand = renderer.layout.description
            renderer.colors.update(actuator_colors(hand, recording.pressures[done - 1]))
        film.add(renderer.frame(state, size, camera))
        tell("pictures", done, len(recording.states))


if __name__ == "__main__":
    sys.exit(main())
