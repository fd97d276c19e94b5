"""Cases outside of the catalogue that are drawn with new seeds only, never while developing."""

from __future__ import annotations

from collections.abc import Iterator

from bench.hidden.case import DRIVEN, LOW_NOISES, UNEXPLAINED, Case, hidden

RESERVED = "eccentric_encoder stick_slip day_cycle wobbling_clock touched chatter"
RATIOS = {"free_bending": (3.0, 5.0), "blocked_tip": (5.0,), "uniaxial": (5.0,)}


def reserved() -> Iterator[Case]:
    """Six families that no threshold and no effect was tried on."""
    for experiment in DRIVEN:
        for law in RESERVED.split():
            for ratio in RATIOS[experiment]:
                name = f"reserved/{experiment}/{law}/{ratio:g}"
                laws = hidden(law)
                yield Case(name, "outside", experiment, laws, UNEXPLAINED, ratio, noises=LOW_NOISES)


def is_reserved(name: str) -> bool:
    """Whether a case, by name, is one of these: what is said of it is counted, never listed."""
    return name.startswith("reserved/")
