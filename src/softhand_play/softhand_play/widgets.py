"""Checks values of widgets on the server, as any value may come from a browser."""

from __future__ import annotations

import math
from typing import Any

import viser

from softhand_common.documents.quoted import listed, quoted

NOTHING = ("none found",)  # options of a dropdown without any
LONGEST_TEXT = 1000  # characters of a text field
SLIDER_TOLERANCE = 1e-6  # by which a value may be out of a slider's range, as a share of it


def offer(dropdown: viser.GuiDropdownHandle, values: tuple[str, ...]) -> None:
    """Replace the options of a dropdown; the chosen one stays if it is still there."""
    if tuple(dropdown.options) != (values or NOTHING):
        dropdown.options = values or NOTHING


def refusal(widget: Any, value: Any) -> str:
    """Why a value is refused, with the label of the widget; "" for an allowed value."""
    expected = _expected(widget, value)
    return f"{widget.label}: expected {expected}, got {quoted(value)}" if expected else ""


def _expected(widget: Any, value: Any) -> str:
    """What is expected in place of a value; "" for an allowed value."""
    if isinstance(widget, viser.GuiUploadButtonHandle):
        return "a file"
    if isinstance(widget, viser.GuiButtonHandle | viser.GuiCheckboxHandle):
        return "" if isinstance(value, bool) else "true or false"
    if isinstance(widget, viser.GuiDropdownHandle):
        known = isinstance(value, str) and value in widget.options
        return "" if known else f"one of {listed(widget.options)}"
    if isinstance(widget, viser.GuiTextHandle):
        short = isinstance(value, str) and len(value) <= LONGEST_TEXT and "\0" not in value
        return "" if short else f"a text of at most {LONGEST_TEXT} characters"
    if isinstance(widget, viser.GuiSliderHandle):
        return _expected_number(widget, value)
    return "no value"


def _expected_number(slider: viser.GuiSliderHandle[Any], value: Any) -> str:
    low, high, whole = slider.min, slider.max, isinstance(slider.value, int)
    number = isinstance(value, int | float) and not isinstance(value, bool)
    room = SLIDER_TOLERANCE * (high - low)
    if number and low - room <= value <= high + room and not (whole and value != math.floor(value)):
        return ""
    return f"{'a whole number' if whole else 'a number'} from {low:g} to {high:g}"
