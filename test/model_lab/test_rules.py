"""Every threshold by which the lab decides is a field of `Rules`, with its meaning and origin."""

import ast
import math
from dataclasses import FrozenInstanceError, fields, replace
from pathlib import Path

import pytest

import model_lab
from model_lab.rules import RULES, Rules, neutral_rules

SOURCES = Path(model_lab.__file__).parent
ROOMS = [
    "comparison",
    "diagnosis",
    "experiments",
    "fitting",
    "learning",
    "localisation",
    "measurements",
]
NUMERICS = "a setting of a numerical method"
FILE = "refuses a file that cannot be right; no verdict is reached"
EXCEPTIONS = {
    "diagnosis/search.py": {"GRID": NUMERICS, "LARGEST_GRID": NUMERICS},
    "diagnosis/black_boxes.py": {"FEWEST_SAMPLES": "a slope needs three samples"},
    "diagnosis/evidence.py": {"LARGEST_LOGARITHM": "a feature of the calibrated confidence"},
    "experiments/base_torque.py": {"OUT_OF_REACH": FILE},
    "experiments/grasp_rollouts.py": {"_processes": "how many processes work"},
    "experiments/hand_grasp.py": {"SIMULATED_MODULI": NUMERICS},
    "experiments/hand_motion.py": {"MOST_KEPT": "how much is kept in memory"},
    "experiments/kept_bodies.py": dict.fromkeys(("SCALES", "SCALE_ERROR"), NUMERICS),
    "experiments/samples.py": {"JUMP": NUMERICS},
    "experiments/specimen_models.py": {"UNCHANGED": NUMERICS},
    "fitting/fit.py": dict.fromkeys(
        (
            "DAMPINGS",
            "LEAST_IMPROVEMENT",
            "LARGEST_DAMPING",
            "SAME_MINIMUM",
            "NO_CHANGE",
        ),
        NUMERICS,
    ),
    "fitting/noise_floor.py": {"ALIKE_DRAWS": NUMERICS},
    "fitting/pulse_noise.py": {"LEAST_SINGULAR": NUMERICS},
    "fitting/notices.py": {
        **dict.fromkeys(
            ("COMPARED_RANGE", "FEWEST_PERIODS", "HARMONICS", "LINE_WIDTH", "SPECTRUM_SAMPLES"),
            NUMERICS,
        ),
    },
    "fitting/problem.py": {"SETTLED_MOVE": NUMERICS},
    "learning/learn.py": {"KNOT_COUNTS": NUMERICS},
    "localisation/axes.py": {
        "ROUNDING_ERROR": NUMERICS,
        **dict.fromkeys(("FALLING", "RESTS", "RISING"), "codes of a direction"),
    },
    "localisation/bins.py": dict.fromkeys(
        ("AXIS_BINS", "RANKED_SAMPLES", "SMALLEST_BIN"), NUMERICS
    ),
    "localisation/localise.py": {"MOST_DIGITS": "words of a report"},
    "importing/bag_tables.py": {"LARGEST_MESSAGE": "which topics become columns"},
    "measurements/at_rest.py": dict.fromkeys(
        ("BENT", "FEWEST_ON_LINE", "REACH_OF_NOISE"), NUMERICS
    ),
    "measurements/bags/columns.py": {"PROGRESS_PERIOD": "words of a message"},
    "measurements/bags/fields.py": {"SHOWN_FIELDS": "words of a message"},
    "measurements/bags/limits.py": dict.fromkeys(("CHUNK", "LARGEST_PIECE"), FILE),
    "measurements/csv_file.py": {"LARGEST_FILE": FILE},
    "measurements/drives.py": dict.fromkeys(("LEVEL_STEP", "SPIKE", "TURN"), NUMERICS),
    "measurements/load.py": dict.fromkeys(("LONGEST_NAME", "LONGEST_PATH"), FILE),
    "measurements/measurement_set.py": {"SAME_TEMPERATURE": "part of the format of a set"},
    "measurements/resolution.py": {"EQUAL_READINGS": NUMERICS},
    "measurements/specimens.py": {"LONGEST_SPECIMEN": FILE},
    "measurements/units.py": dict.fromkeys(("LONGEST_EXPONENT", "LONGEST_UNIT"), FILE),
}


