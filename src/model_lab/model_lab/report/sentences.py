"""The verdict of a diagnosis in plain sentences, with numbers and units that a person reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isclose
from typing import Any

from model_lab.diagnosis.limited_sensor import SENSOR_LIMIT
from model_lab.diagnosis.own_moduli import OWN_MODULI, varies_with_castings
from model_lab.diagnosis.result import (
    ADEQUATE,
    EFFECTS_MISSING,
    REPEATS_APART,
    UNEXPLAINED,
    Diagnosis,
    NamedEffect,
)
from model_lab.experiments.hand_pose import HAND_WEIGHT
from model_lab.experiments.samples import USUAL_MODULUS_SCALES
from model_lab.learning import words
from model_lab.learning.learn import Learning
from model_lab.localisation.axes import DRIVING_QUANTITY
from model_lab.measurements.hands import OF_HANDS
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import Display, display_among
from model_lab.report.event_sentences import OF_SERIES, event_sentences
from model_lab.rules import RULES
from model_lab.series.events import ODD_RUN
from model_lab.slips.slip import Slip
from softhand_model.effects.second_relaxation import SecondRelaxation

SENTENCE_PARAMETERS = 4  # that a sentence bears
AXIS_WORDS = {
    "time_since_step": "the time since the last step",
    "time_in_run": "the time since a run began",
    "pressure_rate": "the rate of the input",
    "largest_pressure": "the largest input so far",
    "run_order": "the order of the runs",
    "direction": "the direction of the input",
    "pulse": "the duration and the pressures of a pulse",
}


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """The verdict in one sentence, and in another one how sure it is.

    >>> from model_lab.diagnosis.result import Unexplained
    >>> parts = {"within": 0.006, "between": 0.005}
    >>> verdict_sentence(Diagnosis("free_bending", "adequate", "protocols", (), (), (), (), (), {},
    ...     0.0079, parts, "repeats", 0.008, 0.008, "rad", (), Unexplained(0.0, ())))
    'The model is adequate: its error of 0.458 deg can be noise alone (noise floor 0.453 deg).'
    """
    without = " without them" if diagnosis.effects else ""
    bound = bound_sentence(diagnosis.at_bound, diagnosis.calibration_as_is, without)
    bound = _with_freed(bound, diagnosis)
    return " ".join(filter(None, [_verdict(diagnosis), sure_sentence(diagnosis), bound]))


def _with_freed(bound: str, diagnosis: Diagnosis) -> str:
    """The sentence on the bound, with what a free modulus alone leaves; "" if that would be farther
    off than the modulus of another mix may be.
    """
    if not bound or diagnosis.freed is None:
        return bound
    freed = diagnosis.freed["modulus_scale"].values()
    if any(max(scale, 1.0 / scale) > RULES.other_mix for scale in freed):
        return ""
    scales = listed([f"{scale:.3g}" for scale in freed])
    left = diagnosis.display.shown(diagnosis.freed["rmse_heldout"])
    return f"{bound[:-1]}, and {scales} times the stated one alone leaves {left}."


def sure_sentence(diagnosis: Diagnosis) -> str:
    """A sentence on how many such verdicts are right, rounded down, or on why that is not known.

    >>> from types import SimpleNamespace as Made
    >>> known = {"effects": (), "tied": (), "beyond": ()}
    >>> sure_sentence(Made(confidence=0.996, guess=False, **known))
    '99 of 100 such verdicts are right.'
    >>> sure_sentence(Made(confidence=0.55, guess=True, **known))
    'That is a guess: 55 of 100 such verdicts are right.'
    """
    if diagnosis.confidence is None:
        return _why_unknown(diagnosis)
    guess = "That is a guess: " if diagnosis.guess else ""
    hundredths = int(100.0 * diagnosis.confidence + 1e-6)
    right = "name the cause among what is tied" if any(diagnosis.tied) else "are right"
    return f"{guess}{hundredths} of 100 such verdicts {right}."


def _why_unknown(diagnosis: Diagnosis) -> str:
    """Why no number says how sure a verdict is; empty where another sentence tells that."""
    if REPEATS_APART in diagnosis.beyond:
        parts, shown = diagnosis.noise_floor_parts, diagnosis.display.shown
        return (
            f"That is a guess: repeats differ by {shown(parts['between'])}, far more than the "
            f"{shown(parts['within'])} of noise within a run. The noise floor contains this "
            "difference: see which runs differ, and why."
        )
    loose = [f"{name} of {one.name}" for one in diagnosis.effects for name in one.undetermined]
    if loose:
        return f"That is a guess: these data do not determine {listed(loose)}."
    mending = [one for one in diagnosis.effects if one.form_of]
    if mending:
        names, others = listed([one.name for one in mending]), listed(mending[0].form_of)
        return (
            f"That is a guess: {names} may only make up for the equation of {others or 'another'}, "
            "whose true form need not be that of the catalogue."
        )
    if diagnosis.beyond:
        guess = "That is a guess: how" if diagnosis.guess else "How"
        return (
            f"{guess} often such verdicts are right is not known, as this set is unlike those for "
            f"which they were counted ({listed(diagnosis.beyond)} in `evidence`)."
        )
    if diagnosis.experiment in OF_HANDS and not diagnosis.guess:
        return (
            "How often such verdicts are right is not known: too few hands with known causes were "
            "diagnosed."
        )
    return ""


def slip_sentences(slips: Sequence[Slip], display: Display, whole: bool = True) -> list[str]:
    """A sentence for each slip, with its mend. display: how outputs are shown. whole: whether the
    rest is explained.

    >>> slip = Slip("unit", "pressure", "kPa", "psi", 0.8, 0.01, "columns: {pressure: {unit: psi}}")
    >>> print(slip_sentences([slip], Display("deg"))[0].split(":")[0])
    The data fit if pressure is psi, not kPa as stated
    """
    fit = "fit" if whole else "fit better"
    claims = [_claim(slip, fit) for slip in slips]
    return [
        _left_out(slip, display)
        if slip.name == ODD_RUN and slip.rmse_after == slip.rmse_before
        else f"{claim}{_besides(slip)}: {_shown_by(slip, display)}. In experiment.yaml: "
        f"{slip.mend}{_or_else(slip)}{_not_exactly(slip)}"
        for claim, slip in zip(claims, slips, strict=True)
    ]


def _claim(slip: Slip, fit: str) -> str:
    """What a slip says of the data, which then `fit`."""
    if slip.name == OWN_MODULI:
        own = f"if each has its own modulus, {slip.fits}"
        return f"The specimens of a batch differ: the data {fit} {own}"
    if slip.name == SENSOR_LIMIT:
        return f"The sensor of the {slip.column} stands {slip.fits}, without which the data {fit}"
    may = "may " if slip.factor != 1.0 else ""
    other = _other_mix(slip)
    return f"The data {may}{fit} if {other}{slip.column} is {slip.fits}, not {slip.said} as stated"


def _left_out(slip: Slip, display: Display) -> str:
    """That a run of a hand does not fit with the others."""
    return (
        f"Run {slip.column} does not fit with the others and is left out: its error is "
        f"{display.shown(slip.rmse_before)}. Check it, or measure it again; if it comes out the "
        "same, the model lacks what shows in this run alone."
    )


def _other_mix(slip: Slip) -> str:
    """That rubber of another modulus explains the data as well as a slip."""
    if slip.modulus == 1.0:
        return ""
    return f"the rubber is {slip.modulus:.3g} times as stiff as stated (--free-modulus), or if "


def _shown_by(slip: Slip, display: Display) -> str:
    """What shows a slip: how far the error falls, or for a factor of pulses, their readings."""
    if slip.column == "mass" or isclose(slip.rmse_after, slip.rmse_before):
        return "as stated, the columns contradict each other"
    before, after = display.shown(slip.rmse_before), display.shown(slip.rmse_after)
    return f"the error falls from {before} to {after}"


def learned_sentences(learned: Learning) -> str:
    """What `learn` learned, after the slips that were taken out before."""
    said, data = words.verdict(learned), learned.problem.data
    if not learned.slips:
        return said
    most = RULES.explained_error * learned.problem.floor.total
    whole = learned.final.held_out.rmse <= most
    told = slip_sentences(learned.slips, data.output_display, whole)
    return "\n".join([*told, f"With that mended: {said}"])


def _or_else(slip: Slip) -> str:
    """Other slips that fit as well."""
    return f"\nThe data would fit as well if {listed(slip.alike, 'or')}." if slip.alike else ""


def _not_exactly(slip: Slip) -> str:
    """What else a factor may be that is not exactly that of a slip."""
    if slip.factor == 1.0:
        return ""
    return (
        f"\nAfter this correction the data are still {slip.factor:.3g} times what the "
        "model predicts. Other sizes, or an actuator of another make, may be the reason instead."
    )


def _besides(slip: Slip) -> str:
    return f", and the effect {slip.beside} is missing, too" if slip.beside else ""


def bound_sentence(
    at_bound: Sequence[str], calibration: Mapping[str, Any], without: str = ""
) -> str:
    """A sentence that says that the modulus lies on a bound, and which option frees it; "" if it
    does not. without: words for the effects that the fit lacks.

    >>> bound_sentence(["modulus_scale[A]"], {"modulus_scale": {"A": 0.85}})
    'The modulus of A is at its bound, 0.85 times the stated one: --free-modulus lifts it.'
    """
    scales = calibration.get("modulus_scale", {})
    names = [name.removeprefix("modulus_scale[").rstrip("]") for name in at_bound]
    shown = [
        f"{name} is at its bound{without}, {scales[name]:.3g} times"
        for name in names
        if name in scales
    ]
    if not shown:
        return ""
    return f"The modulus of {listed(shown)} the stated one: --free-modulus lifts it."


def _verdict(diagnosis: Diagnosis) -> str:
    if diagnosis.verdict_mended is not None:
        plain = replace(diagnosis, verdict=diagnosis.verdict_mended, verdict_mended=None)
        runs = {event["run"] for event in diagnosis.events}  # whose slips their events tell
        stated = [s for s in diagnosis.slips if not (s.name in OF_SERIES and s.column in runs)]
        told = slip_sentences(stated, diagnosis.display, plain.verdict != UNEXPLAINED)
        if diagnosis.instead:
            instead = listed(diagnosis.instead, "or")
            told.append(f"The data as described would also fit with {instead}.")
        told += event_sentences(diagnosis.events, diagnosis.slips, diagnosis.display)
        without = "taken out" if diagnosis.events else "mended"
        return "\n".join([*told, f"With that {without}: {_verdict(plain)}"])
    shown = diagnosis.display.shown
    before, after = shown(diagnosis.rmse_before), shown(diagnosis.rmse_after)
    floor = shown(diagnosis.noise_floor)
    if diagnosis.verdict == ADEQUATE:
        return (
            f"The model is adequate: its error of {before} can be noise alone "
            f"(noise floor {floor})."
        )
    if diagnosis.verdict == EFFECTS_MISSING:
        few = sum(len(effect.parameters) for effect in diagnosis.effects) <= SENTENCE_PARAMETERS
        named = listed(
            [
                class_words(effect, diagnosis)
                if effect.members
                else effect_words(effect)
                if few
                else effect.name
                for effect in diagnosis.effects
            ]
        )
        lacks = "may lack" if diagnosis.guess else "lacks"
        return (
            f"The model {lacks} {named}: with {'it' if len(diagnosis.effects) == 1 else 'them'} "
            f"the held-out error falls from {before} to {after}, at a noise floor of {floor}"
            f"{_left_over(diagnosis)}.{_or_a_size(diagnosis)}{_or_a_threshold(diagnosis)}"
            f"{_or_a_sensor(diagnosis)}{_weighs(diagnosis)}"
        )
    if diagnosis.rmse_before <= diagnosis.noise_floor:
        return (
            f"The model is not adequate, though its error of {before} lies within the noise floor "
            f"of {floor}: {_depends(diagnosis)}, beyond chance."
        )
    whole = " all of" if diagnosis.greater_part or diagnosis.helps else ""
    fails = (
        f"The model fails and no known effect explains{whole} it: its error is {before} at a noise "
        f"floor of {floor}"
    )
    helped = f". {_helps(diagnosis)}" if diagnosis.helps else _greater_part(diagnosis)
    more = f"{_freed(diagnosis)}{_second_time(diagnosis)}"
    return f"{fails}{helped}; {_depends(diagnosis)}{more}."


def _depends(diagnosis: Diagnosis) -> str:
    names = [axis_words(name, diagnosis.experiment) for name in diagnosis.unexplained.against]
    return (
        f"the remaining error varies with {listed(names)}"
        if names
        else "the remaining error varies with no input"
    )


def _freed(diagnosis: Diagnosis) -> str:
    """What to try if castings may differ by more than the calibration allows."""
    if diagnosis.modulus is not None or not varies_with_castings(diagnosis):
        return ""
    most = 100.0 * (USUAL_MODULUS_SCALES[1] - 1.0)
    return (
        f". If the moduli of the castings may differ by more than {most:.0f} %, --free-modulus "
        "tries one for each"
    )


def _second_time(diagnosis: Diagnosis) -> str:
    """That a second relaxation time is searched beside one that the model has."""
    part = diagnosis.greater_part
    helping = [one.name for one in diagnosis.helps] + ([part.effect.name] if part else [])
    first = next((name for name in helping if name in SecondRelaxation.beside), None)
    if first is None:
        return ""
    return f". Once {first} is added (`model-lab add`), a second relaxation time is searched, too"


def _helps(diagnosis: Diagnosis) -> str:
    """Effects that remove much of the error, but not all."""
    display = diagnosis.display
    errors = [diagnosis.rmse_before, *(one.rmse_after for one in diagnosis.helps)]
    falls = [
        f"{one.name} reduces {'the error' if place == 0 else 'the rest'} from "
        f"{display.number(before)} to {display.shown(one.rmse_after)}"
        for place, (one, before) in enumerate(zip(diagnosis.helps, errors, strict=False))
    ]
    one = len(falls) == 1
    if errors[-1] <= RULES.material_error * diagnosis.noise_floor:
        proven = "it is" if one else "they are"
        return f"{listed(falls)}, which explains the whole error, but {proven} not proven"
    return f"{listed(falls)}, but {'does' if one else 'they do'} not explain all of it"


def _greater_part(diagnosis: Diagnosis) -> str:
    """The effect that explains the greater part of the error above the floor, as a possibility."""
    part = diagnosis.greater_part
    if part is None:
        return ""
    one = part.effect
    named = f"{_of_cause(one, diagnosis)})" if one.members else effect_words(one)
    share, after = 100.0 * part.share, diagnosis.display.shown(part.rmse_after)
    return (
        f". Most of it ({share:.0f} % of the mean square above the floor) may be "
        f"{listed([named, *part.alike], 'or')}, which leaves {after}"
    )


def story_sentence(diagnosis: Diagnosis) -> str:
    """A sentence on how the error falls with each effect, in the order in which they were found; ""
    for a single effect.

    >>> from types import SimpleNamespace as Made
    >>> steps = Made(name="tube_lag", rmse_after=0.02), Made(name="gravity", rmse_after=0.01)
    >>> story_sentence(Made(story=steps, display=Display("N"), rmse_before=0.05))
    'The error falls from 0.05 N to 0.02 N with tube_lag, to 0.01 N with gravity too.'
    """
    if len(diagnosis.story) < 2:
        return ""
    shown = diagnosis.display.shown
    falls = [
        f"{shown(step.rmse_after)} with {step.name}{' too' if place else ''}"
        for place, step in enumerate(diagnosis.story)
    ]
    return f"The error falls from {shown(diagnosis.rmse_before)} to {', to '.join(falls)}."


def _left_over(diagnosis: Diagnosis) -> str:
    """What the named effects leave, where that is more than the floor itself."""
    over = diagnosis.rmse_after / diagnosis.noise_floor
    if over <= RULES.explained_error:
        return ""
    rest = diagnosis.display.shown(diagnosis.unexplained.rms)
    names = [axis_words(name, diagnosis.experiment) for name in diagnosis.unexplained.against]
    varies = f", which varies with {listed(names)}" if names else ""
    return f"; {rest} remains{varies}: add what is named and diagnose again for the rest"


def _or_a_size(diagnosis: Diagnosis) -> str:
    """That a wrong size of the finger looks like a wrong scale of its angle (eq. 3.12), or of the
    pressure behind its blocked tip, whose force is in proportion to h**2*p/L.
    """
    blocked = diagnosis.experiment == "blocked_tip"
    name = "pressure_gain" if blocked else "angle_gain"
    gains = [one for one in diagnosis.effects if one.name == name]
    if not gains:
        return ""
    gain = gains[0].parameters["gain"].value
    longer, higher = (1.0 / gain, gain**0.5) if blocked else (gain, 1.0 / gain)
    gauge = f", and so does a force gauge that reads {gain:.3g} times the force" if blocked else ""
    return (
        f" A finger {longer:.3g} times as long looks the same, and one {higher:.3g} times as "
        f"high nearly so{gauge}."
    )


def _or_a_threshold(diagnosis: Diagnosis) -> str:
    """That a threshold of the output's sensor looks like one of the pressure."""
    sensors = {"blocked_tip": ("A force gauge", "force"), "free_bending": ("A sensor", "angle")}
    zones = [one for one in diagnosis.effects if one.name == "dead_zone"]
    if diagnosis.experiment not in sensors or not zones:
        return ""
    sensor, shown = sensors[diagnosis.experiment]
    entry = zones[0].parameters["threshold"]
    reached = display_among(diagnosis.units, entry.unit).shown(entry.value)
    return f" {sensor} that shows nothing below the {shown} at {reached} looks the same."


