"""Text and JSON of a comparison, and of a ladder of models."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from model_lab.comparison.compare import Accuracy, Comparison, Part
from model_lab.comparison.ladder import Ladder, Rung
from model_lab.fitting.noise_floor import REPEATS, SPLINE, STATED
from model_lab.localisation.axes import DRIVING_QUANTITY
from model_lab.localisation.localise import Dependence
from model_lab.measurements.units import Display
from model_lab.report.event_sentences import doubted_sentence, event_sentences
from model_lab.report.floor_sentences import ladder_sentence
from model_lab.report.sentences import (
    bound_sentence,
    counted,
    notice_sentence,
    preconditioning_sentence,
    slip_sentences,
)
from model_lab.report.text import text_table
from model_lab.rules import RULES
from model_lab.series.within_runs import WithinRuns

COMPARISON_FORMAT, LADDER_FORMAT = "softhand-comparison/1", "softhand-ladder/1"
BAR_LENGTH = 40  # characters of the largest error on a ladder
LISTED_RUNS = 24  # that are listed; of more only the worst
WORST_RUNS = 12
MANY_TIMES = 10.0
FLOOR_CELLS = {
    REPEATS: "from repeats",
    STATED: "as the set states it",
    SPLINE: "from the residual of smoothing splines, as there are no repeats and none is stated",
}


def comparison_text(found: Comparison, model_name: str) -> str:
    """The text that `compare` prints."""
    sections = [
        "\n".join(_before_all(found)),
        _head(found, model_name),
        _errors(found),
        preconditioning_sentence(found.data),
        notice_sentence([notice.text for notice in found.notices]),
        _series(found),
        _failures(found),
        _parts("output", found.outputs, found) if len(found.outputs) > 1 else "",
        _parts("specimen", found.specimens, found) if len(found.specimens) > 1 else "",
        _run_table(found),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def comparison_json(found: Comparison, model_name: str) -> dict[str, Any]:
    """The dictionary that `compare --json` writes, all in SI units."""
    return {
        "format": COMPARISON_FORMAT,
        "experiment": found.data.experiment,
        "title": found.data.title,
        "model": model_name,
        "base": found.errors.model.base,
        "effects": [effect.name for effect in found.errors.model.effects],
        "calibration": found.errors.calibration,
        "calibration_fitted": found.errors.calibrated,
        "unit": found.data.unit,
        "holdout": found.errors.holdout,
        "samples": found.errors.as_is.samples,
        "rmse": found.errors.as_is.rmse,
        "rmse_heldout": found.errors.held_out.rmse,
        "fit_percent": found.errors.as_is.fit,
        "fit_percent_heldout": found.errors.held_out.fit,
        "as_it_is": _accuracy_json(found.errors.as_is),
        "held_out": _accuracy_json(found.errors.held_out),
        "noise_floor": found.errors.floor.total,
        "noise_floor_upper": found.errors.floor.upper,
        "noise_floor_parts": {
            "within": found.errors.floor.within,
            "between": found.errors.floor.between,
        },
        "noise_floor_source": found.errors.floor.source,
        "outputs": [_part_json(part) for part in found.outputs],
        "specimens": [_part_json(part) for part in found.specimens],
        "runs": [_run_json(found, index) for index in range(len(found.runs))],
        "constant_share_of_error": found.localisation.constant,
        "failures": [_failure_json(axis) for axis in found.localisation.failures],
        "axes": [_axis_json(axis) for axis in found.localisation.axes],
        "input_relation": _relation_json(found),
        "notices": [notice.as_json() for notice in found.notices],
        "slips": [asdict(slip) for slip in found.slips],
        "series": {
            "freedom": found.series.freedom,
            "p_value": found.series.p_value,
            "events": [event.as_json() for event in found.series.events],
        },
        "residual_tests": None if found.within is None else found.within.as_json(),
        "outside": found.outside,
        "at_bound": list(found.errors.at_bound),
    }


# ---------------------------------------------------------------------- text
def _head(found: Comparison, model_name: str) -> str:
    data = found.data
    title = [data.title] if data.title else []
    counts = ", ".join(
        [
            counted(len(data.runs), "run"),
            counted(len(found.specimens), "specimen"),
            counted(len(data.protocols()), "protocol"),
            counted(found.errors.as_is.samples, "sample"),
        ]
    )
    effects = ", ".join(effect.name for effect in found.errors.model.effects) or "no effects"
    how = "fitted to these data" if found.errors.calibrated else "of the file"
    return "\n".join(
        [
            *title,
            f"{data.experiment.replace('_', ' ')}: {counts}",
            f"model {model_name}: base {found.errors.model.base}, {effects}",
            f"calibration {how}: {_calibration(found.errors.calibration)}",
        ]
    )


def _calibration(calibration: Mapping[str, Any]) -> str:
    shown = []
    for name, value in calibration.items():
        if isinstance(value, Mapping):
            shown += [f"{name}[{key}] {entry:.4g}" for key, entry in value.items()]
        else:
            shown.append(f"{name} {value:.4g}")
    return ", ".join(shown) or "none"


def _before_all(found: Comparison) -> list[str]:
    """What is told before the model is compared: slips, data outside the model, bounds."""
    said = slip_sentences(found.slips, found.data.output_display, found.fits_mended)
    if not found.fits_mended:
        said.append("`model-lab diagnose` finds out whether an effect explains this error.")
    if found.outside:
        said.append(f"No model can be judged by these data. {found.outside}.")
    bound = bound_sentence(found.errors.at_bound, found.errors.calibration)
    return said or [bound] if bound else said


def _errors(found: Comparison) -> str:
    display, floor = found.data.output_display, found.errors.floor
    holdout = found.errors.holdout
    kept = "blocks of the runs" if holdout == "blocks" else holdout
    how = "fitted to all the data" if found.errors.calibrated else "as its file has it"
    rows = [
        ["", f"error [{display.unit}]", "fit", ""],
        ["all data", *_accuracy(found.errors.as_is, display), how],
        [
            "held out",
            *_accuracy(found.errors.held_out, display),
            f"fitted to the other {kept} each time",
        ],
        ["noise floor", display.number(floor.total), "", FLOOR_CELLS[floor.source]],
    ]
    return f"{text_table(rows)}\n{_judgement(found)}"


def _judgement(found: Comparison) -> str:
    floor, display = found.errors.floor, found.data.output_display
    if found.errors.held_out.rmse <= floor.upper:
        error = "The held-out error lies within the noise floor."
    else:
        times = found.errors.held_out.rmse / floor.total
        shown = f"{times:.0f}" if times >= MANY_TIMES else f"{times:.2g}"
        error = f"The held-out error is {shown} times the noise floor."
        if not (found.slips or found.outside) and times > RULES.explained_error:
            error += (
                " No mistake in the description of the data, such as a wrong unit, explains it "
                "alone; `diagnose` also tests such mistakes together with effects."
            )
    within, between, upper = (display.number(v) for v in (floor.within, floor.between, floor.upper))
    parts = (
        f"The floor is {within} within a run and {between} between runs, {upper} at most (95 %)."
    )
    return f"{error}\n{parts}"


def _accuracy(accuracy: Accuracy, display: Display) -> list[str]:
    fit = f"{accuracy.fit:.1f} %" if np.isfinite(accuracy.fit) else "-"
    return [display.number(accuracy.rmse), fit]


def _failures(found: Comparison) -> str:
    localisation = found.localisation
    lines = []
    if localisation.constant > RULES.failure_p_value:
        share = f"{100.0 * localisation.constant:.0f} %"
        lines.append([share, "", "a constant error", _signed(found)])
    for axis in localisation.failures:
        share = f"{100.0 * axis.share_of_error:.0f} %"
        lines.append(
            [share, f"{axis.p_value:.2g}", _axis_name(axis, found.data.experiment), axis.where]
        )
    clean = [a.against for a in localisation.axes if a not in localisation.failures]
    quiet = f"nothing beyond chance against {_listed(clean)}" if clean else ""
    if not lines:
        return f"Where it fails: {quiet or 'no axis varies in this set'}."
    head = ["share of error", "p", "against", "where"]
    basis = f" (drawn at random: {localisation.axes[0].basis})" if localisation.axes else ""
    text = f"Where it fails{basis}\n{text_table([head, *lines])}"
    return "\n".join(filter(None, [text, _loops(found), quiet and f"{quiet.capitalize()}."]))


def _series(found: Comparison) -> str:
    """Events between runs, and whether the residual within runs is white."""
    events = [event.as_json() for event in found.series.events]
    lines = event_sentences(events, (), found.data.output_display)
    doubted = found.series.doubted
    if doubted is not None:
        lines.append(doubted_sentence(doubted.as_json(), found.data.output_display))
    elif not events and found.series.freedom:
        lines.append(
            f"Repeats do not depend on the order of the runs (p {found.series.p_value:.2g})."
        )
    if found.within is not None:
        lines.append(_within_runs(found.within))
    return "\n".join(lines)


def _within_runs(within: WithinRuns) -> str:
    near = float(within.autocorrelation[1])
    text = (
        f"Within runs neighbouring errors correlate by {near:.2f} (white noise: "
        f"{within.white_band:.2f} at most)"
    )
    if within.input_band is None:
        return f"{text}."
    largest = float(np.max(np.abs(within.input_correlation)))
    return f"{text}, errors with the input by {largest:.2f} ({within.input_band:.2f} at most)."


def _signed(found: Comparison) -> str:
    word = "more" if found.errors.held_out.bias > 0.0 else "less"
    shown = found.data.output_display.shown(abs(found.errors.held_out.bias))
    return f"{shown} {word} is measured than predicted, on the average"


def _axis_name(axis: Dependence, experiment: str) -> str:
    """The name of an axis, as it is where no pressure drives the runs."""
    name = axis.against.replace("_", " ")
    stands = experiment in DRIVING_QUANTITY and not axis.bins.axis.of_run and name != "direction"
    return f"{name} ({axis.bins.axis.noun})" if stands else name


def _loops(found: Comparison) -> str:
    """How much the error differs between the way up and the way down, if by much."""
    if found.relation is None:
        return ""
    widths = np.array([float(width[0]) for width in found.relation.loop_width.values()])
    closed = widths[np.isfinite(widths)]
    middle = float(np.median(closed)) if len(closed) else 0.0
    if abs(middle) < found.errors.floor.total:
        return ""
    shown = found.data.output_display.shown(abs(middle))
    word = "more" if middle > 0.0 else "less"
    return f"On the way down {shown} {word} is measured than on the way up."


def _run_table(found: Comparison) -> str:
    if len(found.runs) <= LISTED_RUNS:
        return _parts("run", found.runs, found)
    worst = sorted(found.runs, key=lambda part: -part.held_out.rmse)[:WORST_RUNS]
    return f"{_parts('worst runs', worst, found)}\n(all {len(found.runs)} runs: --json)"


def _parts(noun: str, parts: Iterable[Part], found: Comparison) -> str:
    display = found.data.output_display
    protocols = {run.name: run.protocol for run in found.data.runs}
    unit = f"[{display.unit}]"
    head = [noun, "samples", f"all data {unit}", "fit", f"held out {unit}", "fit", f"bias {unit}"]
    rows = [
        [
            part.name,
            str(part.as_is.samples),
            *_accuracy(part.as_is, display),
            *_accuracy(part.held_out, display),
            display.number(part.held_out.bias, 2),
            protocols.get(part.name, ""),
        ]
        for part in parts
    ]
    return text_table([[*head, "protocol" if any(row[-1] for row in rows) else ""], *rows])


def _listed(names: Sequence[str]) -> str:
    return ", ".join(name.replace("_", " ") for name in names)


# ---------------------------------------------------------------------- JSON
def _accuracy_json(accuracy: Accuracy) -> dict[str, Any]:
    return {
        "rmse": accuracy.rmse,
        "fit_percent": accuracy.fit,
        "bias": accuracy.bias,
        "largest": accuracy.largest,
    }


def _part_json(part: Part) -> dict[str, Any]:
    return {
        "name": part.name,
        "samples": part.as_is.samples,
        "as_it_is": _accuracy_json(part.as_is),
        "held_out": _accuracy_json(part.held_out),
    }


def _run_json(found: Comparison, index: int) -> dict[str, Any]:
    run = found.data.runs[index]
    about = {"specimen": run.specimen, "protocol": run.protocol, "temperature": run.temperature}
    loops = {} if found.relation is None else {
        "loop_area": found.relation.loop_area[run.name],
        "loop_width": found.relation.loop_width[run.name],
    }  # fmt: skip
    return {**_part_json(found.runs[index]), **about, **loops}


def _failure_json(axis: Dependence) -> dict[str, Any]:
    return {
        "against": axis.against,
        "where": axis.where,
        "p_value": axis.p_value,
        "share_of_error": axis.share_of_error,
    }


def _axis_json(axis: Dependence) -> dict[str, Any]:
    bins = axis.bins
    return {
        **_failure_json(axis),
        "noun": bins.axis.noun,
        "unit": bins.axis.unit,
        "basis": axis.basis,
        "categories": bins.axis.categories,
        "center": bins.center,
        "curves": {
            name: {"mean": curve.mean, "low": curve.low, "high": curve.high, "count": curve.count}
            for name, curve in axis.curves.items()
        },
    }


def _relation_json(found: Comparison) -> dict[str, Any] | None:
    if found.relation is None:
        return None
    relation = found.relation
    strongest = [relation.strongest(output) for output in range(len(found.data.outputs))]
    return {
        "lag_unit": relation.lag_unit,
        "lag": relation.lag,
        "correlation": relation.correlation,
        "strongest": [{"lag": lag, "correlation": value} for lag, value in strongest],
    }


# ---------------------------------------------------------------------- ladder
def ladder_text(ladder: Ladder) -> str:
    """The text that `ladder` prints."""
    display, floor = ladder.data.output_display, ladder.floor
    largest = max(rung.errors.held_out.rmse for rung in ladder.rungs)
    unit = f"[{display.unit}]"
    rows = [["model", f"held out {unit}", "fit", f"all data {unit}", "over floor", ""]]
    for rung in ladder.rungs:
        held_out, as_is = rung.errors.held_out, rung.errors.as_is
        rows.append(
            [
                rung.name,
                display.number(held_out.rmse),
                f"{held_out.fit:.1f} %",
                display.number(as_is.rmse),
                f"{held_out.rmse / floor.total:.1f}",
                _bar(held_out.rmse / largest),
            ]
        )
    rows.append(
        ["noise floor", display.number(floor.total), "", "", "", _bar(floor.total / largest)]
    )
    title = ladder.data.title or ladder.data.experiment
    why = ladder_sentence(ladder)
    return f"{title}\n\n{text_table(rows)}\n" + (f"\n{why}\n" if why else "")


def ladder_json(ladder: Ladder) -> dict[str, Any]:
    """The dictionary that `ladder --json` writes, all in SI units."""
    floor = ladder.floor
    return {
        "format": LADDER_FORMAT,
        "experiment": ladder.data.experiment,
        "unit": ladder.data.unit,
        "holdout": ladder.best.errors.holdout,
        "noise_floor": floor.total,
        "noise_floor_upper": floor.upper,
        "noise_floor_parts": {"within": floor.within, "between": floor.between},
        "best": ladder.best.name,
        "models": [_rung_json(rung) for rung in ladder.rungs],
    }


def _bar(share: float) -> str:
    return "#" * max(round(BAR_LENGTH * share), 1)


def _rung_json(rung: Rung) -> dict[str, Any]:
    errors = rung.errors
    return {
        "model": rung.name,
        "base": errors.model.base,
        "effects": [effect.name for effect in errors.model.effects],
        "calibration": errors.calibration,
        "rmse": errors.as_is.rmse,
        "rmse_heldout": errors.held_out.rmse,
        "fit_percent": errors.as_is.fit,
        "fit_percent_heldout": errors.held_out.fit,
    }
