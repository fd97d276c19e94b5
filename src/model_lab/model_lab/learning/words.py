"""What `learn` prints."""

from __future__ import annotations

from model_lab.learning.effect_file import Shape
from model_lab.learning.learn import Candidate, Learning

MOST_ALTERNATIVES = 8  # alternatives


def verdict(learning: Learning) -> str:
    """One or two sentences on what was learned."""
    shown = learning.problem.data.output_display.shown
    before, floor = shown(learning.base.held_out.rmse), shown(learning.problem.floor.total)
    if learning.chosen is None:
        return (
            f"Nothing was learned: {learning.reason} (error {before}, at a noise floor of {floor})."
        )
    chosen = learning.chosen
    after = shown(chosen.scored.held_out.rmse)
    said = [
        f"{chosen.shape.title[:-1]}: with it the held-out error falls from {before} to {after}, "
        f"at a noise floor of {floor}."
    ]
    tied = [words_of(one.shape) for one in learning.others if learning.is_tied(one)]
    if tied:
        said.append(f"These data cannot tell it from: {'; '.join(tied)}.")
    for one in learning.further:
        left = shown(one.scored.held_out.rmse)
        said.append(f"Beside it: {_small(one.shape.title[:-1])}, which leaves {left}.")
    return " ".join(said)


def _small(sentence: str) -> str:
    return sentence[0].lower() + sentence[1:]


def words_of(shape: Shape) -> str:
    """A candidate as a short phrase."""
    return f"{shape.form} at the stage {shape.stage} against the {_axis_of(shape)}"


def _axis_of(shape: Shape) -> str:
    """What a curve is a function of: for the input, the input of this experiment."""
    if shape.against == "pressure":
        return shape.abscissa.partition(" [")[0]
    return shape.against.replace("_", " ")


def curve_rows(candidate: Candidate) -> list[list[str]]:
    """Rows of a table of the curve at its knots, the header first."""
    shape = candidate.shape
    rows = [[shape.abscissa, shape.ordinate, "std"]]
    for at, value, std in zip(shape.labels, candidate.values, candidate.spread, strict=True):
        rows.append([at, f"{value:.4g}", f"{std:.2g}"])
    return rows


def alternative_rows(learning: Learning) -> list[list[str]]:
    """Rows of a table of the candidates that were fitted together with the model, the
    header first.
    """
    shown = learning.problem.data.output_display.shown
    every = [one for one in (learning.chosen, *learning.others) if one is not None]
    rows = [["stage", "form", "against", "held-out error", ""]]
    for one in every[:MOST_ALTERNATIVES]:
        note = "chosen" if one is learning.chosen else "tied" if learning.is_tied(one) else ""
        shape = one.shape
        error = shown(one.scored.held_out.rmse)
        rows.append([shape.stage, shape.form, _axis_of(shape), error, note])
    return rows