def _weighs(diagnosis: Diagnosis) -> str:
    """What a hand weighs whose weight, which all models of hands have, is not the stated one."""
    of_hand = diagnosis.experiment in OF_HANDS
    weights = [one for one in diagnosis.effects if of_hand and one.name == HAND_WEIGHT]
    if not weights:
        return ""
    scale = weights[0].parameters["mass_scale"].value
    return f" Its actuators weigh {scale:.3g} times their nominal mass."


def _or_a_sensor(diagnosis: Diagnosis) -> str:
    """That a wrong pressure of a channel looks like a wrong modulus of all that it feeds."""
    if diagnosis.channel is None:
        return ""
    what = "these are" if len(diagnosis.effects) > 1 else "this is"
    return (
        f" As {what} all that channel {diagnosis.channel} feeds, its pressure may be wrong instead."
    )


def preconditioning_sentence(data: MeasurementSet) -> str:
    """A sentence on how far runs were stretched before, as the set states it; "" if it states
    nothing.
    """
    told = {run.name: run.stretched_to for run in data.runs if run.stretched_to > 1.0}
    if not told:
        return ""
    if len(told) == len(data.runs) and len(set(told.values())) == 1:
        return f"All runs were stretched to {next(iter(told.values())):g} before."
    parts = [f"{name} to {stretch:g}" for name, stretch in told.items()]
    return f"Stretched before the run: {listed(parts)}."


