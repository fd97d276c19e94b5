"""One run in the dialects of laboratories is the same numbers, or is not loaded without a word."""

import dialects
import numpy as np
import pytest

from model_lab.cli.main import main
from model_lab.measurements.load import load_measurements

HAND = "rbo_hand_2:index"


def imported(file, out, *options):
    assert main(["import", str(file), "-o", str(out), "--hand", HAND, "--yes", *options]) == 0
    (run,) = load_measurements(out).runs
    return run


@pytest.mark.parametrize("dialect", dialects.WRITERS)
def test_a_run_in_a_dialect_is_the_same_numbers(dialect, tmp_path):
    run = imported(dialects.WRITERS[dialect](tmp_path), tmp_path / "set")
    assert run.samples == len(dialects.TIME)
    time = run.columns["time"]
    np.testing.assert_allclose(time - time[0], dialects.TIME, atol=2e-5)
    np.testing.assert_allclose(run.columns["pressure"], 1e3 * dialects.PRESSURE, atol=0.02)
    np.testing.assert_allclose(run.columns["tip_angle"], np.radians(dialects.ANGLE), atol=1e-4)


# ---------------------------------------------------------------------- nothing without a word
HEADER = "time [s];pressure [Pa];tip_angle [deg]"
ROWS = [f"{0.1 * n:.2f};{900.0 + 100.0 * n:.1f};{2.0 * n:.2f}" for n in range(60)]


def written(tmp_path, lines, name="run_1.csv"):
    (tmp_path / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return tmp_path / name


def said(tmp_path, lines, capsys, *options):
    """What the import says, and the columns that it wrote; None if it wrote none."""
    command = ["import", str(written(tmp_path, lines)), "-o", str(tmp_path / "set")]
    done = main([*command, "--hand", HAND, "--yes", *options])
    output = capsys.readouterr()
    if done == 2:
        return output.err, None
    return output.out, load_measurements(tmp_path / "set").runs[0].columns


def with_row(number, row):
    return [HEADER, *ROWS[:number], row, *ROWS[number + 1 :]]


REFUSED = {
    "thousands or decimals": (
        [HEADER, *(f"{n};{n},{100 + n};{n}" for n in range(1, 60))],
        ["column pressure", "1,101", "--decimal comma"],
    ),
    "points or thousands": (
        [HEADER, *(f"{n};{10 * n if n < 9 else f'{n}.{100 + n}'};{n}" for n in range(1, 60))],
        ["column pressure", "9.109", "--decimal"],
    ),
    "points and commas": (
        [HEADER, *(f"{n};{n}{'.,'[n % 2]}5;{n}" for n in range(60))],
        ["column pressure", "points as well as decimal commas"],
    ),
    "words in a tenth of the rows": (
        [HEADER, *(row if n % 10 else "1.0;OVERFLOW;2.0" for n, row in enumerate(ROWS))],
        ["column pressure", "OVERFLOW", "5 more cells"],
    ),
    "a second table": (
        [HEADER, *ROWS[:30], "time [s];pressure [kPa];tip_force [N]", *ROWS[30:]],
        ["one table", "tip_force"],
    ),
    "a clock that may be of hours or of minutes": (
        ["Time;p [Pa];angle [deg]", *(f"12:{n:02d};{n}.5;{n}.5" for n in range(60))],
        ["unit of Time", "Time:h", "Time:min"],
    ),
    "times in whole numbers": (
        ["time;p [Pa];angle [deg]", *(f"{20 * n};{n}.5;{n}.5" for n in range(60))],
        ["unit of time"],
    ),
    "no header": (ROWS, ["experiment"]),
    "rows that go back in time": (
        [HEADER, *ROWS[:20], *ROWS[10:]],
        ["column time", "row 21 of pressure", "sort"],
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_may_be_read_in_two_ways_is_not_loaded(case, tmp_path, capsys):
    lines, parts = REFUSED[case]
    message, columns = said(tmp_path, lines, capsys)
    assert columns is None and not (tmp_path / "set").exists()
    for part in parts:
        assert part in message, message
    assert len(message.splitlines()) == 1


def test_what_was_open_can_be_said(tmp_path, capsys):
    lines, _ = REFUSED["thousands or decimals"]
    for sign, value in (("comma", 1.101), ("point", 1101.0)):
        _, columns = said(tmp_path, lines, capsys, "--decimal", sign, "--force")
        assert columns["pressure"][0] == pytest.approx(value)
    lines, _ = REFUSED["a clock that may be of hours or of minutes"]
    for unit, step in (("h", 60.0), ("min", 1.0)):
        _, columns = said(tmp_path, lines, capsys, "--map", f"time=Time:{unit}", "--force")
        assert columns["time"][1] == pytest.approx(step)


def test_a_single_word_among_numbers_is_left_out_and_said(tmp_path, capsys):
    message, columns = said(tmp_path, with_row(10, "1.00;1900.0;lost"), capsys)
    assert "1 cells of tip_angle are not numbers" in message and "lost" in message
    assert len(columns["time"]) == len(ROWS) - 1 and 1.0 not in columns["time"]


def test_a_torn_row_is_left_out_and_said(tmp_path, capsys):
    message, columns = said(tmp_path, with_row(10, "1.00;1900.0"), capsys)
    assert "1 line without" in message and len(columns["time"]) == len(ROWS) - 1


def test_inputs_between_sparse_outputs_are_kept(tmp_path, capsys):
    rows = [row if n % 3 == 2 else row.rsplit(";", 1)[0] + ";" for n, row in enumerate(ROWS)]
    _, columns = said(tmp_path, [HEADER, *rows], capsys)
    assert columns["time"][0] == pytest.approx(0.2)
    assert len(columns["time"]) == 20


@pytest.mark.parametrize(("unit", "factor"), [("us", 1e6), ("ms", 1e3)])
def test_a_clock_since_the_start_of_a_board_is_no_epoch(tmp_path, capsys, unit, factor):
    rows = (f"{round((300.0 + 0.1 * n) * factor)};{n}.5;{n}.5" for n in range(60))
    _, columns = said(tmp_path, [f"t_{unit};p_Pa;angle_deg", *rows], capsys)
    np.testing.assert_allclose(columns["time"], 0.1 * np.arange(60), atol=1e-9)


def test_american_dates_over_midnight(tmp_path, capsys):
    days = ["03/01/2024 23:59:{:04.1f}", "03/02/2024 00:00:{:04.1f}"]
    stamps = [days[0].format(30.0 + n) for n in range(30)] + [
        days[1].format(float(n)) for n in range(30)
    ]
    rows = (f"{stamp};{n}.5;{n}.5" for n, stamp in enumerate(stamps))
    _, columns = said(tmp_path, ["date;p_Pa;angle_deg", *rows], capsys)
    np.testing.assert_allclose(columns["time"], np.arange(60.0), atol=1e-5)
