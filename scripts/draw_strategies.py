"""Draw the grasps that use the environment, one row of frames per grasp:
docs/figures/strategies.png.
"""

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from grasp_strategies.strategy import load_strategy
from pneuflex_sim.pictures.render import Camera
from pneuflex_sim.scene.objects import load_object
from softhand_bringup.film.recording import film_trial
from softhand_common.documents.output_file import save_figure
from softhand_trials.trials import Placement, TrialSettings

PICTURE = Path("docs/figures/strategies.png")
ROWS = {  # strategy: object, camera (yaw, pitch [deg]), what it shows
    "rbo_hand_1_push": ("cylinder", (40.0, -25.0), "push"),
    "rbo_hand_1_surface": ("tube", (40.0, -20.0), "table"),
    "rbo_hand_1_edge": ("rod", (25.0, -12.0), "edge"),
    "rbo_hand_2_slide_to_wall": ("thin_cylinder", (-35.0, -12.0), "wall"),
}
STEP, INTERVAL, SIZE = 0.005, 0.1, (360, 300)
COUNT = 6  # frames of a row
FROM = 0.12  # share of the recording before the first of them


def frames(name: str, object_name: str, angles: tuple[float, float]) -> list[np.ndarray]:
    """Pictures of a grasp in the scene that its strategy was tried in; raises ValueError when it
    fails.
    """
    tried, thing = load_strategy(name).tried_with, load_object(object_name)
    upright = (0.0, 0.0, 0.0) if object_name in tried.upright else None
    settings = TrialSettings(
        name,
        object_name,
        tried.scene,
        tried.model or None,
        STEP,
        tried.segments,
        wall_inclination=tried.wall_inclination,
        object_rpy=upright,
    )
    place = tried.place or replace(thing, rpy=upright or thing.rpy).corner_place
    recording = film_trial(settings, Placement(place), INTERVAL)
    if not recording.ending.startswith("gripped"):
        raise ValueError(f"{name}: expected a grasp, got {recording.ending}")
    chosen = np.linspace(FROM * len(recording.states), len(recording.states) - 1, COUNT).astype(int)
    camera = Camera(
        target=(place[0], place[1], 0.08), distance=0.55, yaw=angles[0], pitch=angles[1]
    )
    return [recording.renderer.frame(recording.states[k], SIZE, camera) for k in chosen]


def main() -> None:
    """Draw all rows."""
    figure, panels = plt.subplots(len(ROWS), COUNT, figsize=(12.0, 7.0), layout="constrained")
    for row, (name, (object_name, angles, label)) in zip(panels, ROWS.items(), strict=True):
        for panel, picture in zip(row, frames(name, object_name, angles), strict=True):
            panel.imshow(picture)
            panel.set(xticks=[], yticks=[])
        row[0].set_ylabel(label, fontsize=12)
    save_figure(figure, PICTURE, dpi=90, metadata={"Software": None})
    print(PICTURE)


if __name__ == "__main__":
    main()