def is_number(node):
    """Whether an expression is made of numbers alone."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    if isinstance(node, ast.BinOp):
        return is_number(node.left) and is_number(node.right)
    parts = node.values if isinstance(node, ast.Dict) else getattr(node, "elts", [])
    return bool(parts) and all(map(is_number, parts))


def constants(tree):
    """Names of the module's numeric constants."""
    found = set()
    for statement in tree.body:
        if not isinstance(statement, ast.Assign | ast.AnnAssign) or statement.value is None:
            continue
        target = getattr(statement, "target", None) or statement.targets[0]
        pairs = [(target, statement.value)]
        if isinstance(target, ast.Tuple) and isinstance(statement.value, ast.Tuple):
            pairs = list(zip(target.elts, statement.value.elts, strict=True))
        found |= {a.id for a, b in pairs if isinstance(a, ast.Name) and is_number(b)}
    return found


def names_in(node):
    return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}


def compared(tree):
    """Names that are compared, themselves or by a local that was assigned from them."""
    found = set()
    for function in [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]:
        nodes = list(ast.walk(function))
        mine = set().union(*(names_in(n) for n in nodes if isinstance(n, ast.Compare)))
        for node in nodes:
            if isinstance(node, ast.Assign) and mine & set().union(*map(names_in, node.targets)):
                mine |= names_in(node.value)
        found |= mine
    return found


def thresholds(text):
    """Constants of a module's source that it compares with."""
    tree = ast.parse(text)
    return constants(tree) & compared(tree)


def test_no_module_compares_with_a_threshold_of_its_own():
    found = {}
    for room in ROOMS:
        for path in sorted((SOURCES / room).rglob("*.py")):
            name = str(path.relative_to(SOURCES))
            more = thresholds(path.read_text()) - set(EXCEPTIONS.get(name, {}))
            found |= {name: more} if more else {}
    assert found == {}


def test_the_exceptions_are_still_there():
    for name, reasons in EXCEPTIONS.items():
        assert set(reasons) <= thresholds((SOURCES / name).read_text()), name


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("FAR = 2.0\ndef f(x):\n    return x > 3.0 * FAR", {"FAR"}),
        ("FAR, NEAR = 2.0, 1\ndef f(x):\n    least = FAR * 2\n    return x < least", {"FAR"}),
        ("FAR = 2.0\ndef f(x):\n    return x * FAR", set()),
        ("WORD = 'far'\ndef f(x):\n    return x == WORD", set()),
    ],
)
def test_thresholds_are_found_in_source_text(text, found):
    assert thresholds(text) == found


def test_each_rule_says_what_it_means_its_unit_and_how_it_was_chosen():
    for rule in fields(Rules):
        assert set(rule.metadata) == {"meaning", "unit", "chosen", "neutral"}
        assert all(len(rule.metadata[key]) for key in ("meaning", "unit", "chosen")), rule.name


def test_each_rule_is_read_somewhere():
    text = "\n".join(path.read_text() for path in SOURCES.rglob("*.py"))
    assert [
        rule.name
        for rule in fields(Rules)
        if f"ules.{rule.name}" not in text.replace("RULES.", "rules.")
    ] == []


def test_rules_cannot_be_changed_in_place():
    with pytest.raises(FrozenInstanceError):
        RULES.material_error = 1.0


def test_rules_are_dropped_one_at_a_time():
    without = neutral_rules()
    assert len(without) > 25
    for name, rules in without.items():
        assert getattr(rules, name) != getattr(RULES, name)
        assert replace(rules, **{name: getattr(RULES, name)}) == RULES
    assert math.isinf(without["most_explained_error"].most_explained_error)
