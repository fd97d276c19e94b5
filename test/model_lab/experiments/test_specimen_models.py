"""Steps through runs: durations, runs of different length, values that belong to the specimen."""

import numpy as np
from lab_sets import measured, run, specimen

from model_lab.experiments.samples import SampleRows
from model_lab.experiments.specimen_models import SpecimenMemory
from softhand_model.effects import ElasticEffect
from softhand_model.effects.pipeline import StagedEffects


class Peak(ElasticEffect):
    """Keeps the largest value that it was shown, over all runs of a specimen."""

    name = "peak"
    has_memory = True
    largest = {"value": 0.0}  # noqa: RUF012


def sums(rows, values):
    """Durations so far, and the values, added up over each run."""
    state = {"time": 0.0, "sum": 0.0}

    def step(value, dt):
        state["time"] = state["time"] + dt
        state["sum"] = state["sum"] + value
        return state["time"] + 100.0 * state["sum"]

    return rows.in_steps(step, values)[0, :, 0]


def two_runs(**second):
    first = run("a", [0.0, 0.5, 2.0], pressure=np.array([1.0, 2.0, 3.0]))
    return [first, run("b", [7.0, 8.0], pressure=np.array([5.0, 5.0]), **second)]


def test_every_run_is_stepped_by_its_own_clock():
    data = measured("free_bending", two_runs())
    rows = SampleRows(data)
    found = sums(rows, rows.column("pressure"))
    assert found.tolist() == [100.0, 300.5, 602.0, 500.0, 1001.0]
    assert rows.run.tolist() == [0, 0, 0, 1, 1]
    assert rows.peaks(rows.column("pressure"))[0, :, 0].tolist() == [3.0, 5.0]


def test_steady_run_has_been_at_its_first_sample_for_long():
    data = measured("free_bending", two_runs(steady=True))
    rows = SampleRows(data)
    found = sums(rows, rows.column("pressure"))
    assert found[:3].tolist() == [100.0, 300.5, 602.0]
    assert found[3] > 1e11


def largest_at_each_sample(runs, *specimens):
    data = measured("free_bending", runs, *specimens)
    rows = SampleRows(data)
    staged = StagedEffects([Peak()])

    def begin():
        staged.reset()

        def step(value, dt):
            memory = staged.memory["peak"]
            memory["value"] = np.maximum(memory.get("value", 0.0), value)
            return memory["value"]

        return step

    memory = SpecimenMemory(rows)
    return memory.in_steps(begin, staged, rows.column("pressure"))[0, :, 0].reshape(len(runs), -1)


def test_largest_value_goes_from_run_to_run_of_a_specimen():
    def pulled(name, top, **options):
        return run(name, [0.0, 1.0], pressure=np.array([1.0, top]), **options)

    found = largest_at_each_sample(
        [
            pulled("a", 4.0),
            pulled("b", 9.0, of="twin"),
            pulled("c", 2.0),
            pulled("d", 6.0),
            pulled("e", 2.0),
            pulled("f", 3.0, virgin=True),
            pulled("g", 2.0),
            pulled("h", 2.0, of="twin"),
        ],
        specimen(),
        specimen("twin"),
    )
    expected = [[1, 4], [1, 9], [4, 4], [4, 6], [6, 6], [1, 3], [3, 3], [9, 9]]
    assert found.tolist() == expected
