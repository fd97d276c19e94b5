"""Writes docs/reference/effects.md: the catalogue of effects, from their classes (`make docs`)."""

from __future__ import annotations

import inspect
from pathlib import Path

from softhand_common.documents.output_file import write_file
from softhand_model.effects import STAGES, Effect, Parameter, effect_classes

PAGE = Path(__file__).parents[1] / "docs" / "reference" / "effects.md"
HEAD = """# Effects

Which physical effects can a model have beyond the base model, and which measurements show them?

    .venv/bin/model-lab add ballooning --data SET --model base --out mine.yaml

A [model file](../use/hands-and-objects.md) names those that take part in simulator, monitor and
lab; [the classes](python/effects.md#the-effects) state assumptions, limits and sources.

* **Parameters**: unit, bounds and, in brackets, the usual range.
* **Seen in**: the experiments that show it. *Bending* stands for base_torque, blocked_tip and
  free_bending, *all rubber* for these with rubber and uniaxial.
* **Memory**: the result depends on what was before.
* **Mistaken for**: effects that look alike. The reason stands with the first of a pair.

Effects of the stage `flow` act on valve pulses, in the lab and in the simulator, in place of the
naive term `c*p_in*duration`. What they add flows at most five times as fast as the open path passes
air, and never beyond supply or ambient pressure. Trials in process impose air masses and refuse
them.

## Stages

[An effect of your own](../use/own-effects.md) derives from the class of its stage and has one of
its methods.

| stage | derive from | methods | what they give |
|---|---|---|---|
"""
METHODS = {
    "hand": (
        (
            "HandEffect",
            "places(hand, markers)",
            "modulus_of(actuator)",
            "tilt_of(chain)",
            "share_between(source, target)",
            "strut_factor()",
            "palm_factor()",
            "tip_mass_of(chain)",
            "friction_factor()",
            "damping_time()",
            "lag_of(channel)",
            "wrench_gain()",
            "wrench_bias()",
            "marker_offset_of(marker)",
            "frame_turn()",
        ),
        "what one actuator, chain, marker or pair of channels has of its own, for which a model "
        "file says `where`; what the whole hand has",
    ),
    "input": (
        (
            "InputEffect",
            "chamber_pressure(pressure, memory, dt)",
            "delay(elapsed)",
            "imposed_stretch(stretch)",
        ),
        "pressure in the chamber, given the reading; by how much later it shows; stretch of the "
        "rubber, given the reading",
    ),
    "load": (
        (
            "LoadEffect",
            "act_on_load(load, pressure, shape)",
            "modulus_factor(temperature)",
            "age_factor(runs)",
        ),
        "the load s; factors on G",
    ),
    "elastic": (
        ("ElasticEffect", "stress(stress, strain, shape, memory, dt)", "remember(...)"),
        "the elastic side of Q + nu + s_c*w = s - m",
    ),
    "structure": (
        (
            "StructureEffect",
            "wall_stress",
            "act_on_curvature",
            "stiffness_factor",
            "bend_twist_coupling",
            "tip_compliance",
            "tip_force",
        ),
        "what walls, joints and tip do",
    ),
    "output": (
        ("OutputEffect", "reading(value, memory, dt)", "quantity"),
        "what the sensor of a measured column, `quantity`, shows",
    ),
    "flow": (
        (
            "FlowEffect",
            "act_on_mass(mass, pulse)",
            "act_on_pulse(pulse, mass)",
            "leak(pressure_abs)",
        ),
        "the mass that a valve pulse moves; in the simulator what leaks between pulses",
    ),
}


BENDING = {"base_torque", "blocked_tip", "free_bending"}
GROUPS = {"all rubber": BENDING | {"rubber", "uniaxial"}, "bending": BENDING}


def page() -> str:
    """The whole page."""
    parts = [HEAD, *(_methods(stage) for stage in STAGES)]
    explained: set[frozenset[str]] = set()
    for stage in STAGES:
        chosen = [effect for effect in effect_classes().values() if effect.stage == stage]
        parts.append(f"\n## Stage {stage}\n")
        parts += [_section(effect, explained) for effect in sorted(chosen, key=_place)]
    return "".join(parts)


def _methods(stage: str) -> str:
    (base, *methods), given = METHODS[stage]
    named = ", ".join(f"`{method}`" for method in methods)
    return f"| {stage} | `{base}` | {named} | {given} |\n"


def _place(effect: type[Effect]) -> tuple[bool, int, str]:
    return getattr(effect, "adds", False), effect.rank, effect.name


def _section(effect: type[Effect], explained: set[frozenset[str]]) -> str:
    text = " ".join(inspect.cleandoc(effect.__doc__ or "").split("\n\n")[0].split())
    lines = [f"\n### {effect.name}\n\n{_plain(text)}\n\n", *map(_parameter, effect.parameters)]
    if not effect.physical:
        lines.append("* **Not physics**: never named by `diagnose`, added only on request.\n")
    memory = "; memory" if effect.has_memory else ""
    seen = _experiments(set(effect.experiments)) or "no experiment of the lab yet"
    lines.append(f"* Seen in: {seen}{memory}.\n")
    if effect.not_simulated:
        lines.append(f"* The simulator refuses it: {effect.not_simulated}.\n")
    if effect.confounded_with:
        lines.append(f"* Mistaken for: {_alike(effect, explained)}.\n")
    return "".join(lines)


def _plain(text: str) -> str:
    """Text whose asterisks mean products, outside of code.

    >>> print(_plain("G*d with `a*b`"))
    G\\*d with `a*b`
    """
    parts = text.split("`")
    parts[::2] = [part.replace("*", "\\*") for part in parts[::2]]
    return "`".join(parts)


def _experiments(names: set[str]) -> str:
    for group, members in GROUPS.items():
        if members <= names:
            return ", ".join([group, *sorted(names - members)])
    return ", ".join(sorted(names))


def _alike(effect: type[Effect], explained: set[frozenset[str]]) -> str:
    """Effects that are easily mistaken for it, with the reason unless another entry has it."""
    by_reason: dict[str, list[str]] = {}
    for other, why in sorted(effect.confounded_with.items()):
        pair = frozenset({effect.name, other})
        by_reason.setdefault("" if pair in explained else f" ({why})", []).append(f"`{other}`")
        explained.add(pair)
    return "; ".join(f"{', '.join(others)}{why}" for why, others in by_reason.items())


def _parameter(p: Parameter) -> str:
    low, high = p.typical or (p.low, p.high)
    usual = f"{low:g}..{high:g}{_relative(p)}"
    return f"* `{p.name}` [{p.unit or '-'}] {p.low:g}..{p.high:g} ({usual}): {p.description}\n"


def _relative(parameter: Parameter) -> str:
    """The usual range in a set, where it goes by what was measured."""
    if parameter.relative is None:
        return ""
    of, low, high = parameter.relative
    return f"; in a set {low:g}..{high:g} of its largest {of}"


if __name__ == "__main__":
    write_file(PAGE, page())
