"""Torque on the base of a held finger: what shows there, nothing, and a sensor's crosstalk."""

from __future__ import annotations

from hidden.case import Case, Expected
from hidden.cases_catalogue import RATIOS, named

CATALOGUE = ("bend_twist_coupling", "passive_layer_slack")
NOISE = (0.006,)  # a diagnosis takes a minute


def torques() -> list[Case]:
    """Cases of the experiment base_torque."""
    shown = [
        _case(f"base_torque/{effect}/{word}", "catalogue", (effect,), named(effect), ratio)
        for effect in CATALOGUE
        for word, ratio in RATIOS.items()
    ]
    return [
        *shown,
        _case("nothing/base_torque/repeats", "nothing", (), Expected("adequate"), None),
        _case(
            "outside/base_torque/crosstalk/5",
            "outside",
            ("crosstalk",),
            Expected("unexplained"),
            5.0,
        ),
    ]


def _case(
    name: str, row: str, laws: tuple[str, ...], expected: Expected, ratio: float | None
) -> Case:
    hidden = tuple((law, {}) for law in laws)
    return Case(name, row, "base_torque", hidden, expected, ratio, noises=NOISE)
