"""Every command that writes, on a full disk."""

import pytest

from bench.robust.full_disk import WRITERS, Tried, try_writer


@pytest.mark.parametrize("name", WRITERS)
def test_nothing_is_lost_and_the_file_is_named(name):
    assert not try_writer(name).bad(name)


@pytest.mark.parametrize(
    ("tried", "bad"),
    [
        (Tried(None, "KeyError()", (), ()), "traceback"),
        (Tried(1, "softhand calibrate: {}/c.yaml: got", ("c.yaml",), ()), "lost"),
        (Tried(1, "softhand calibrate: {}/c.yaml: got", (), ("c.part",)), "left behind"),
        (Tried(0, "", (), ()), "exit status 0"),
        (Tried(1, "softhand calibrate: no space", (), ()), "no file named"),
        (Tried(1, "softhand calibrate: {}/c.yaml: got", (), ()), ""),
    ],
)
def test_what_goes_wrong_is_seen(tried, bad):
    found = tried.bad("calibrate")
    assert found.startswith(bad) and bool(found) == bool(bad)
