"""The bench of mutants: where code is mutated, which are drawn, and that they are tried."""

import ast
import json
import os
import subprocess
import sys
from collections import Counter

import pytest
import yaml

from bench.mutants.__main__ import MEANINGS, rows_of
from bench.mutants.modules import MODULES
from bench.mutants.places import OPERATORS, even_sample, mutants_of, source_file
from bench.mutants.trial import ROOT

CODE = '''"""Text with 1 + 2."""
from typing import Any

LIMIT: int | None = 3  # 4

@decorate(level=5)
def judge(height: float | None = 6, *rest: int | str) -> int | None:
    if height > LIMIT and rest:
        raise ValueError(f"at most {7 + 8}")
    for part in rest:
        height += part * 2
    return not height
'''


def test_what_decides_is_mutated_and_texts_annotations_and_decorators_are_not():
    lines = CODE.splitlines()
    places = {lines[line - 1][column:].split()[0] for line, column in mutants_of("m", CODE)}
    assert places == {"3", "6,", "height", ">", "and", "rest:", "*", "2", "not"}


def test_a_mutant_changes_one_line_and_is_still_python():
    every = [mutant for found in mutants_of("m", CODE).values() for mutant in found]
    assert len({mutant.source(CODE) for mutant in every}) == len(every)
    for mutant in every:
        ast.parse(mutant.source(CODE))
    changes = {mutant.change(CODE) for mutant in every}
    assert "if height > LIMIT and rest: -> if height > LIMIT or rest:" in changes
    assert "if height > LIMIT and rest: -> if height >= LIMIT and rest:" in changes
    assert "height += part * 2 -> height += part / 2" in changes


def test_the_sample_is_even_over_all_places_and_the_same_again():
    sources = {"short": CODE, "long": CODE * 4}
    drawn = even_sample(sources, 20, seed=3)
    assert drawn == even_sample(sources, 20, seed=3) != even_sample(sources, 20, seed=4)
    assert Counter(mutant.module for mutant in drawn) == {"short": 4, "long": 16}
    assert len({(mutant.module, mutant.position) for mutant in drawn}) == 20
    assert len(even_sample(sources, 10_000, seed=3)) == 5 * len(mutants_of("m", CODE))


def test_each_module_has_tests_and_places_and_meanings_of_known_survivors():
    meanings = yaml.safe_load(MEANINGS.read_text("utf-8"))
    assert list(meanings) == [row.module for row in MODULES]
    for row in MODULES:
        assert row.tests and all((ROOT / test).exists() for test in row.tests)
        assert source_file(ROOT, row.module).is_file()
    assert len(set(OPERATORS)) == len(OPERATORS)


def test_the_share_that_is_seen_is_told_of_all_and_of_each_module():
    records = [
        {"module": name, "seen": seen} for name, seen in [("a", True), ("a", False), ("b", True)]
    ]
    whole, first, second = rows_of(records)
    assert whole["name"] == "mutants seen (2 of 3)" and whole["met"] is False
    assert whole["value"] == pytest.approx(200 / 3)
    assert (first["name"], first["value"]) == ("a (2)", 50.0)
    assert (second["name"], second["value"]) == ("b (1)", 100.0)


def test_mutants_are_tried_listed_and_written_with_the_seed(tmp_path):
    command = [sys.executable, "-m", "bench.mutants", "--only", "driver.modes", "--count", "1000"]
    done = subprocess.run(
        [*command, "--seed", "5"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    written = json.loads((tmp_path / "out/bench/bench-mutants.json").read_text())
    found = len(written["mutants"])
    assert f"{found} in 1 modules, seed 5" in done.stdout and "time" in done.stdout
    assert written["seed"] == 5 and 1 <= found <= 4
    assert all(mutant["seen"] in (True, False) for mutant in written["mutants"])
    names = {row["name"] for row in written["rows"]}
    assert names >= {f"pneumaticbox_driver.modes ({found})", "time"}