def notice_sentence(clauses: Sequence[str]) -> str:
    """A sentence on the anomalies of a set, from the clauses of its notices; "" without any."""
    return f"Note: {'; '.join(clauses)}." if clauses else ""


def tie_sentences(diagnosis: Diagnosis) -> list[str]:
    """A sentence for each named effect that the data cannot tell from effects of another class of
    causes; those of its own class are in the verdict.
    """
    return [
        f"These data cannot tell {f'the {effect.cause}' if effect.members else effect.name} from "
        f"{listed(others, 'or')}."
        for effect, names in zip(diagnosis.effects, diagnosis.tied, strict=True)
        if (others := [name for name in names if name not in effect.members])
    ]


def class_words(effect: NamedEffect, diagnosis: Diagnosis) -> str:
    """A class of causes in words: the members, the size of the one that fits best, and what tells
    them apart.
    """
    planned = diagnosis.next_experiment
    can = planned is not None and planned["breaks"]
    apart = "; `model-lab plan` can" if can else ", nor can a run within what the set has seen"
    return f"{_of_cause(effect, diagnosis)}: these data cannot tell{apart})"


def _of_cause(effect: NamedEffect, diagnosis: Diagnosis) -> str:
    """A class of causes with its size, and its members in a bracket that stays open."""
    article = "an" if effect.cause[0] in "aeiou" else "a"
    members = listed(list(effect.members.values()), "or")
    return f"{article} {effect.cause}{_size_words(effect, diagnosis)} ({members}"


