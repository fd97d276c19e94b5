"""The verdict of a diagnosis in plain sentences, with numbers and units that a person reads."""

from __future__ import annotations

from collections.abc import Sequence

from model_lab.diagnosis.result import ADEQUATE, EFFECTS_MISSING, Diagnosis, NamedEffect
from model_lab.measurements.units import display_of

MOST_PARAMETERS = 4  # that a sentence bears
LEFT_OVER = 2.0  # error after over the noise floor, from which the rest is worth a word
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
    """The verdict in one sentence.

    >>> from model_lab.diagnosis.result import Unexplained
    >>> parts = {"within": 0.006, "between": 0.005}
    >>> verdict_sentence(Diagnosis("free_bending", "adequate", "protocols", (), (), (), (), (), {},
    ...     0.0079, parts, "repeats", 0.008, 0.008, "rad", (), Unexplained(0.0, ())))
    'The model is adequate: its error of 0.458 deg is noise, whose floor lies at 0.453 deg.'
    """
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
        return (
            f"The model lacks {named}: with {'it' if len(diagnosis.effects) == 1 else 'them'} "
            f"the held-out error falls from {before} to {after}, at a noise floor of {floor}"
            f"{_left_over(diagnosis)}."
        )
    against = listed([axis_words(name) for name in diagnosis.unexplained.against])
    depends = f"what is left varies with {against}" if against else "what is left follows no input"
    return (
        f"The model fails and no known effect explains it: its error is {before} at a noise floor "
        f"of {floor}; {depends}."
    )


def _left_over(diagnosis: Diagnosis) -> str:
    """What the named effects leave, where that is more than the floor itself."""
    if diagnosis.rmse_after <= LEFT_OVER * diagnosis.noise_floor:
        return ""
    rest = display_of(diagnosis.unit).shown(diagnosis.unexplained.rms)
    return f"; {rest} of it nothing known explains"


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


def axis_words(name: str) -> str:
    """An axis or the input of a black box as one says it."""
    return WORDS.get(name, f"the {name}")


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
