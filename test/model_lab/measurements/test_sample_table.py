"""The sample table: order, folds, repeats, bootstrap blocks."""

import numpy as np
import pytest

from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from model_lab.measurements.sample_table import make_table

TORQUES = ("torque_x", "torque_y", "torque_z")


def torque_run(name, protocol, samples, first, temperature=293.15, **more):
    columns = {
        output: first + 100.0 * place + np.arange(samples)
        for place, output in enumerate(TORQUES)
        if output not in more.get("without", ())
    }
    columns["time"] = np.arange(samples) + 0.5 * first
    return Run(name, "f", protocol, temperature, columns)


def torque_set(*runs):
    return MeasurementSet("base_torque", "", {"f": Specimen("f")}, runs)


def test_rows_go_run_after_run_and_output_after_output_within_a_run():
    table = torque_set(torque_run("a", "p", 2, 0.0), torque_run("b", "q", 3, 10.0)).table
    assert table.run.tolist() == [0] * 6 + [1] * 9
    assert table.output.tolist() == [0, 0, 1, 1, 2, 2, 0, 0, 0, 1, 1, 1, 2, 2, 2]
    assert table.row.tolist() == [0, 1] * 3 + [2, 3, 4] * 3
    assert table.value.tolist() == [
        *[0.0, 1.0, 100.0, 101.0, 200.0, 201.0],
        *[10.0, 11.0, 12.0, 110.0, 111.0, 112.0, 210.0, 211.0, 212.0],
    ]


def test_an_output_that_a_run_lacks_is_not_a_number():
    table = torque_set(torque_run("a", "p", 2, 0.0, without=("torque_y",))).table
    assert np.isnan(table.value).tolist() == [False, False, True, True, False, False]


def test_a_recorded_column_is_repeated_for_every_output():
    data = torque_set(torque_run("a", "p", 2, 0.0), torque_run("b", "q", 1, 10.0))
    assert data.column("time").tolist() == [0.0, 1.0] * 3 + [5.0] * 3


def test_protocols_are_held_out_with_all_their_repeats():
    runs = [torque_run(n, p, 4, 0.0) for n, p in [("a", "up"), ("b", "down"), ("c", "up")]]
    table = torque_set(*runs).table
    assert (table.holdout, table.folds) == ("protocols", ("up", "down"))
    assert table.fold.tolist() == [0] * 12 + [1] * 12 + [0] * 12
    assert table.group.tolist() == [0] * 12 + [1] * 12 + [0] * 12


def test_a_run_at_another_temperature_is_no_repeat():
    runs = torque_run("a", "p", 1, 0.0), torque_run("b", "p", 1, 0.0, temperature=313.15)
    assert torque_set(*runs).table.group.tolist() == [0] * 3 + [1] * 3


def test_with_one_protocol_every_fifth_block_is_held_out():
    table = make_table([np.zeros((1, 20))], [[0]], ["p"])
    assert table.holdout == "blocks" and len(table.folds) == 5
    assert table.fold.tolist() == [fold for fold in (0, 1, 2, 3, 4) * 2 for _ in range(2)]


def test_courses_are_whole_and_series_end_where_the_fold_changes():
    table = make_table([np.zeros((2, 20))], [[0]], ["p"])
    assert [(part.output, part.start, part.stop) for part in table.courses] == [
        (0, 0, 20),
        (1, 20, 40),
    ]
    assert [part.length for part in table.series] == [2] * 20
    assert [part.fold for part in table.series] == [0, 1, 2, 3, 4] * 4


@pytest.mark.parametrize(("runs", "blocks"), [(3, 24), (8, 8)])
def test_few_runs_are_cut_into_blocks_for_the_bootstrap(runs, blocks):
    table = make_table([np.zeros((1, 80))] * runs, [[r] for r in range(runs)], ["p"] * runs)
    assert int(table.block.max()) + 1 == blocks
    assert table.blocks_are_runs == (runs >= 8)


def test_values_of_a_run_come_by_output():
    data = torque_set(torque_run("a", "p", 2, 0.0), torque_run("b", "q", 3, 10.0))
    part = data.table.of_run(np.arange(15.0), 1)
    assert part.tolist() == [[6.0, 7.0, 8.0], [9.0, 10.0, 11.0], [12.0, 13.0, 14.0]]
