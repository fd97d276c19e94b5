"""A measured and a predicted grasp in time: `python -m model_lab.report.grasp_in_time SET MODEL...
OUT.png`, in the run in which the first model errs most.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.forward import Forward
from model_lab.experiments.hand_grasp import held
from model_lab.experiments.hand_pose import with_weight
from model_lab.measurements.hands import GRASP, OBJECT_PLACE, WRENCH_COLUMNS
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.report.hand_in_space import main
from softhand_common.documents.output_file import save_figure
from softhand_model.model_file import Model


def draw(data: MeasurementSet, models: Sequence[tuple[str, Model]], out: Path) -> None:
    """Write a picture of a set of grasps: vertical force, pressures and height of the object, as
    measured and as predicted by each of the models (by name).

    Raises ValueError for a set of anything else.
    """
    from matplotlib.figure import Figure  # here, as it takes long to load

    if data.experiment != GRASP:
        raise ValueError(f"{data.folder}: expected a set of grasps, got {data.experiment}")
    predicted = {name: _predicted(data, model) for name, model in models}
    error = np.abs(data.table.value - predicted[models[0][0]])
    number = int(data.table.run[np.nanargmax(error)])
    run, scales = data.runs[number], data.output_scales[:, None]
    shown = (WRENCH_COLUMNS[2], *data.pressures, OBJECT_PLACE[2])
    figure = Figure(figsize=(7.0, 9.0), layout="constrained")
    panels = figure.subplots(len(shown), 1, sharex=True)
    for axes, name in zip(panels, shown, strict=True):
        display, place = data.display(name), data.outputs.index(name)
        axes.plot(run.columns["time"], display.factor * run.columns[name], "k.", label="measured")
        for model, values in predicted.items():
            course = data.table.of_run(values, number) / scales
            axes.plot(run.columns["time"], display.factor * course[place], label=model)
        axes.set_ylabel(f"{name} [{display.unit}]", fontsize=8)
    panels[0].legend(fontsize=8)
    panels[-1].set_xlabel("time [s]")
    counts = {"measured": held(data)} | {name: held(data, v) for name, v in predicted.items()}
    told = ", ".join(f"{name} {sum(of)} of {len(of)}" for name, of in counts.items())
    panels[0].set_title(f"run {run.name} ({run.protocol}); held at the end: {told}", fontsize=9)
    save_figure(figure, out, dpi=110)


def _predicted(data: MeasurementSet, model: Model) -> Array:
    """Predictions (samples,) of a model as its file has it."""
    weighty = with_weight(data, model)
    forward = Forward(data, fixed=weighty.effects, calibration=weighty.calibration)
    return forward.predict(forward.start()[None])[0]


if __name__ == "__main__":
    sys.exit(main(picture=draw, name="grasp_in_time"))
