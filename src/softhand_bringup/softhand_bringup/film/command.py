"""The command `softhand film`: writes a grasp as pictures, GIF or MP4, from a trial or a bag."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from pneuflex_sim.pictures.render import Camera
from pneuflex_sim.pictures.surfaces import actuator_colors
from pneuflex_sim.scene.scenes import load_scene
from softhand_bringup.film.recording import Recording, film_bag, film_trial
from softhand_bringup.film.writing import Film, open_film
from softhand_common.progress import Progress
from softhand_trials.sweep.results import find_record
from softhand_trials.sweep.trial_task import trial_of
from softhand_trials.trials import (
    Placement,
    TrialSettings,
    add_settings,
    draw_placement,
    read_settings,
)

CAMERA_VIEWS = {  # yaw, pitch [deg]
    "oblique": (62.0, -16.0),
    "front": (90.0, -8.0),
    "side": (0.0, -8.0),
    "top": (90.0, -75.0),
}
RESULT_FOLDERS = (Path("out/thesis"), Path("out/sweeps"))  # with a folder for each sweep
VIEW_MARGIN = 0.08  # around the paths of wrist and object [m]


def parser() -> argparse.ArgumentParser:
    """The command line."""
    found = argparse.ArgumentParser(
        prog="softhand film",
        description="Run one trial of a grasp without ROS, or read a bag, and draw it. A second of "
        "film is a second of simulated time, unless --slow or --every is given.",
    )
    add = found.add_argument
    add("-o", "--out", type=Path, required=True, help="a .gif, a .mp4, or a folder for PNG files")
    add("--bag", type=Path, help="draw this recording instead of a trial")
    add("--cell", help="play this trial of a sweep, such as push_map/marker/20,0 or .../20,0/1")
    add("--results", type=Path, help="folder of the sweep's results (of its name, in out/)")
    add("--hand", help="hand of the recording (rbo_hand_2), or to replace the strategy's")
    add_settings(found)
    add("--seed", type=int, default=0, help="draws shift and mass of the object, as in trials")
    add("--offset", nargs=2, type=float, metavar=("X", "Y"), help="shift of the object [m]")
    add("--mass-scale", type=_positive, help="factor on the mass of the object")
    add("--fps", type=_positive, default=25.0, help="frames per second of film (%(default)s)")
    pace = found.add_mutually_exclusive_group()
    pace.add_argument("--slow", type=_positive, default=1.0, help="4: slow motion, 4 times as long")
    pace.add_argument("--every", type=_positive, help="simulated time between frames [s]")
    add("--size", type=_size, default=(640, 480), metavar="WxH", help="in pixels (640x480)")
    add(
        "--view",
        choices=CAMERA_VIEWS,
        default="oblique",
        help="direction of the camera (%(default)s)",
    )
    add("--camera", nargs=2, type=float, metavar=("YAW", "PITCH"), help="[deg], in place of --view")
    add("--distance", type=_positive, help="of the camera [m] (so that the hand stays in view)")
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
    """Write a film; returns 0, or 2 when the options cannot be used."""
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
    with film, Progress("drawing") as progress:
        draw(recording, film, options.size, camera, options.pressure, progress)
    if options.out.suffix:
        print(f"{options.out}: {count / options.fps:.2f} s at {options.fps:g} pictures a second")
    else:
        print(f"{options.out}: {count} PNG files, one each {recording.interval:g} s of simulation")
    return 0


def _record(options: argparse.Namespace) -> Recording:
    """Run the trial or read the bag of the options."""
    interval = options.every or 1.0 / (options.fps * options.slow)
    if options.bag is not None:
        scene = load_scene(options.scene).inclined(options.wall_inclination)
        hand = options.hand or "rbo_hand_2"
        return film_bag(options.bag, interval, hand, options.object, scene)
    settings, placement = trial_asked_for(options)
    return film_trial(settings, placement, interval)


def trial_asked_for(options: argparse.Namespace) -> tuple[TrialSettings, Placement]:
    """Settings and placement of the trial that the options ask for: that of a cell in results, or
    one from settings and seed.

    Raises ValueError for a cell that is not in the results.
    """
    if options.cell is not None:
        name = options.cell.partition("/")[0]
        folders = [options.results] if options.results else [root / name for root in RESULT_FOLDERS]
        folder = next((found for found in folders if found.is_dir()), folders[0])
        return trial_of(find_record(options.cell, folder))
    settings = read_settings(options)
    offset, mass_scale = draw_placement(options.seed, settings.offset, settings.mass_spread)
    chosen = offset if options.offset is None else tuple(options.offset)
    return settings, Placement(chosen, options.mass_scale or mass_scale)


def camera_of(options: argparse.Namespace, recording: Recording) -> Camera:
    """The camera of the chosen view. Unless its distance is given, the wrist is always in view, and
    so is the object while it is near the hand.
    """
    yaw, pitch = CAMERA_VIEWS[options.view]
    if recording.renderer.scene.wall is not None:
        yaw = -yaw  # else the wall would hide the hand
    yaw, pitch = options.camera or (yaw, pitch)
    path = recording.path
    low, high = path.min(axis=0) - VIEW_MARGIN, path.max(axis=0) + VIEW_MARGIN
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
    progress: Callable[[str, int, int], None] = lambda step, done, count: None,
) -> None:
    """Draw all states of a recording.

    Args:
        recording: the states and their renderer.
        film: the film to which the frames are appended.
        size: (width, height) of a frame [pixels].
        camera: the view.
        by_pressure: whether actuators are coloured by their pressure.
        progress: called with the name of the step, the number of drawn frames and the number of all
            frames.
    """
    renderer = recording.renderer
    for done, state in enumerate(recording.states, start=1):
        if by_pressure:
            hand = renderer.layout.description
            renderer.colors.update(actuator_colors(hand, recording.pressures[done - 1]))
        film.add(renderer.frame(state, size, camera))
        progress("pictures", done, len(recording.states))


if __name__ == "__main__":
    sys.exit(main())
