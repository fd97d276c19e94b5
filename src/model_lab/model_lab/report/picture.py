"""Pictures as PNG files: of a diagnosis, and of a figure whose panels stand in a row."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.load import load_measurements
from model_lab.report.curves import curve_keys, panels_of
from model_lab.report.drawing import PICTURE_WIDTH, Drawing, legend_above, paint, styled
from model_lab.report.errors import ladder_panel, ranking_panel
from model_lab.report.view import Repeats, View
from softhand_common.documents.output_file import save_figure
from softhand_model.model_file import load_model

PICTURE_PANELS = 4  # panels
HEIGHT, ROW_HEIGHT = 6.0, 3.55  # [in]
DPI = 130


def draw_picture(view: View, path: Path) -> None:
    """Write the picture of a diagnosis: some curves before and after, the errors of the models, and
    of each effect alone.
    """
    with styled():
        figure = Figure(figsize=(PICTURE_WIDTH, HEIGHT), layout="constrained")
        above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 1.25))[:, 0]
        paint(above, tuple(panels_of(view, _most_improved(view))), PICTURE_PANELS)
        left = replace(ladder_panel(view), title="held-out error; the noise floor in green")
        right = replace(ranking_panel(view), title="each effect alone; dashed: without any")
        paint(below, (left, right), 2)
        legend_above(figure, tuple(curve_keys(view)))
        save_figure(figure, path, dpi=DPI)


def draw_row(drawing: Drawing, path: Path) -> None:
    """Write the panels of a figure side by side, with its legend."""
    with styled():
        figure = Figure(figsize=(PICTURE_WIDTH, ROW_HEIGHT), layout="constrained")
        paint(figure, drawing.panels, len(drawing.panels))
        legend_above(figure, drawing.keys)
        save_figure(figure, path, dpi=DPI)


def _most_improved(view: View) -> list[Repeats]:
    """The panels in which most of the error lay before, in the order of the set."""
    error = view.before.held_out.residual

    def size(repeats: Repeats) -> float:
        return float(np.mean([np.mean(error[one.samples] ** 2) for one in repeats.courses]))

    panels = view.panels()
    largest = sorted(panels, key=size)[-PICTURE_PANELS:]
    return [repeats for repeats in panels if repeats in largest]


def main(arguments: Sequence[str] | None = None) -> int:
    """Diagnose a set and draw it: `python -m model_lab.report.picture SET MODEL OUT.png`."""
    parser = argparse.ArgumentParser(prog="picture", description="One picture of a diagnosis.")
    parser.add_argument("data", type=Path, help="measurement set")
    parser.add_argument("model", help="model file, or the name of a shipped one")
    parser.add_argument("out", type=Path, help="PNG file")
    options = parser.parse_args(arguments)
    try:
        data = load_measurements(options.data)
        draw_picture(View(diagnose(data, load_model(options.model))), options.out)
    except ValueError as error:
        print(f"picture: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
