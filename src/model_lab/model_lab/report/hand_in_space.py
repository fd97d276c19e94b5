"""The measured and the predicted hand in space: `python -m model_lab.report.hand_in_space SET
MODEL... OUT.png`, one panel for each model, in the pose in which the first model errs most.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.forward import Forward
from model_lab.experiments.hand_pose import HAND_SEGMENTS, with_weight
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet, Run, down_of
from softhand_common.documents.output_file import save_figure
from softhand_model.effects.load import STANDARD_GRAVITY
from softhand_model.equilibrium.hand_statics import settled_hand
from softhand_model.model_file import Model, load_model

Picture = Callable[[MeasurementSet, Sequence[tuple[str, Model]], Path], None]
"""Writes a picture of a set and of models, by name, to a file."""

VIEW = {"elev": 18.0, "azim": 35.0}  # [deg]
LINE_SHARES = np.linspace(0.0, 1.0, 25)  # shares of a finger's length at which its line is drawn


def draw(data: MeasurementSet, models: Sequence[tuple[str, Model]], out: Path) -> None:
    """Write a picture of a set of a hand: measured markers, and chains and markers as each of the
    (name, model) predicts them.
    """
    from matplotlib.figure import Figure  # here, as it takes long to load

    run, sample = _worst(data, with_weight(data, models[0][1]))
    figure = Figure(figsize=(5.2 * len(models), 5.4), layout="constrained")
    for place, (name, model) in enumerate(models, 1):
        axes = figure.add_subplot(1, len(models), place, projection="3d")
        _panel(axes, data, run, sample, with_weight(data, model))
        axes.set_title(name)
    save_figure(figure, out, dpi=110)


def _worst(data: MeasurementSet, model: Model) -> tuple[Run, int]:
    """Run and sample with the largest error of a marker."""
    forward = Forward(data, fixed=model.effects, calibration=model.calibration)
    error = np.abs(forward.measured - forward.predict(forward.start()[None])[0])
    worst = int(np.nanargmax(error))
    run, row = int(data.table.run[worst]), int(data.table.row[worst])
    return data.runs[run], row - sum(one.samples for one in data.runs[:run])


def _panel(axes: Any, data: MeasurementSet, run: Run, sample: int, model: Model) -> None:
    """Draw one model in mm: chains as lines, what is measured as dots, errors as red lines."""
    pressures = np.array([[run.columns[name][sample]] for name in data.pressures])
    gravity = STANDARD_GRAVITY * down_of(run)[None]
    segments = data.hand_segments or HAND_SEGMENTS
    chain_of = {name: chain.name for chain in data.hand.chains for name in chain.actuators}
    for body, shape in settled_hand(data.hand, model, segments, pressures, gravity):
        for name, joints in body.joints.items():
            line = shape.places[0, joints]
            if not data.hand.chain(name).turn:
                rubber = [body.point(shape, name, at, np.zeros(3))[0] for at in LINE_SHARES]
                line = np.concatenate([line[:1], rubber])
            axes.plot(*(1e3 * line.T), color="tab:blue", linewidth=3)
        for name, marker in data.markers.items():
            if marker.actuator in body.actuators:
                chain, offset = chain_of[marker.actuator], np.array(marker.offset)
                predicted = body.point(shape, chain, marker.at, offset)[0]
                _marker(axes, predicted, _measured(run, sample, name))
    axes.set_aspect("equal")
    axes.view_init(**VIEW)
    for axis in "xyz":
        getattr(axes, f"set_{axis}label")(f"{axis} [mm]")
        axes.locator_params(axis, nbins=4)


def _marker(axes: Any, predicted: Array, measured: Array) -> None:
    off = 1e3 * np.stack([predicted, measured])
    axes.plot(*off.T, color="tab:red", linewidth=1.5)
    axes.scatter(*off[1], color="black", s=22)


def _measured(run: Run, sample: int, marker: str) -> Array:
    return np.array([run.columns[f"{marker}.{axis}"][sample] for axis in "xyz"])


def main(
    arguments: Sequence[str] | None = None, picture: Picture = draw, name: str = "hand_in_space"
) -> int:
    """Draw what the command line asks for. The exit status is 2, with one line that says why, if
    that is not possible.
    """
    parser = argparse.ArgumentParser(name, description=__doc__)
    parser.add_argument("set", metavar="SET", type=Path, help="folder of a set of a hand")
    parser.add_argument("models", metavar="MODEL", nargs="+", help="name or file of a model")
    parser.add_argument("out", metavar="OUT.png", type=Path, help="picture to write")
    given = parser.parse_args(arguments)
    try:
        data = load_measurements(given.set)
        if not data.of_hand:
            raise ValueError(f"{given.set}: expected a set of a hand, got {data.experiment}")
        picture(data, [(Path(file).stem, load_model(file)) for file in given.models], given.out)
    except ValueError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
