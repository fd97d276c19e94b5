"""Where a module can be mutated, and how: cosmic-ray's operators at every place that decides.

Left out are places that decide nothing (annotations, decorators, texts, messages of errors), and
operators whose mutant would fail at once wherever it is, such as bits of floats.
"""

from __future__ import annotations

import random
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator

ARITHMETIC = ("Add", "Sub", "Mul", "Div", "FloorDiv", "Mod", "Pow")
MASKS = ("BitAnd", "BitOr", "BitXor")
COMPARISONS = ("Eq", "NotEq", "Lt", "LtE", "Gt", "GtE")
OPERATORS = tuple(
    f"core/{name}"
    for name in (
        *(f"ReplaceBinaryOperator_{a}_{b}" for a, b in permutations(ARITHMETIC, 2)),
        *(f"ReplaceBinaryOperator_{a}_{b}" for a, b in permutations(MASKS, 2)),
        *(f"ReplaceComparisonOperator_{a}_{b}" for a, b in permutations(COMPARISONS, 2)),
        "ReplaceComparisonOperator_Is_IsNot",
        "ReplaceComparisonOperator_IsNot_Is",
        "ReplaceUnaryOperator_Delete_Not",
        "ReplaceUnaryOperator_Delete_USub",
        "ReplaceUnaryOperator_Delete_Invert",
        "ReplaceAndWithOr",
        "ReplaceOrWithAnd",
        "ReplaceTrueWithFalse",
        "ReplaceFalseWithTrue",
        "ReplaceBreakWithContinue",
        "ReplaceContinueWithBreak",
        "AddNot",
        "ExceptionReplacer",
        "NumberReplacer",
        "ZeroIterationForLoop",
    )
)
NO_DECISIONS = ("decorator", "fstring", "raise_stmt", "import_from")
Position = tuple[int, int]


@dataclass(frozen=True)
class Mutant:
    """One change of a module: an operator at its n-th occurrence, which begins at a position."""

    module: str
    position: Position
    operator: str
    occurrence: int

    def source(self, code: str) -> str:
        """The code with the change."""
        return str(mutate_code(code, get_operator(self.operator)(), self.occurrence))

    def change(self, code: str) -> str:
        """The lines that differ, as `before -> after`."""
        before, after = code.splitlines(), self.source(code).splitlines()
        first = next(i for i, (a, b) in enumerate(zip(before, after, strict=False)) if a != b)
        return f"{before[first].strip()} -> {after[first].strip()}"


def mutants_of(module: str, code: str) -> dict[Position, list[Mutant]]:
    """All mutants of a module by the place where they begin.

    >>> list(mutants_of("m", "x: 'int | None' = a + 1"))
    [(1, 20), (1, 22)]
    """
    nodes = list(ast_nodes(get_ast(code)))
    idle = list(_idle(nodes))
    found: dict[Position, list[Mutant]] = defaultdict(list)
    for name in OPERATORS:
        operator, occurrence = get_operator(name)(), 0
        for node in nodes:
            for start, _ in operator.mutation_positions(node):
                if not any(low <= start < high for low, high in idle):
                    found[start].append(Mutant(module, start, name, occurrence))
                occurrence += 1
    return dict(sorted(found.items()))


def _idle(nodes: Sequence[Any]) -> Iterator[tuple[Position, Position]]:
    """Start and end of what decides nothing."""
    for node in nodes:
        if node.type in NO_DECISIONS:
            yield node.start_pos, node.end_pos
        elif node.type in ("tfpdef", "annassign"):
            annotation = node.children[2 if node.type == "tfpdef" else 1]
            yield annotation.start_pos, annotation.end_pos
        elif node.type == "funcdef" and node.annotation is not None:
            yield node.annotation.start_pos, node.annotation.end_pos


def even_sample(sources: dict[str, str], count: int, seed: int) -> list[Mutant]:
    """So many mutants at places that lie evenly over all modules, one at each place by chance."""
    places = [
        mutants for name, code in sources.items() for mutants in mutants_of(name, code).values()
    ]
    chance = random.Random(seed)
    return [chance.choice(mutants) for mutants in _evenly(places, count, chance.random())]


def _evenly(places: Sequence[list[Mutant]], count: int, offset: float) -> list[list[Mutant]]:
    """So many of the places at even distances, the first one by an offset of 0 to 1."""
    count = min(count, len(places))
    return [places[int((index + offset) * len(places) / count)] for index in range(count)]


def source_file(root: Path, module: str) -> Path:
    """File of a module of the packages under `src`."""
    return root / "src" / module.split(".")[0] / (module.replace(".", "/") + ".py")
