"""Long recordings made shorter: every k-th sample, as many as tell an effect.

A search tries some hundred models on every sample. Beyond some ten thousand of them the errors of
what it finds come from the few runs there are, not from the noise of samples.
"""

from __future__ import annotations

from dataclasses import replace

from model_lab.measurement import MeasurementSet, Run

LARGEST_SET = 30000  # samples that are searched
SHORTEST_RUN = 800  # samples that a run keeps


def thinned(data: MeasurementSet) -> MeasurementSet:
    """The set with every k-th sample of its longer runs, so that it is searched in a minute or two.

    Pulses, of which each counts, stay as they are.
    """
    samples = sum(run.samples for run in data.runs) * len(data.outputs)
    if samples <= LARGEST_SET or data.experiment == "valve_pulse":
        return data
    wanted = samples / LARGEST_SET
    return replace(data, runs=tuple(_thin(run, wanted) for run in data.runs))


def _thin(run: Run, wanted: float) -> Run:
    step = max(min(int(wanted + 0.5), run.samples // SHORTEST_RUN), 1)
    return replace(run, columns={name: values[::step] for name, values in run.columns.items()})
