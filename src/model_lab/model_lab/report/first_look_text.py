"""The first look at a set in one line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from model_lab.measurements.units import Display

if TYPE_CHECKING:
    from model_lab.diagnosis.first_look import FirstLook

FIRST_LOOK = "first look: "  # with which the line begins


def first_look_line(found: FirstLook, display: Display) -> str:
    """A line on what is known before the search. display: how outputs are shown.

    >>> from model_lab.diagnosis.first_look import FirstLook
    >>> found = FirstLook(0.05, 0.01, "rad", False, (), (("tube_lag", 0.8),))
    >>> print(first_look_line(found, Display("rad")))
    first look: error 0.05 rad, noise floor 0.01 rad; likeliest so far: tube_lag (80 % of the error)
    """
    parts = [f"error {display.shown(found.rmse)}, noise floor {display.shown(found.noise_floor)}"]
    parts += [
        f"{slip.column} looks like {slip.fits}, not {slip.said}, and is treated so"
        for slip in found.slips
    ]
    names = ", ".join(
        f"{name} ({100 * share:.0f} % of the error)" for name, share in found.likeliest
    )
    if names and not found.is_noise:
        parts.append(f"likeliest so far: {names}")
    else:
        parts.append("nothing stands out so far")
    return FIRST_LOOK + "; ".join(parts)
