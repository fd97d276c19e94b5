"""What happened in a series of measurements, in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from model_lab.measurements.units import Display
from model_lab.series.events import DRIFT_EVENT, EXCHANGED, ODD_RUN, SLOW_COURSE, STEP_EVENT
from model_lab.series.run_scale import LOAD_SCALE, OUTPUT_SCALE
from model_lab.slips.slip import Slip

OF_SERIES = (ODD_RUN, EXCHANGED)
"""Names of slips that are told as events."""
LARGE_FACTOR = 2.0  # from which a change is said as a factor


def event_sentences(
    events: Sequence[Mapping[str, Any]], slips: Sequence[Slip], display: Display
) -> list[str]:
    """A sentence for each event of a diagnosis; only one if a step or drift changes both scale and
    zero. slips: those found for odd runs among the events.

    >>> step = {"kind": "step", "run": "r7", "before": "r6", "specimen": None,
    ...     "quantity": "scale", "size": 0.09, "p_value": 2e-6, "largest_input": "r7"}
    >>> print(event_sentences([step], [], Display("deg"))[0])
    Repeats before and after run r7 do not agree (+9 %, p 2e-06): an event between runs r6 and r7 \
(the largest input so far is in r7), not noise.
    """
    told: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for event in events:
        told.setdefault(tuple(event[key] for key in ("kind", "run", "specimen")), []).append(event)
    return [_sentence(same, slips, display) for same in told.values()]


def doubted_sentence(event: Mapping[str, Any], display: Display) -> str:
    """A sentence on a step or drift that is uncertain, or on a course of another kind.

    >>> drift = {"kind": "drift", "quantity": "scale", "size": 0.054, "p_value": 0.032}
    >>> print(doubted_sentence(drift, Display("deg")))
    Repeats may differ with the order of the runs (a drift of +5.4 %, p 0.032): add repeats to see.
    >>> print(doubted_sentence(drift | {"kind": "course", "p_value": 0.002}, Display("deg")))
    Repeats vary by 5.4 % (rms) from run to run, most runs about like the one before (p 0.002): \
something changes slowly between runs, and the noise floor contains it.
    """
    if event["kind"] == SLOW_COURSE:
        about = change_words(event, display).lstrip("+")
        return (
            f"Repeats vary by {about} (rms) from run to run, most runs about like the one before "
            f"(p {event['p_value']:.2g}): something changes slowly between runs, and the noise "
            "floor contains it."
        )
    return (
        f"Repeats may differ with the order of the runs (a {event['kind']} of "
        f"{change_words(event, display)}, p {event['p_value']:.2g}): add repeats to see."
    )


def _sentence(same: Sequence[Mapping[str, Any]], slips: Sequence[Slip], display: Display) -> str:
    event = min(same, key=lambda one: float(one["p_value"]))
    size = " and ".join(change_words(one, display) for one in same)
    of = f" of {event['specimen']}" if event["specimen"] else ""
    about = f"({size}, p {event['p_value']:.2g})"
    if event["kind"] == STEP_EVENT:
        largest = event.get("largest_input")
        seen = f" (the largest input so far is in {largest})" if largest else ""
        return (
            f"Repeats{of} before and after run {event['run']} do not agree {about}: an event "
            f"between runs {event['before']} and {event['run']}{seen}, not noise."
        )
    if event["kind"] == DRIFT_EVENT:
        return f"Repeats{of} differ with the order of the runs {about}: a drift, not noise."
    slip = next((s for s in slips if s.name in OF_SERIES and s.column == event["run"]), None)
    return _odd_sentence(event, slip, about, display)


def _odd_sentence(event: Mapping[str, Any], slip: Slip | None, about: str, display: Display) -> str:
    shown = display.shown
    if slip is None:
        return f"Run {event['run']} is unlike its repeats {about} and is set aside."
    if event["kind"] == EXCHANGED:
        return (
            f"Runs {event['run']} and {event['other']} are unlike their repeats and fit when "
            f"exchanged: their error falls from {shown(slip.rmse_before)} to "
            f"{shown(slip.rmse_after)}. They are set aside."
        )
    text = f"Run {event['run']} is unlike its repeats {about} and is set aside"
    if slip.rmse_after < slip.rmse_before:
        return (
            f"{text}: it fits as {slip.fits}, not {slip.said}; its error falls from "
            f"{shown(slip.rmse_before)} to {shown(slip.rmse_after)}."
        )
    return f"{text}: its error is {shown(slip.rmse_before)}. Check it, or measure it again."


def change_words(event: Mapping[str, Any], display: Display) -> str:
    """How much an event changes the outputs, in words.

    >>> change_words({"quantity": "scale", "size": 5.9}, Display("deg"))
    '6.9 times as large'
    >>> change_words({"quantity": "load", "size": 0.12}, Display("deg"))
    'pressure has 12 % more effect, as if the rubber had become softer'
    """
    if event["quantity"] == LOAD_SCALE:
        more, softer = ("more", "softer") if event["size"] > 0.0 else ("less", "stiffer")
        change = f"{100.0 * abs(event['size']):.2g} % {more}"
        return f"pressure has {change} effect, as if the rubber had become {softer}"
    if event["quantity"] != OUTPUT_SCALE:
        sign = "+" if event["size"] > 0 else "-"
        return f"{sign}{display.shown(abs(event['size']))}"
    factor = 1.0 + event["size"]
    if not 1.0 / LARGE_FACTOR < factor < LARGE_FACTOR:
        return f"{factor:.2g} times as large"
    return f"{100.0 * event['size']:+.2g} %"
