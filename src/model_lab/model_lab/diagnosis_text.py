"""A diagnosis as text that a person reads."""

from __future__ import annotations

from model_lab.diagnosis import Diagnosis
from model_lab.display import display_of
from model_lab.planned_run import proposal_text
from model_lab.report.sentence import tie_sentences, verdict_sentence
from model_lab.text_table import text_table

MOST_RANKED = 8


def diagnosis_text(diagnosis: Diagnosis) -> str:
    """What `diagnose` prints."""
    sections = [
        "\n".join([verdict_sentence(diagnosis), *tie_sentences(diagnosis)]),
        _effects(diagnosis),
        _failures(diagnosis),
        _ranking(diagnosis),
        _not_visible(diagnosis),
        _next_experiment(diagnosis),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def _effects(diagnosis: Diagnosis) -> str:
    rows = [
        [
            effect.name,
            name,
            f"{e.value:.4g}",
            f"{e.std:.2g}",
            *(f"{end:.4g}" for end in e.interval),
            e.unit,
        ]
        for effect in diagnosis.effects
        for name, e in effect.parameters.items()
    ]
    head = ["effect", "parameter", "value", "std", "95 % from", "to", "unit"]
    return text_table([head, *rows]) if rows else ""


def _failures(diagnosis: Diagnosis) -> str:
    rows = [
        [f"{100.0 * f.share_of_error:.0f} %", f"{f.p_value:.2g}", f.against, f.where]
        for f in diagnosis.failures
    ]
    head = ["share of error", "p", "against", "where"]
    return f"Where it fails\n{text_table([head, *rows])}" if rows else ""


def _ranking(diagnosis: Diagnosis) -> str:
    display = display_of(diagnosis.unit)
    rows = [
        [
            entry.name,
            display.number(entry.rmse_heldout),
            f"{entry.delta_bic:.0f}",
            f"{entry.p_value:.2g}",
            "" if entry.plausible else "parameters at a limit, or not known",
        ]
        for entry in diagnosis.ranking[:MOST_RANKED]
    ]
    head = ["effect alone", f"held out [{display.unit}]", "delta BIC", "p", ""]
    return text_table([head, *rows]) if rows else ""


def _not_visible(diagnosis: Diagnosis) -> str:
    rows = [[entry.name, entry.reason] for entry in diagnosis.not_visible]
    return text_table([["not visible", "because"], *rows]) if rows else ""


def _next_experiment(diagnosis: Diagnosis) -> str:
    planned = diagnosis.next_experiment
    return "" if planned is None else proposal_text(planned)
