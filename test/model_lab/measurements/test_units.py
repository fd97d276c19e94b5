"""Units that are known without pint's list are those of that list."""

from __future__ import annotations

import pytest

from model_lab.measurements.units import COLUMN_UNITS, USUAL_UNITS, column_unit


@pytest.mark.parametrize("text", USUAL_UNITS)
def test_a_usual_unit_is_that_of_the_list(text, monkeypatch):
    usual = USUAL_UNITS[text]
    column = next(name for name, unit in COLUMN_UNITS.items() if unit == usual.si)
    monkeypatch.setattr("model_lab.measurements.units.USUAL_UNITS", {})
    column_unit.cache_clear()
    assert column_unit(column, text) == usual
    column_unit.cache_clear()


def test_a_usual_unit_of_another_quantity_is_refused():
    with pytest.raises(ValueError, match="same quantity"):
        column_unit("pressure", "deg")


@pytest.mark.parametrize("unit", ["counts", "percent", "ppm"])
def test_what_is_counted_is_no_angle(unit):
    with pytest.raises(ValueError, match="same quantity as rad"):
        column_unit("tip_angle", unit)
    assert column_unit("tip_angle", "1").scale == 1.0


def test_a_unit_that_may_be_degrees_or_gons_is_asked():
    for text in ("grad", "Grad"):
        with pytest.raises(ValueError, match="expected deg, or gon"):
            column_unit("tip_angle", text)
    assert column_unit("tip_angle", "gon").scale == pytest.approx(3.141592653589793 / 200.0)
