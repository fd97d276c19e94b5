"""What a diagnosis says: the JSON of the contract as data classes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

FORMAT = "softhand-diagnosis/1"
ADEQUATE, EFFECTS_MISSING, UNEXPLAINED = "adequate", "effects_missing", "unexplained"


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter: value, standard error and 95 % interval in its unit."""

    value: float
    std: float
    interval: tuple[float, float]
    unit: str


@dataclass(frozen=True)
class NamedEffect:
    """A missing effect with its fitted parameters by name."""

    name: str
    parameters: Mapping[str, Estimate]


@dataclass(frozen=True)
class Ranked:
    """One effect alone: held-out error with it, BIC against the model without, and its p-value.

    plausible: its parameters lie off their bounds.
    """

    name: str
    rmse_heldout: float
    delta_bic: float
    plausible: bool
    p_value: float


@dataclass(frozen=True)
class NotVisible:
    """An effect about which these data say nothing."""

    name: str
    reason: str


@dataclass(frozen=True)
class Detectable:
    """The smallest value of an effect's parameter that would have shown."""

    name: str
    parameter: str
    smallest: float


@dataclass(frozen=True)
class Failure:
    """Where the model without the missing effects fails."""

    against: str
    where: str
    p_value: float
    share_of_error: float


@dataclass(frozen=True)
class Unexplained:
    """What the final model leaves above the noise floor, and on what it depends."""

    rms: float
    against: tuple[str, ...]


@dataclass(frozen=True)
class Diagnosis:
    """The verdict on a model and a measurement set, in SI units."""

    experiment: str
    verdict: str
    holdout: str
    effects: tuple[NamedEffect, ...]
    tied: tuple[tuple[str, ...], ...]
    ranking: tuple[Ranked, ...]
    not_visible: tuple[NotVisible, ...]
    detectable: tuple[Detectable, ...]
    calibration: Mapping[str, Any]
    noise_floor: float
    noise_floor_parts: Mapping[str, float]
    noise_floor_source: str
    rmse_before: float
    rmse_after: float
    unit: str
    failures: tuple[Failure, ...]
    unexplained: Unexplained
    next_experiment: Mapping[str, Any] | None = None
    correlation: Mapping[str, Mapping[str, float]] | None = None

    def as_json(self) -> dict[str, Any]:
        """The dictionary that `--json` writes."""
        return {"format": FORMAT, **asdict(self)}
