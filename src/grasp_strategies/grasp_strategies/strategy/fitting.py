"""Which shipped strategies lift an object, according to the strategies' files."""

from __future__ import annotations

from typing import Any

from grasp_strategies.strategy import Strategy, load_strategy, strategy_names
from grasp_strategies.strategy.tried_with import TriedWith
from softhand_common.documents.quoted import quoted

USUAL_STRATEGY, USUAL_OBJECT = "surface_constrained", "cylinder"


def fitting_strategies(object_name: str, hand: str | None = None) -> list[str]:
    """Names of the shipped strategies that lift an object with `hand` (None: with any hand): the
    usual one first, then those that need only a table and the default settings.

    >>> fitting_strategies("cylinder")[0]
    'surface_constrained'
    """
    shipped = {name: load_strategy(name) for name in strategy_names()}
    fitting = [
        name
        for name, strategy in shipped.items()
        if object_name in strategy.objects and hand in (None, strategy.hand)
    ]
    simple = {name: shipped[name].tried_with == TriedWith() for name in fitting}
    return sorted(fitting, key=lambda name: (name != USUAL_STRATEGY, not simple[name], name))


def fits() -> str:
    """One line for each shipped strategy: its name, its hand, and the objects that it lifts."""
    shipped = map(load_strategy, strategy_names())
    return "\n".join(f"  {each.name} ({each.hand}): {_known(each)}" for each in shipped)


def choose_strategy(object_name: str | None, hand: str | None = None) -> str:
    """Name of the first of `fitting_strategies`; without an object, that of the usual strategy for
    the hand.

    Raises ValueError if none fits; the message lists which strategies fit which objects.
    """
    if object_name is None and hand is None:
        return USUAL_STRATEGY
    fitting = fitting_strategies(object_name or USUAL_OBJECT, hand)
    if not fitting:
        wanted = quoted(object_name or USUAL_OBJECT) + (f" with {quoted(hand)}" if hand else "")
        raise ValueError(
            f"object: no strategy is known to lift {wanted}; known are\n{fits()}\n"
            "to try it all the same, name a strategy (make: STRATEGY=..., else --strategy)"
        )
    return fitting[0]


def simulator_parameters(strategy: Strategy) -> dict[str, Any]:
    """Parameters of a simulator, by name, for a strategy that holds its object out to the hand;
    empty for others, which run with any object and scene.
    """
    if not strategy.holds_object_out:
        return {}
    tried = strategy.tried_with
    return {
        "hand": strategy.hand,
        "object": strategy.objects[0],
        "scene": tried.scene,
        "step": tried.step,
        "segments": tried.segments,
        "finger_contact": tried.finger_contact,
    }


def misfit(strategy: Strategy, object_name: str) -> str:
    """A warning when a strategy is not known to lift an object; empty when it is."""
    if object_name in strategy.objects:
        return ""
    others = [name for name in fitting_strategies(object_name) if name != strategy.name]
    known = f"; known to lift it: {', '.join(others)}" if others else ""
    return (
        f"{strategy.name} is not known to lift {quoted(object_name)}, but {_known(strategy)}{known}"
    )


def _known(strategy: Strategy) -> str:
    return ", ".join(strategy.objects) or "no object that its file names"
