"""Pictures of the grasps of the Feix taxonomy, and the table for a person's verdicts."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pneuflex_sim.pictures.render import Camera, HandState, Renderer
from softhand_common.documents.output_file import write_file
from thesis.chapter_8.dexterity.feix import grasp_types
from thesis.chapter_8.dexterity.posture import FOUR
from thesis.frame import Array, Figure, Report, Results

SIZE = (16.0, 12.0)
COLUMNS = 6
PIXELS = 320
VIEWS = ((90.0, 0.0), (20.0, -20.0))  # yaw and pitch [deg]: from the palm's side, and aslant
CAMERA = {"target": (0.02, 0.0, 0.12), "distance": 4.0, "view_angle": 4.0}
WRIST = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
FILE = "verdicts.csv"
HUMAN = ("human_good", "human_remark")  # columns that a person fills in
COLORS = {True: "tab:green", False: "tab:red"}


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Two pictures per type, with the judge's verdicts (held, right parts) and the robust force."""
    found = results["cases"][FOUR]
    rows = -(-len(found) // COLUMNS)
    panels = figure.subplots(rows, min(COLUMNS, len(found)), squeeze=False).ravel()
    for panel in panels:
        panel.set_axis_off()
    for panel, (number, one), joints, pose in zip(
        panels, found.items(), results["joints"], results["objects"], strict=False
    ):
        kind, trials = grasp_types()[int(number)], one["trials"]
        if np.isfinite(joints).all():
            panel.imshow(picture(kind.object, joints, pose))
        held, typed = (sum(t.get(word, False) for t in trials) for word in ("held", "typed"))
        words = f"{number} {kind.name}\nheld {held}, right {typed} of {len(trials)}"
        good = held == len(trials) and typed == len(trials)
        panel.set_title(words, fontsize=8, color=COLORS[good])


def picture(object: str, joints: Array, pose: Array) -> Any:
    """A grasp from the views, side by side (height, 2 height, 3)."""
    renderer = Renderer("rbo_hand_2", object, "stand", _segments(len(joints)))
    state = HandState(joints, *WRIST, pose[:3], pose[3:])
    cameras = [
        Camera(**CAMERA, yaw=yaw, pitch=pitch, light=(1.6, -0.6, 1.2)) for yaw, pitch in VIEWS
    ]
    return np.hstack([renderer.frame(state, (PIXELS, PIXELS), camera) for camera in cameras])


def _segments(joints: int) -> int:
    """Segments per actuator of an RBO Hand 2 with that many joints: six chains, four struts."""
    return (joints - 4) // 6


# ---------------------------------------------------------------- a person's verdict
def write_verdicts(folder: Path, found: Mapping[str, Any]) -> None:
    """Write the table with the judge's verdicts and columns for a person, whose entries are
    kept.
    """
    before = human_verdicts(folder)
    columns = ("type", "name", "object", "machine_held", "machine_right", "robust", *HUMAN)
    file = io.StringIO(newline="")
    table = csv.DictWriter(file, columns)
    table.writeheader()
    for number, one in found.items():
        kind, trials = grasp_types()[int(number)], one["trials"]
        row = {
            "type": number,
            "name": kind.name,
            "object": kind.object,
            "machine_held": f"{sum(t.get('held', False) for t in trials)}/{len(trials)}",
            "machine_right": f"{sum(t.get('typed', False) for t in trials)}/{len(trials)}",
            "robust": f"{trials[0].get('robust', 0.0):.2f}",
        }
        table.writerow({**dict.fromkeys(HUMAN, ""), **row, **before.get(number, {})})
    write_file(folder / FILE, file.getvalue())


def human_verdicts(folder: Path) -> dict[str, dict[str, str]]:
    """A person's entries, by type; empty where there is none."""
    path = folder / FILE
    if not path.exists():
        return {}
    with path.open(newline="", encoding="utf-8") as file:
        return {row["type"]: {key: row[key] or "" for key in HUMAN} for row in csv.DictReader(file)}
