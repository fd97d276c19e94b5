"""The verdict of a diagnosis in plain sentences, with numbers and units that a person reads."""

from __future__ import annotations

from collections.abc import Sequence

from model_lab.diagnosis.result import (
    ADEQUATE,
    EFFECTS_MISSING,
    LEFT_OVER,
    Diagnosis,
    NamedEffect,
)
from model_lab.localisation.axes import DRIVING
from model_lab.measurements.units import display_of

MOST_PARAMETERS = 4  # that a sentence bears
WORDS = {
    "time_since_step": "the time since the last step",
    "time_in_run": "the time since a run began",
    "pressure_rate": "the rate of the input",
    "largest_pressure": "the largest input so far",
    "run_order": "the order of the runs",
    "direction": "the direction of the input",
    "pulse": "the duration and the pressures of a pulse",
}


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence, and how sure it is in another.

    >>> from model_lab.diagnosis.result import Unexplained
    >>> parts = {"within": 0.006, "between": 0.005}
    >>> verdict_sentence(Diagnosis("free_bending", "adequate", "protocols", (), (), (), (), (), {},
    ...     0.0079, parts, "repeats", 0.008, 0.008, "rad", (), Unexplained(0.0, ())))
    'The model is adequate: its error of 0.458 deg is noise, whose floor lies at 0.453 deg.'
    """
    return " ".join(filter(None, [_verdict(diagnosis), sure_sentence(diagnosis)]))


def sure_sentence(diagnosis: Diagnosis) -> str:
    """How many such verdicts are right; nothing where that is not known.

    >>> from types import SimpleNamespace as Made
    >>> sure_sentence(Made(confidence=0.97, guess=False))
    '97 of 100 such verdicts are right.'
    >>> sure_sentence(Made(confidence=0.55, guess=True))
    'That is a guess: 55 of 100 such verdicts are right.'
    """
    if diagnosis.confidence is None:
        return ""
    guess = "That is a guess: " if diagnosis.guess else ""
    return f"{guess}{100 * diagnosis.confidence:.0f} of 100 such verdicts are right."


def _verdict(diagnosis: Diagnosis) -> str:
    shown = display_of(diagnosis.unit).shown
    before, after = shown(diagnosis.rmse_before), shown(diagnosis.rmse_after)
    floor = shown(diagnosis.noise_floor)
    if diagnosis.verdict == ADEQUATE:
        return (
            f"The model is adequate: its error of {before} is noise, whose floor lies at {floor}."
        )
    if diagnosis.verdict == EFFECTS_MISSING:
        few = sum(len(effect.parameters) for effect in diagnosis.effects) <= MOST_PARAMETERS
        named = listed(
            [effect_words(effect) if few else effect.name for effect in diagnosis.effects]
        )
        lacks = "may lack" if diagnosis.guess else "lacks"
        return (
            f"The model {lacks} {named}: with {'it' if len(diagnosis.effects) == 1 else 'them'} "
            f"the held-out error falls from {before} to {after}, at a noise floor of {floor}"
            f"{_left_over(diagnosis)}."
        )
    fails = (
        f"The model fails and no known effect explains it: its error is {before} at a noise floor "
        f"of {floor}"
    )
    helped = f". {_helps(diagnosis)}" if diagnosis.helps else ""
    return f"{fails}{helped}; {_depends(diagnosis)}."


def _depends(diagnosis: Diagnosis) -> str:
    names = [axis_words(name, diagnosis.experiment) for name in diagnosis.unexplained.against]
    return f"what is left varies with {listed(names)}" if names else "what is left follows no input"


def _helps(diagnosis: Diagnosis) -> str:
    """What takes much of the error and is not the whole."""
    display = display_of(diagnosis.unit)
    errors = [diagnosis.rmse_before, *(one.rmse_after for one in diagnosis.helps)]
    falls = [
        f"{one.name} takes {'it' if place == 0 else 'the rest'} from {display.number(before)} to "
        f"{display.shown(one.rmse_after)}"
        for place, (one, before) in enumerate(zip(diagnosis.helps, errors, strict=False))
    ]
    return f"{listed(falls)} and {'is' if len(falls) == 1 else 'they are'} not the whole"


def story_sentence(diagnosis: Diagnosis) -> str:
    """How the error fell, effect by effect, in the order in which they were found; nothing of one.

    >>> from types import SimpleNamespace as Made
    >>> steps = Made(name="tube_lag", rmse_after=0.02), Made(name="gravity", rmse_after=0.01)
    >>> story_sentence(Made(story=steps, unit="N", rmse_before=0.05))
    'One after the other: 0.05 N as it is, 0.02 N with tube_lag, 0.01 N with gravity too.'
    """
    if len(diagnosis.story) < 2:
        return ""
    shown = display_of(diagnosis.unit).shown
    falls = [
        f"{shown(step.rmse_after)} with {step.name}{' too' if place else ''}"
        for place, step in enumerate(diagnosis.story)
    ]
    return f"One after the other: {shown(diagnosis.rmse_before)} as it is, {', '.join(falls)}."


def _left_over(diagnosis: Diagnosis) -> str:
    """What the named effects leave, where that is more than the floor itself."""
    if diagnosis.rmse_after <= LEFT_OVER * diagnosis.noise_floor:
        return ""
    rest = display_of(diagnosis.unit).shown(diagnosis.unexplained.rms)
    names = [axis_words(name, diagnosis.experiment) for name in diagnosis.unexplained.against]
    varies = f", which varies with {listed(names)}" if names else ""
    return f"; {rest} of it nothing known explains{varies}"


def notice_sentence(clauses: Sequence[str]) -> str:
    """What is odd about a set, from the clauses of its notices; nothing without any."""
    return f"Note: {'; '.join(clauses)}." if clauses else ""


def tie_sentences(diagnosis: Diagnosis) -> list[str]:
    """What the data cannot tell apart, a sentence for each named effect that is tied."""
    return [
        f"These data cannot tell {effect.name} from {listed(names, 'or')}."
        for effect, names in zip(diagnosis.effects, diagnosis.tied, strict=True)
        if names
    ]


def effect_words(effect: NamedEffect) -> str:
    """An effect with its parameters and their standard errors."""
    values = [
        f"{name} = {entry.value:.3g} ± {entry.std:.2g} {entry.unit}".rstrip()
        for name, entry in effect.parameters.items()
    ]
    return f"{effect.name} ({', '.join(values)})" if values else effect.name


def axis_words(name: str, experiment: str = "") -> str:
    """An axis or the input of a black box as one says it of an experiment.

    >>> axis_words("pressure", "uniaxial")
    'the stretch'
    """
    driving = DRIVING.get(experiment, (name,))[0] if name == "pressure" else name
    return WORDS.get(name, f"the {driving}")


def listed(words: Sequence[str], last: str = "and") -> str:
    """Words one after the other.

    >>> listed(["a", "b", "c"])
    'a, b and c'
    """
    return f" {last} ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def counted(number: int, noun: str) -> str:
    """How many there are of something.

    >>> counted(4698, "sample"), counted(1, "run")
    ('4 698 samples', '1 run')
    """
    return f"{number:,} {noun}{'' if number == 1 else 's'}".replace(",", " ")
