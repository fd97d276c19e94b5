"""Public signatures: what is called `pressure` is gauge, absolute pressure ends in `_abs`."""

import ast
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / "src"
PACKAGES = sorted(path.name for path in SRC.iterdir() if (path / path.name).is_dir())


def public_functions(node, docs=()):
    """Public functions and methods below a node, with their docstrings, innermost first."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.FunctionDef | ast.ClassDef):
            continue
        around = (ast.get_docstring(child) or "", *docs)
        if isinstance(child, ast.ClassDef):
            yield from public_functions(child, around)
        elif child.name == "__init__" or not child.name.startswith("_"):
            yield child, around


def pressures(function):
    """Names of the parameters that hold pressures."""
    given = function.args
    parameters = (*given.posonlyargs, *given.args, *given.kwonlyargs)
    numbers = [p.arg for p in parameters if p.annotation is None or not is_flag(p.annotation)]
    return [name for name in numbers if name.startswith("pressure") or "_pressure" in name]


def is_flag(annotation):
    return isinstance(annotation, ast.Name) and annotation.id == "bool"


def entry(name, doc):
    """What a docstring says of a parameter: its entry under `Args`, or else all of it."""
    _, found, rest = doc.partition(f"\n    {name}: ")
    return rest.partition(":")[0] if found else doc


def faults(path):
    """What contradicts the rule in a file."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for function, docs in public_functions(tree, (ast.get_docstring(tree) or "",)):
        where = f"{path.name}:{function.lineno} {function.name}"
        said = docs[0] or docs[1]
        for name in pressures(function):
            text = entry(name, said)
            if name.endswith("_abs"):
                if "absolute" not in text:
                    yield f"{where}: {name} does not say that it is absolute"
            elif "absolute" in text and "gauge" not in text:
                yield f"{where}: {name} is absolute and does not end in _abs"
            if "[Pa]" not in " ".join(docs):
                yield f"{where}: {name} has no unit [Pa]"


@pytest.mark.parametrize("package", PACKAGES)
def test_pressure_is_gauge_and_absolute_pressure_says_so_in_its_name(package):
    files = sorted((SRC / package / package).rglob("*.py"))
    found = [fault for file in files for fault in faults(file)]
    assert not found, "\n".join(found)


def test_the_rule_finds_what_breaks_it(tmp_path):
    file = tmp_path / "wrong.py"
    file.write_text(
        'def one(pressure):\n    """Of an absolute pressure [Pa]."""\n'
        'def two(pressure_abs):\n    """Of a pressure [Pa]."""\n'
        'def three(pressure):\n    """Of a pressure."""\n'
        'def four(pressure, pressure_abs):\n    """x\n\n    Args:\n'
        "        pressure: gauge [Pa].\n        pressure_abs: absolute [Pa].\n"
        '    """\n'
    )
    assert [fault.split(":")[1].split()[1] for fault in faults(file)] == ["one", "two", "three"]
