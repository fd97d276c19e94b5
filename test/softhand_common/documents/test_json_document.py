"""JSON that is read back: finite numbers of sensible length, or one line with the file."""

import pytest

from softhand_common.documents.json_document import read_json


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "expected JSON, got Expecting value"),
        ("[" * 100_000, "expected JSON, got maximum recursion depth"),
        ('{"a": NaN}', "expected JSON, got 'NaN', which is not a finite number"),
        ('{"a": -1e999}', "expected JSON, got '-1e999', which is not a finite number"),
        ('{"a": ' + "9" * 400 + "}", "expected JSON, got a number of 400 characters"),
        ('{"a": 1}', "document: expected the key `format` with the value own/1, got none"),
        ('{"format": "own/2"}', "format: expected one of own/1, got 'own/2'"),
        ("[1]", "document: expected a mapping"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(tmp_path, text, named):
    path = tmp_path / "own.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=rf"own\.json: {named}") as caught:
        read_json(path, "own/1")
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"own\.json: expected a readable file, got No such file"):
        read_json(tmp_path / "own.json")


def test_what_is_sound_is_read(tmp_path):
    (tmp_path / "own.json").write_text('{"format": "own/1", "a": [1, 2.5, null]}')
    node = read_json(tmp_path / "own.json", "own/1")
    assert node.mapping()["a"].value == [1, 2.5, None]
