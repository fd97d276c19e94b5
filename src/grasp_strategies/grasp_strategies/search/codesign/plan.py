"""A plan of co-design in YAML: arms, budgets, seeds, training and held-out trials; see the shipped
one for what the keys mean.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grasp_strategies.search.codesign.halving import Halving
from grasp_strategies.search.codesign.hand_space import HAND_SPACE, Range
from grasp_strategies.search.codesign.motion_space import MOTION_SPACE
from grasp_strategies.search.problem import SAMPLERS, SearchProblem, Variable
from softhand_model.documents.yaml_document import Node, read_document

FORMAT = "softhand-codesign/1"
SHIPPED_PLAN = Path(__file__).parents[2] / "data" / "codesign" / "rbo_hand_2.yaml"
OBJECTIVE = "grasp_strategies.search.codesign.success:grasp"
SPACES: dict[str, Mapping[str, Range]] = {"hand": HAND_SPACE, "motion": MOTION_SPACE}
MOST = 1_000_000
FACTORS = ("mass", "friction", "modulus")
PHYSICS = ("objects", "seed", "step", "segments", "offset", *FACTORS)


@dataclass(frozen=True)
class Arm:
    """What an arm searches: names of `SPACES`, with a sampler."""

    spaces: tuple[str, ...]
    sampler: str

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Its variables."""
        return tuple(
            Variable(name, one.low, one.high)
            for space in self.spaces
            for name, one in SPACES[space].items()
        )


@dataclass(frozen=True)
class Plan:
    """A plan: arms by name, all with the same halving and seeds; training and held_out are settings
    of `success.grasp`, of which the last one is tried at `places` places.
    """

    name: str
    arms: Mapping[str, Arm]
    halving: Halving
    generation: int
    seeds: tuple[int, ...]
    training: Mapping[str, Any]
    held_out: Mapping[str, Any]
    places: int

    def problem(self, arm: str, seed: int) -> SearchProblem:
        """What an arm searches with a seed."""
        found = self.arms[arm]
        return SearchProblem(
            f"{arm}_{seed}",
            OBJECTIVE,
            found.variables,
            MOST,
            self.generation,
            found.sampler,
            seed,
            settings=self.training,
        )

    def with_noise(self) -> Plan:
        """The negative control: successes of the search are drawn at random."""
        return replace(self, name=f"{self.name}_noise", training={**self.training, "noise": True})


def load_plan(path: Path = SHIPPED_PLAN, small: bool = False) -> Plan:
    """Read a plan, or its `small` form. Raises ValueError naming file, key, expected and got."""
    keys = ("name", "generation", "halving", "seeds", "arms", "training", "held_out", "small")
    top = read_document(path, FORMAT).fields(("format", *keys))
    held_out = top["held_out"].fields((*PHYSICS, "places"))
    plan = Plan(
        top["name"].name(),
        {name: _arm(node) for name, node in top["arms"].mapping().items()},
        _halving(top["halving"]),
        top["generation"].whole(1, MOST),
        _seeds(top["seeds"]),
        _physics(top["training"].fields(PHYSICS)),
        _physics({key: held_out[key] for key in PHYSICS}),
        held_out["places"].whole(1, MOST),
    )
    return _small(plan, top["small"]) if small else plan


def _small(plan: Plan, node: Node) -> Plan:
    fields = node.fields(("halving", "seeds", "places", "objects"))
    count = fields["objects"].whole(1, MOST)
    training, held_out = (
        {**settings, "objects": settings["objects"][:count]}
        for settings in (plan.training, plan.held_out)
    )
    return replace(
        plan,
        name=f"{plan.name}_small",
        halving=_halving(fields["halving"]),
        seeds=_seeds(fields["seeds"]),
        training=training,
        held_out=held_out,
        places=fields["places"].whole(1, MOST),
    )


def _arm(node: Node) -> Arm:
    fields = node.fields(("spaces", "sampler"))
    spaces = tuple(child.choice(SPACES) for child in fields["spaces"].items())
    return Arm(spaces, fields["sampler"].choice(SAMPLERS))


def _halving(node: Node) -> Halving:
    fields = node.fields(("rungs", "one_in", "budget"))
    rungs = tuple(child.whole(1, MOST) for child in fields["rungs"].items())
    return Halving(rungs, fields["one_in"].whole(2, MOST), fields["budget"].whole(1, MOST))


def _seeds(node: Node) -> tuple[int, ...]:
    return tuple(child.whole(0, 2**32 - 1) for child in node.items())


def _physics(fields: Mapping[str, Node]) -> dict[str, Any]:
    """Settings of the trials."""
    return {
        "objects": list(fields["objects"].names()),
        "seed": fields["seed"].whole(0, 2**32 - 1),
        "step": fields["step"].number(1e-4, 0.05),
        "segments": fields["segments"].whole(1, 100),
        "offset": fields["offset"].number(0.0, 1.0),
        **{key: list(fields[key].vector(2)) for key in FACTORS},
    }
