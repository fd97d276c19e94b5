"""The bench of the pneumatic box: its rows, its file, and one group measured in a small version."""

import json

import pytest

from bench.pneumatics import __main__ as program
from bench.pneumatics.figures import ALONE, GROUPS, PARALLEL, Figure
from bench.pneumatics.measure import MEASURES, Size, exact_sensors, measure
from bench.pneumatics.table import row_of, rows_of, text_of
from thesis.chapter_4.boxes import box_of


@pytest.mark.parametrize(("most", "worst", "met"), [(True, 3.0, False), (False, 1.0, False)])
def test_the_worst_seed_is_held_against_the_target(most, worst, met):
    row = row_of(Figure("drift", "mg", "-", 2.0, most), {0: 1.0, 1: 3.0, 2: 2.5})
    assert (row["value"], row["median"], row["met"]) == (worst, 2.5, met)
    assert row["per_seed"] == {0: 1.0, 1: 3.0, 2: 2.5}


def test_a_figure_without_a_target_is_neither_met_nor_missed():
    row = row_of(Figure("ratio", "", "4"), {0: 5.0})
    assert row["met"] is None and row["thesis"] == "4"
    assert text_of([row]).splitlines()[1].split() == ["ratio", "4", "5", "5", "-", "-", "5"]


def test_every_group_is_measured_and_has_a_turn():
    assert set(GROUPS) == set(MEASURES) == {*PARALLEL, *ALONE}
    assert not set(PARALLEL) & set(ALONE)


def test_a_group_that_could_not_be_measured_is_left_out_and_fails_the_run(
    monkeypatch, tmp_path, capsys
):
    def results(jobs, size, workers):
        yield ("supply", 0), [3.0]
        yield ("loop", 0), None

    monkeypatch.setattr(program, "results", results)
    monkeypatch.chdir(tmp_path)
    assert program.main(["--seeds", "1", "--rows", "supply", "loop"]) == 1
    printed = capsys.readouterr()
    assert "loop, seed 0 could not be measured" in printed.err
    assert "change of tracking error" in printed.out
    written = json.loads((tmp_path / "out/bench/bench-pneumatics.json").read_text())
    assert [row["value"] for row in written["rows"]] == [3.0]
    assert written["rows"][0]["met"] is True and written["failed"] == [["loop", 0]]


def test_one_group_in_a_small_version_gives_a_value_for_each_figure():
    size = Size(points=24, tests=12, channels=1, duration=2.0, runs=1)
    found = measure("finger", 1, size)
    assert len(found) == len(GROUPS["finger"]) and 0 < found[0] < 20
    rows = rows_of(["finger"], {("finger", 1): found})
    assert rows[0]["per_seed"] == {1: found[0]}


def test_the_offset_that_is_added_is_the_only_error_of_the_sensors():
    assert exact_sensors(box_of(0)).channel_sensor.accuracy < 1e-6
