"""Why `compare`, `diagnose` and `ladder` do not print the same noise floor of one set."""

from __future__ import annotations

from model_lab.comparison.ladder import Ladder
from model_lab.diagnosis.result import LOWERED, MENDED, THINNED, WITHOUT_EVENTS, Diagnosis

WHY = {
    LOWERED: "repeats differ by what the better model explains",
    MENDED: "it does not correct how the data are described",
    WITHOUT_EVENTS: "it does not correct the events in the series of runs",
    THINNED: "the diagnosis leaves out samples of long runs",
}


def floor_sentence(diagnosis: Diagnosis) -> str:
    """A sentence on why `compare` prints another noise floor than a diagnosis; "" if it prints the
    same.

    >>> from types import SimpleNamespace as Made
    >>> from model_lab.measurements.units import display_of
    >>> made = {"display": display_of("N"), "noise_floor": 0.02, "noise_floor_as_is": 0.05}
    >>> floor_sentence(Made(floor_reasons=("lowered",), **made))
    'The noise floor is 0.02 N; `compare` has 0.05 N: repeats differ by what the better model \
explains.'
    >>> floor_sentence(Made(floor_reasons=(), **made))
    ''
    """
    reasons = diagnosis.floor_reasons
    if not reasons:
        return ""
    shown = diagnosis.display.shown
    as_is = diagnosis.noise_floor_as_is
    other = shown(as_is) if reasons == (LOWERED,) and as_is is not None else "another"
    why = ", and ".join(WHY[reason] for reason in reasons)
    return f"The noise floor is {shown(diagnosis.noise_floor)}; `compare` has {other}: {why}."


def ladder_sentence(ladder: Ladder) -> str:
    """A sentence on which model's noise floor a ladder prints, if its models show different ones;
    else "".
    """
    shown = ladder.data.output_display.shown
    floors = {rung.name: shown(rung.errors.floor.total) for rung in ladder.rungs}
    best = floors.pop(ladder.best.name)
    others = [f"{floor} of {name}" for name, floor in floors.items() if floor != best]
    if not others:
        return ""
    return (
        f"The noise floor is that of {ladder.best.name}, the best; `compare` has "
        f"{', '.join(others)}: repeats differ by what the better model explains."
    )
