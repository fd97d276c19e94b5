"""The ways on the page of the house: every file exists and is reached from one before it."""

import ast
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WAYS = runpy.run_path(str(ROOT / "scripts" / "draw_architecture.py"))["ways"]()
MOST = {"command": 20, "measurement": 15, "effect": 12}
FOUND_BY_NAME = "softhand_model/effects/catalogue.py"  # it lists the files beside it


def source(name):
    return ROOT / "src" / name.partition("/")[0] / name


def imported(name):
    """Files that a file imports, those that the `__init__` of a package passes on included."""
    found = set()
    for node in ast.walk(ast.parse(source(name).read_text())):
        if not isinstance(node, ast.ImportFrom) or node.module is None:
            continue
        path = node.module.replace(".", "/")
        for target in [path, *(f"{path}/{alias.name}" for alias in node.names)]:
            if source(f"{target}.py").exists():
                found.add(f"{target}.py")
            elif source(f"{target}/__init__.py").exists():
                found |= imported(f"{target}/__init__.py")
    return found


@pytest.mark.parametrize("way", MOST)
def test_a_way_is_short_and_each_file_is_reached_from_one_before(way):
    reached, files = set(), 0
    for step in WAYS[way]:
        name = next(iter(step))
        if name == "topic":
            reached = set()
            continue
        assert source(name).exists(), name
        assert not reached or name in reached, f"{name}: no file before it imports it"
        reached |= imported(name)
        if name == FOUND_BY_NAME:
            beside = source(name).parent
            reached |= {f"softhand_model/effects/{path.name}" for path in beside.glob("*.py")}
        files += 1
    assert files <= MOST[way]
