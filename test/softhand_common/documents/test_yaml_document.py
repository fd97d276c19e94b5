"""Errors of YAML files: file, key, expected, got."""

import pytest

from softhand_common.documents.yaml_document import DocumentError, Node, read_document
from softhand_model.data_files import find_document


@pytest.mark.parametrize(
    ("value", "read", "message"),
    [
        (float("nan"), lambda node: node.number(), "f.yaml: k: expected a number, got nan"),
        (True, lambda node: node.number(), "expected a number, got True"),
        (3, lambda node: node.number(0, 2), "expected a number at least 0 and at most 2, got 3"),
        (0, lambda node: node.positive(), "expected a number above 0, got 0"),
        ("1.5", lambda node: node.number(), "expected a number, got '1.5'"),
        ([1, 2], lambda node: node.vector(), "expected 3 numbers, got [1, 2]"),
        ([1, 2, "x"], lambda node: node.vector(), "k[2]: expected a number, got 'x'"),
        ("x", lambda node: node.choice(["a", "b"]), "expected one of a, b, got 'x'"),
        (
            [],
            lambda node: node.names(),
            "expected a list of one or more names without duplicates, got []",
        ),
        (
            ["a", "a"],
            lambda node: node.names(),
            "expected a list of one or more names without duplicates",
        ),
        ("", lambda node: node.text(), "expected text that is not empty, got ''"),
        (
            {1: 2},
            lambda node: node.mapping(),
            "expected keys that are text, got the key 1, which YAML reads as int; write '1'",
        ),
        ({"a": 1}, lambda node: node.fields(["b"]), "k: expected the key b, got a"),
        ({"a": 1}, lambda node: node.fields([], ["b"]), "k: expected only the keys b, got a"),
        (5, lambda node: node.items(), "expected a list, got 5"),
    ],
)
def test_wrong_values_are_named(value, read, message):
    with pytest.raises(DocumentError) as caught:
        read(Node("f.yaml", "k", value))
    assert message in str(caught.value)


def test_keys_show_their_path():
    node = Node("f", "", {"a": {"b": [1, {"c": "no"}]}})
    inner = node.fields(["a"])["a"].fields(["b"])["b"].items()[1].fields(["c"])["c"]
    assert inner.key == "a.b[1].c"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("format: other/1\n", "format: expected one of softhand-x/1, got 'other/1'"),
        ("name: a\n", "expected the key `format` with the value softhand-x/1, got none"),
        ("a: [1\n", "expected YAML"),
        ("format: softhand-x/1\na: 1\na: 2\n", "the key a twice"),
        ("- 1\n", "expected a mapping"),
    ],
)
def test_unreadable_files_are_named(tmp_path, text, message):
    path = tmp_path / "x.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DocumentError) as caught:
        read_document(path, "softhand-x/1")
    assert str(path) in str(caught.value)
    assert message in str(caught.value)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(
        DocumentError, match=r"none.yaml: expected a readable file, got No such file"
    ):
        read_document(tmp_path / "none.yaml")


def test_unknown_name_is_answered_with_the_list():
    with pytest.raises(ValueError, match=r"hand: expected one of rbo_hand_1, rbo_hand_1_split"):
        find_document("rbo_hand_3", "hands", "hand")
