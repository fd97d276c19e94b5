"""Lines of results that are read back: each field of its kind, or refused with its place."""

import json

import pytest

from softhand_trials.sweep.command import main
from softhand_trials.sweep.results import find_record, read_results
from softhand_trials.sweep.trial_task import trial_of

TRIAL = {
    "key": "map/ball/0,0/1",
    "digest": "0b4c",
    "object": "ball",
    "cell": [0.0, 0.0],
    "replicate": 1,
    "settings": {"step": 0.01, "segments": 2, "options": ["slow"], "hand": None},
    "placement": {"offset": [0.0, 0.001], "mass_scale": 1.1, "yaw": -0.1, "friction_scale": 0.9},
    "outcome": "none",
    "cause": "missed",
    "phase": "close",
    "failed_at": 0.1,
    "wall_time": 1.0,
    "cpu_time": 0.5,
    "versions": {"code": "1"},
}


@pytest.fixture
def written(tmp_path):
    def write(**changed):
        lines = [TRIAL, {k: v for k, v in (TRIAL | changed).items() if v is not ...}]
        text = "".join(json.dumps(line) + "\n" for line in lines)
        (tmp_path / "results.jsonl").write_text(text)
        return tmp_path

    return write


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"key": ...}, "document: expected the field key"),
        ({"key": 3}, "key: expected text"),
        ({"key": "x" * 501}, "key: expected text of at most 500"),
        ({"cell": ...}, "document: expected the field cell"),
        ({"cell": [0.0]}, "cell: expected 2 numbers"),
        ({"cell": [0.0, 1e3]}, r"cell\[1\]: expected a number from -10 to 10 m"),
        ({"cell": None}, "cell: expected a list"),
        ({"replicate": True}, "replicate: expected a whole number"),
        ({"outcome": ...}, "document: expected the field outcome"),
        ({"outcome": []}, "outcome: expected text"),
        ({"phase": ...}, "document: expected the field `phase`"),
        ({"cause": 1}, "cause: expected text"),
        ({"versions": {}}, "versions: expected the field code"),
        ({"versions": {"code": 1}}, r"versions\.code: expected text"),
        ({"cpu_time": "1"}, "cpu_time: expected a number"),
        ({"cpu_time": 1e300}, "cpu_time: expected a number"),
        ({"placement": {"offset": [0.0]}}, r"placement\.offset: expected 2 numbers"),
        ({"placement": {"offset": [0, 0], "mass": 1}}, "placement: expected only the keys"),
        ({"settings": {"segments": 0.5}}, r"settings\.segments: expected a whole number"),
        ({"settings": {"displacement": [1]}}, r"settings\.displacement: expected 3 numbers"),
        ({"settings": []}, "settings: expected a mapping"),
        ({"failed_at": -1}, "failed_at: expected a number"),
    ],
)
def test_a_line_that_is_no_trial_is_refused_in_one_line(written, capsys, changed, named):
    folder = written(**changed)
    assert main(["report", str(folder)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    with pytest.raises(ValueError, match=rf"results\.jsonl:2: {named}"):
        raise ValueError(line)


@pytest.mark.parametrize(
    "text",
    [pytest.param("[" * 100_000, id="deep"), '{"key": NaN}', '{"key": 1e999}', "\xff", "[]"],
)
def test_what_is_no_record_is_refused(tmp_path, text):
    (tmp_path / "results.jsonl").write_bytes(text.encode("latin-1") + b"\n")
    with pytest.raises(ValueError, match=r"results\.jsonl:1: "):
        read_results(tmp_path)


def test_a_line_without_end_is_not_read_whole(tmp_path):
    (tmp_path / "results.jsonl").write_bytes(b" " * 2**23 + b"\n")
    with pytest.raises(ValueError, match=r"results\.jsonl:1: expected at most 4194304 bytes"):
        read_results(tmp_path)


def test_sound_lines_are_read_as_they_are(written):
    folder = written(key="map/ball/0,0/2", cause=None or "")
    first, second = read_results(folder, ("cell", "settings"), "outcome")
    assert first == TRIAL and second == TRIAL | {"key": "map/ball/0,0/2", "cause": ""}
    settings, placement = trial_of(find_record("map/ball/0,0", folder))
    assert settings.options == ("slow",) and placement.offset == (0.0, 0.001)


def test_fields_of_other_lines_are_their_own(tmp_path):
    line = {"key": "a/1", "digest": "0", "object": [[0.1], [1.0]], "held": True}
    (tmp_path / "results.jsonl").write_text(json.dumps(line) + "\n")
    assert read_results(tmp_path) == [line]


def test_settings_of_another_version_are_named(written):
    folder = written(key="map/ball/0,0/2", settings={"glue": 1})
    with pytest.raises(ValueError, match=r"map/ball/0,0/2: settings: expected .* got glue"):
        trial_of(find_record("map/ball/0,0/2", folder))
