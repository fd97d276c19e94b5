"""A constant of a module is named after its quantity: the same name stands for the same value."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src"
MAX_AMBIGUOUS_NAMES = 30
BARE_NAMES = ("MOST", "FAR", "FEW", "SHARE")  # of no quantity


def constants(text: str) -> Iterator[tuple[str, str]]:
    """Name and expression of each constant (in capitals) that a module assigns at its top level."""
    for statement in ast.parse(text).body:
        if isinstance(statement, ast.Assign):
            targets, value = statement.targets, statement.value
        elif isinstance(statement, ast.AnnAssign) and statement.value is not None:
            targets, value = [statement.target], statement.value
        else:
            continue
        for target in targets:
            pairs = [(target, value)]
            if isinstance(target, ast.Tuple):
                parts = value.elts if isinstance(value, ast.Tuple) else [value] * len(target.elts)
                pairs = list(zip(target.elts, parts, strict=True))
            for name, expression in pairs:
                if isinstance(name, ast.Name) and name.id.isupper():
                    yield name.id, ast.unparse(expression)


@cache
def meanings() -> dict[str, dict[str, list[str]]]:
    """Modules of the packages by the name and the expression of the constants they assign."""
    found: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for package in sorted(SOURCE.iterdir()):
        for path in sorted((package / package.name).rglob("*.py")):
            for name, expression in constants(path.read_text()):
                found[name][expression].append(str(path.relative_to(SOURCE / package.name)))
    return found


def test_tells_constants_of_a_module():
    text = "A, B = 1, 2\nC: int = 3\nd = 4\nF = G = 5\ndef f():\n    E = 5\n"
    assert list(constants(text)) == [("A", "1"), ("B", "2"), ("C", "3"), ("F", "5"), ("G", "5")]


def test_few_names_have_several_values():
    ambiguous = {name: values for name, values in meanings().items() if len(values) > 1}
    listed = "\n".join(f"{name}: {dict(values)}" for name, values in sorted(ambiguous.items()))
    assert len(ambiguous) <= MAX_AMBIGUOUS_NAMES, f"{len(ambiguous)} names:\n{listed}"


def test_constants_name_a_quantity():
    assert not set(BARE_NAMES) & set(meanings())
