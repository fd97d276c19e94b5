"""A slip: a mistake in how data are stated, without which they fit."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Slip:
    """A slip that was found.

    name: its kind, such as `unit`, `absolute`, `sign` or `odd_run`. column: what it is about: a
    column, a key of the specimens, or a run. said, fits: what the set states, and what fits, such
    as `kPa` and `psi`. rmse_before, rmse_after: held-out error of the model, its calibration
    refitted, on the data as stated and mended; each in the SI unit of the outputs as they are then.
    mend: text to paste into experiment.yaml, which takes the place of what stands there. beside: an
    effect that acts besides, with which rmse_after is; empty if none is needed. alike: other slips
    without which the data fit about as well, such as `pressure is inHg, not kPa`.
    """

    name: str
    column: str
    said: str
    fits: str
    rmse_before: float
    rmse_after: float
    mend: str
    beside: str = ""
    alike: tuple[str, ...] = ()
