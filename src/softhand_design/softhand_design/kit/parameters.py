"""Parameters of a hand's parts. The thesis states how a hand is put together (3.2.2, 3.6.2, 7.3),
not these sizes, unless their text names a section: the others are ours.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any


def _size(default: float, low: float, high: float, text: str) -> Any:
    return field(default=default, metadata={"low": low, "high": high, "text": text})


@dataclass(frozen=True)
class KitParameters:
    """Sizes [mm]; raises ValueError for a size out of its bounds.

    >>> KitParameters(layer=0.0)
    Traceback (most recent call last):
    ValueError: layer: expected 0.5 to 5 mm, got 0
    """

    layer: float = _size(1.5, 0.5, 5.0, "passive layer; 1 to 2 by section 3.2.2")
    gap: float = _size(1.0, 0.2, 5.0, "least space between the scaffold and rubber it holds not")
    pad: float = _size(2.0, 1.0, 10.0, "thickness of the pads that actuators are bonded to")
    arm: float = _size(4.0, 1.0, 20.0, "thickness of an arm to a base that has no strut")
    arm_width: float = _size(20.0, 4.0, 100.0, "its width, unless its pad is narrower")
    glue: float = _size(0.2, 0.05, 1.0, "space for adhesive around the end that a saddle holds")
    margin: float = _size(2.0, 0.5, 10.0, "of a tray around what is cast in it, trimmed off later")
    tray: float = _size(2.5, 1.0, 10.0, "thickness of a tray's floor and walls")
    tube_bore: float = _size(2.0, 0.2, 10.0, "inner diameter of the tubes; 2 by section 3.6.3")

    def __post_init__(self) -> None:
        for entry in fields(self):
            value, bounds = getattr(self, entry.name), entry.metadata
            if not bounds["low"] <= value <= bounds["high"]:
                raise ValueError(
                    f"{entry.name}: expected {bounds['low']:g} to {bounds['high']:g} mm, got "
                    f"{value:g}"
                )
