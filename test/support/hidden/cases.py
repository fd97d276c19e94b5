"""All cases of the benchmark."""

from __future__ import annotations

from functools import lru_cache

from hidden import cases_catalogue, cases_flow, cases_other, cases_tied, cases_torque
from hidden.case import Case


@lru_cache(maxsize=1)
def all_cases() -> tuple[Case, ...]:
    """Every case, by row."""
    return (
        *cases_catalogue.catalogue(),
        *cases_other.other_forms(),
        *cases_other.pairs(),
        *cases_catalogue.nothing(),
        *cases_other.outside(),
        *cases_other.one_rate(),
        *cases_flow.pulses(),
        *cases_tied.tied(),
        *cases_torque.torques(),
    )
