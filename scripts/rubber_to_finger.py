"""What a P5 would do at 210 kPa, by every law that a test of its rubber may be fitted with.

`python -m scripts.rubber_to_finger SET [--pressure PA]` fits each law of rubber in the catalogue to
a measurement set of the experiments uniaxial or rubber, alone and the modulus free, as `model-lab
add LAW --free-modulus` does, and bends a free P5 with it; Yeoh's third term also beside the second.
Prints a table in Markdown. A name of SET without a folder of it is sought in
SOFTHAND_MEASUREMENTS.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from model_lab.comparison.add import add_effect
from model_lab.diagnosis.result import modulus_of
from model_lab.diagnosis.search import score_base
from model_lab.fitting.problem import pose_problem
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import display_of
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model, load_model
from thesis.p5.p5 import MARKER, P5, by_model

VARIABLE = "SOFTHAND_MEASUREMENTS"
LAWS = (
    ("gent_stiffening",),
    ("yeoh_stiffening",),
    ("yeoh_stiffening", "yeoh_third_order"),
    ("arruda_boyce",),
    ("ogden",),
    ("second_invariant",),
    ("mooney_rivlin",),
)  # the last is a mere modulus in a wall
HEAD = ("law", "shear modulus", "parameters", "held-out error", "2/kappa of a P5", "stretch there")


def fitted(data: MeasurementSet, law: Sequence[str]) -> tuple[Model, float]:
    """The base model with the effects of a law, and its held-out error."""
    model = replace(load_model("base"), free_modulus=True)
    for name in law:
        added = add_effect(name, data, model, effect_classes())
        model = replace(added.model, free_modulus=True)
    return model, added.after.held_out.rmse


def neo_hooke(data: MeasurementSet) -> tuple[Model, float]:
    """The bare model with the modulus of the test, and its held-out error."""
    problem, _ = pose_problem(data, replace(load_model("base"), free_modulus=True), {})
    found = score_base(problem)
    (modulus,) = modulus_of(found, problem.data).values()
    return Model("pneuflex", {"modulus": modulus.value}), found.held_out.rmse


def row(name: str, model: Model, error: str, pressure: float) -> list[str]:
    """One law: what it was fitted with, and what it predicts."""
    modulus = f"{model.shear_modulus(P5.shear_modulus) / 1e3:.1f} kPa"
    values = [
        f"{key} = {value:.3g}" for effect in model.effects for key, value in effect.values.items()
    ]
    kappa = by_model(model)(pressure)
    stretch = 1.0 + kappa * float(P5.height(0.0))
    said = [modulus, ", ".join(values) or "-", error]
    return [name, *said, f"{2e3 / kappa:.1f} mm", f"{stretch:.2f}"]


def rows(data: MeasurementSet, pressure: float) -> list[list[str]]:
    """All laws, the bare model with a free modulus first."""
    shown = display_of(data.unit).shown
    found = {"neo-Hooke": neo_hooke(data)}
    found |= {" + ".join(f"`{name}`" for name in law): fitted(data, law) for law in LAWS}
    return [row(law, model, shown(error), pressure) for law, (model, error) in found.items()]


def main(arguments: list[str]) -> int:
    """Print the table; 1 without the measurements."""
    parser = argparse.ArgumentParser(description="a P5 by every law of a tested rubber")
    parser.add_argument("data", metavar="SET", type=Path)
    parser.add_argument("--pressure", type=float, default=210e3, help="gauge [Pa]")
    given = parser.parse_args(arguments)
    path = given.data if given.data.is_dir() else Path(os.environ.get(VARIABLE, ".")) / given.data
    if not path.is_dir():
        print(f"no measurements: {given.data}; name a folder or set {VARIABLE}", file=sys.stderr)
        return 1
    lines = [list(HEAD), ["---"] * len(HEAD), *rows(load_measurements(path), given.pressure)]
    print("\n".join(f"| {' | '.join(line)} |" for line in lines))
    print(f"\nAsked for: above {1e3 * MARKER:g} mm at {given.pressure / 1e3:g} kPa.")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