def _size_words(effect: NamedEffect, diagnosis: Diagnosis) -> str:
    """Size of an effect by its first parameter; by name if that has no unit."""
    if not effect.parameters:
        return ""
    name, entry = next(iter(effect.parameters.items()))
    if not entry.unit:
        return f" with {name} = {entry.value:.3g} ± {entry.std:.2g}"
    display = display_among(diagnosis.units, entry.unit)
    return f" of {display.number(entry.value)} ± {display.shown(entry.std, 2)}"


def effect_words(effect: NamedEffect) -> str:
    """An effect with its parameters and their standard errors, in words."""
    values = [
        f"{name} = {entry.value:.3g} ± {entry.std:.2g} {entry.unit}".rstrip()
        for name, entry in effect.parameters.items()
    ]
    return f"{effect.name} ({', '.join(values)})" if values else effect.name


def axis_words(name: str, experiment: str = "") -> str:
    """Name, in words, of an axis or of the input of a black box in an experiment.

    >>> axis_words("pressure", "uniaxial")
    'the stretch'
    """
    return AXIS_WORDS.get(name, f"the {driving_name(name, experiment)}")


def driving_name(name: str, experiment: str) -> str:
    """The name of an axis; for the input of an experiment, the name of its quantity.

    >>> driving_name("pressure", "rubber"), driving_name("largest_pressure", "rubber")
    ('stretch', 'largest_stretch')
    """
    quantity = DRIVING_QUANTITY.get(experiment, ("pressure",))[0]
    of_pressure = name in ("pressure", "largest_pressure", "pressure_rate")
    return name.replace("pressure", quantity) if of_pressure else name


def listed(words: Sequence[str], last: str = "and") -> str:
    """Words joined by commas, and by `last` before the last one.

    >>> listed(["a", "b", "c"])
    'a, b and c'
    """
    return f" {last} ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def counted(number: int, noun: str) -> str:
    """A number with its noun, in the plural if needed.

    >>> counted(4698, "sample"), counted(1, "run")
    ('4 698 samples', '1 run')
    """
    return f"{number:,} {noun}{'' if number == 1 else 's'}".replace(",", " ")
