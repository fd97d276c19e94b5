"""Writes docs/reference/effects.md: the catalogue of effects, from their classes (`make docs`)."""

from __future__ import annotations

import inspect
from pathlib import Path

from softhand_model.effects import STAGES, Effect, Parameter, effect_classes

PAGE = Path(__file__).parents[1] / "docs" / "reference" / "effects.md"
HEAD = """# Effects: what acts beyond the base model

One class each, in one file a family, under `src/softhand_model/softhand_model/effects`; simulator,
live monitor and lab run the same code. A model file names those that take part ([change the hand or
the object](../use/hands-and-objects.md)). This page is made from the classes by `make docs`.

Effects of the stage `flow` act on pulses of valves: in the lab, and in the simulator, whose plant
follows each pulse from the opening of the valve to its closing. There the mass that the plant's own
valve moves stands in place of the naive term `c*p_in*duration`; what the effects make of the pulse
beyond that flows as well, at most five times as fast as the open path passes air, and as long as it
takes no channel above the supply or below the surroundings. The monitor starts from the measured
pressure, which comes after the valves. Where air masses are imposed and no valve moves, as in
trials in process, a model with flow effects is refused.

## An effect of your own

One small Python file: [`own_effect.py`](../../examples/own_effect.py) is a whole one, with tests.
It holds a class that derives from the class of its stage (`softhand_model.effects`) and has

* `name`, and `experiments`: those in which it can be seen, of `free_bending`, `blocked_tip`,
  `uniaxial`, `rubber`, `valve_pulse`, `base_torque`;
* `parameters`: for each a name, a unit, bounds that make physical sense, a description, the usual
  range (`typical`), whether it spans decades (`logarithmic`), the value that does nothing
  (`neutral`), if there is one, and where it goes by what a set measures, that range over the
  largest pressure or output of the set (`relative`);
* the one method of its stage, below. Arguments and values are arrays (trial values, rows,
  sections): calculate with numpy;
* if it depends on what was before: `has_memory = True`. What it keeps goes into the dictionary
  `memory`, which is empty at rest. An elastic effect is asked for its stress several times a step
  and keeps things in `remember` alone.

In a model file: `{name: my_effect, file: my_effect.py, parameters: {...}}`; in the lab also
`--effects my_effect.py`. It is run as Python, so only on request: `--effects FILE` or
`--allow-effect-files` of a command, `allow_effect_files: true` of a node, and only from the model
file's folder. Each method is first called once in a process of its own; one that raises, gives
something else than finite numbers of its arguments' shape, changes them, does not return within 5 s
or ends the process is told in one line, and takes no part.

| stage | derive from | methods | what they give |
|---|---|---|---|
"""
METHODS = {
    "input": (
        ("InputEffect", "chamber_pressure(pressure, memory, dt)", "delay(elapsed)"),
        "pressure in the chamber, given the reading; by how much later it shows",
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


def page() -> str:
    """The whole page."""
    parts = [HEAD, *(_methods(stage) for stage in STAGES)]
    for stage in STAGES:
        chosen = [effect for effect in effect_classes().values() if effect.stage == stage]
        parts.append(f"\n## Stage {stage}\n")
        parts += [_section(effect) for effect in sorted(chosen, key=_place)]
    return "".join(parts)


def _methods(stage: str) -> str:
    (base, *methods), given = METHODS[stage]
    named = ", ".join(f"`{method}`" for method in methods)
    return f"| {stage} | `{base}` | {named} | {given} |\n"


def _place(effect: type[Effect]) -> tuple[bool, int, str]:
    return getattr(effect, "adds", False), effect.rank, effect.name


def _section(effect: type[Effect]) -> str:
    text = " ".join(inspect.cleandoc(effect.__doc__ or "").split("ERRATUM")[0].split())
    lines = [f"\n### {effect.name}\n\n{text}\n"]
    if effect.parameters:
        lines.append("\n| parameter | meaning | unit | bounds | usual |\n|---|---|---|---|---|\n")
    for p in effect.parameters:
        low, high = p.typical or (p.low, p.high)
        lines.append(
            f"| `{p.name}` | {p.description} | {p.unit or '-'} | {p.low:g} to {p.high:g} "
            f"| {low:g} to {high:g}{_relative(p)} |\n"
        )
    if not effect.physical:
        lines.append("\n**Not physics**: never named by `diagnose`, added only on request.\n")
    memory = "; depends on what was before" if effect.has_memory else ""
    lines.append(f"\n* Seen in: {', '.join(sorted(effect.experiments))}{memory}.\n")
    if effect.unseen_in:
        reasons = [f"{place} ({why})" for place, why in sorted(effect.unseen_in.items())]
        lines.append(f"* Not in: {'; '.join(reasons)}.\n")
    if effect.not_simulated:
        lines.append(f"* The simulator refuses it: {effect.not_simulated}.\n")
    if effect.confounded_with:
        alike = [f"`{other}`: {why}" for other, why in sorted(effect.confounded_with.items())]
        lines.append(f"* Easily taken for: {'; '.join(alike)}.\n")
    return "".join(lines)


def _relative(parameter: Parameter) -> str:
    """The usual range in a set, where it goes by what was measured."""
    if parameter.relative is None:
        return ""
    of, low, high = parameter.relative
    return f"; in a set {low:g} to {high:g} of its largest {of}"


if __name__ == "__main__":
    PAGE.write_text(page())
