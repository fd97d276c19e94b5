"""Limits of YAML files: no text stops the reader, and every refusal names file and line."""

import time

import pytest

from softhand_common.documents.yaml_document import DocumentError, read_document
from softhand_common.documents.yaml_reading import (
    DEEPEST,
    LARGEST_DOCUMENT,
    LONGEST_KEY,
    MOST_VALUES,
)

LAUGHS = "".join(
    f"{name}: &{name} [{', '.join([f'*{before}'] * 10)}]\n"
    for before, name in zip("abcdefghi", "bcdefghij", strict=True)
)
HOSTILE = {
    "nested aliases": ("a: &a [lol, lol]\n" + LAUGHS, "x.yaml:6: expected at most"),
    "an alias of itself": ("b: 1\na: &a [*a]\n", "x.yaml:2: expected an anchor before its alias"),
    "400 digits": ("b: 1\na: " + "9" * 400, "x.yaml:2: expected a number of at most"),
    "5000 digits": ("b: 1\na: " + "9" * 5000, "x.yaml:2: expected a number of at most"),
    "sixties": ("a: 1" + ":00" * 200_000, "x.yaml:1: expected a number of at most"),
    "hexadecimal without digits": ("a: 0x_", "x.yaml:1: expected a number, got '0x_'"),
    "brackets": ("b: 1\na: " + "[" * 5000, f"x.yaml:2: expected at most {DEEPEST} levels"),
    "a closed bracket too deep": (
        "a: " + "[" * 40 + "]" * 40,
        f"x.yaml:1: expected at most {DEEPEST} levels",
    ),
    "dashes": ("- " * 5000, f"x.yaml:1: expected at most {DEEPEST} levels"),
    "a bool by tag": ("b: 1\na: !!bool abc", "x.yaml:2: expected a value without tag, got"),
    "a time by tag": ("a: !!timestamp abc", "x.yaml:1: expected a value without tag, got"),
    "an object by tag": ("a: !!python/object:os.system {}", "expected a value without tag"),
    "a list as key": (
        "b: 1\n? [1, 2]\n: 3\n",
        "x.yaml:2: expected a plain key, got",
    ),
    "a long key": (f"{'k' * 300}: 1", f"x.yaml:1: expected a key of at most {LONGEST_KEY}"),
    "a key twice": ("a: 1\nb: 2\na: 3\n", "x.yaml:3: expected every key once, got the key a twice"),
    "many values": (f"a: [{'1,' * MOST_VALUES}]", f"expected at most {MOST_VALUES} values"),
    "a large file": (
        "# " + "x" * LARGEST_DOCUMENT,
        f"x.yaml: expected at most {LARGEST_DOCUMENT} bytes",
    ),
    "a merge": ("b: 1\na: {<<: {c: 3}}", "x.yaml:2: expected YAML, got"),
    "a broken line": ("a: 1\nb: [2\n", "x.yaml:3: expected YAML, got"),
    "a control character": ("a: \x00", "x.yaml:1: expected YAML, got"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_text_is_refused_at_once_in_one_line(tmp_path, name):
    text, message = HOSTILE[name]
    path = tmp_path / "x.yaml"
    path.write_text(text, encoding="utf-8")
    begun = time.process_time()
    with pytest.raises(DocumentError) as caught:
        read_document(path)
    assert time.process_time() - begun < 2.0
    assert message in str(caught.value)
    assert len(str(caught.value)) < 500 + len(str(path))
    assert "\n" not in str(caught.value)


def test_bytes_that_are_no_text_are_named(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_bytes(b"a: 1\nb: \xff\n")
    with pytest.raises(DocumentError, match=r"x\.yaml:2: expected text in UTF-8, got byte 0xff"):
        read_document(path)


def test_many_keys_are_read_in_a_second(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_text("".join(f"k{index}: 1\n" for index in range(20_000)), encoding="utf-8")
    begun = time.process_time()
    assert len(read_document(path).mapping()) == 20_000
    assert time.process_time() - begun < 2.0


def test_anchors_and_dates_are_read(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_text("a: &a {x: 1, y: 1e-6}\nb: *a\nday: 2024-13-45\n", encoding="utf-8")
    assert read_document(path).value == {
        "a": {"x": 1, "y": 1e-6},
        "b": {"x": 1, "y": 1e-6},
        "day": "2024-13-45",
    }


def test_errors_name_the_line_of_the_value(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_text("a:\n  - x: 1\n  - x: &b nay\n    y: 2\nc: {d: 1}\n", encoding="utf-8")
    document = read_document(path)
    second = document.mapping()["a"].items()[1]
    for read, place in [
        (lambda: second.mapping()["x"].number(), "x.yaml:3: a[1].x: expected a number, got 'nay'"),
        (lambda: second.fields(["z"]), "x.yaml:3: a[1]: expected the key z, got x, y"),
        (lambda: document.fields(["a"]), "x.yaml:1: document: expected only the keys a, got c"),
        (lambda: document.mapping()["c"].mapping()["d"].text(), "x.yaml:5: c.d: expected text"),
    ]:
        with pytest.raises(DocumentError) as caught:
            read()
        assert place in str(caught.value)
