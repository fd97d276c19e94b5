"""What is quoted from outside is cut, whatever it is."""

import time

import numpy as np
import pytest

from softhand_common.documents.quoted import LONGEST_QUOTE, listed, quoted, shortened


def nested(depth):
    value = ["lol"] * 10
    for _ in range(depth):
        value = [value] * 10
    return value


@pytest.mark.parametrize(
    "value",
    [
        "x" * 10_000_000,
        ["x" * 1_000_000] * 10,
        nested(9),
        np.zeros(10**6),
        {"k" * 10**6: 1},
        b"\0" * 10**7,
    ],
    ids=["text", "texts", "nested", "array", "mapping", "bytes"],
)
def test_everything_long_is_cut_at_once(value):
    begun = time.process_time()
    assert len(quoted(value)) <= LONGEST_QUOTE
    assert time.process_time() - begun < 0.5


def test_what_is_short_is_shown_as_it_is():
    assert quoted("a'b") == '"a\'b"'
    assert quoted([1, 2.5, "x"]) == "[1, 2.5, 'x']"
    assert listed(["a", "b"]) == "a, b"
    assert listed([]) == "none"
    assert shortened("plain text") == "plain text"


def test_lists_and_text_are_cut_and_stay_in_one_line():
    assert len(listed(["name"] * 100_000)) <= LONGEST_QUOTE
    assert len(shortened("x" * 10**6)) <= LONGEST_QUOTE
    assert shortened("a\nb\x1b[31m") == r"a\nb\x1b[31m"
