"""Files that a set names: tables of their own, never a device, nor a refusal without its place."""

import re
import shutil
from pathlib import Path

import pytest

from model_lab.measurements import csv_file
from model_lab.measurements.load import load_measurements
from softhand_common.documents.yaml_document import DocumentError

SET = Path(__file__).parents[3] / "examples" / "measurements" / "finger"


@pytest.fixture
def naming(tmp_path):
    """A set whose first run names another file."""

    def write(name):
        folder = tmp_path / "set"
        shutil.copytree(SET, folder)
        path = folder / "experiment.yaml"
        path.write_text(path.read_text().replace("file: thin_ramp_1.csv", f"file: {name}"))
        assert name in path.read_text()
        return folder

    return write


WRONG = {
    "/dev/zero": "/dev/zero: expected a CSV file, got a folder or a device",
    '"a\\0b"': "expected a path of at most 500 characters, 255 between slashes, without null",
    "x/" * 251: "expected a path of at most 500 characters",
    "x" * 300: "expected a path of at most 500 characters, 255 between slashes",
    "..": "expected a CSV file, got a folder or a device",
    "nowhere.csv": "nowhere.csv: expected a CSV file, got No such file or directory",
    "loop.csv": "loop.csv: expected a CSV file, got Too many levels of symbolic links",
}


@pytest.mark.parametrize(("name", "named"), WRONG.items())
def test_a_file_that_is_no_table_is_refused_where_it_is_named(naming, name, named):
    folder = naming(name)
    (folder / "loop.csv").symlink_to("loop.csv")
    with pytest.raises(DocumentError, match=named) as caught:
        load_measurements(folder)
    assert re.search(r"experiment\.yaml:\d+: runs\.\w+\.file: ", str(caught.value))
    assert len(str(caught.value)) < 600


SECRETS = {
    "header": b"secret\n1\n",
    "cells": b"time,pressure,tip_angle\n0,secret,0\n",
    "bytes": b"secret\xff\n",
    "passwd": Path("/etc/passwd").read_bytes(),
    "empty": b"\nsecret",
}


@pytest.mark.parametrize("content", SECRETS.values(), ids=SECRETS)
def test_a_file_elsewhere_is_refused_without_what_it_holds(naming, tmp_path, content):
    (tmp_path / "foreign").write_bytes(content)
    for name in ("../foreign", str(tmp_path / "foreign"), "link"):
        folder = naming(name)
        (folder / "link").symlink_to(tmp_path / "foreign")
        with pytest.raises(DocumentError, match=r"yaml:\d+: runs\.\w+\.file: \S+: ") as caught:
            load_measurements(folder)
        for word in ("secret", "root:", "0xff"):
            assert word not in str(caught.value)
        shutil.rmtree(folder)


def test_a_wrong_table_of_the_set_is_refused_with_what_it_holds(naming):
    folder = naming("own.csv")
    (folder / "own.csv").write_text("other\n1\n")
    with pytest.raises(DocumentError, match=r"own\.csv: header: .* got other; name it so"):
        load_measurements(folder)


def test_a_table_that_is_too_large_is_not_read(naming, monkeypatch):
    monkeypatch.setattr(csv_file, "LARGEST_FILE", 100)
    with pytest.raises(DocumentError, match=r"\.csv: expected at most 100 bytes, got \d+"):
        load_measurements(naming("thin_ramp_1.csv"))


def test_a_bag_that_is_none_is_refused_where_it_is_named(naming):
    folder = naming("thin_ramp_1.csv")
    path = folder / "experiment.yaml"
    topics = "{pressure: {topic: a, field: b}, tip_angle: {topic: a, field: c}}"
    path.write_text(
        path.read_text().replace("file: thin_ramp_1.csv", f"bag: /dev/zero, topics: {topics}")
    )
    with pytest.raises(DocumentError, match=r"\.bag: /dev/zero: expected a rosbag2 folder"):
        load_measurements(folder)
