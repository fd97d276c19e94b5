"""Cases of valve pulses."""

from __future__ import annotations

from itertools import product

from hidden.case import NOISES, Case, Expected
from hidden.cases_catalogue import RATIOS, named

FINEST = (0.002,)  # the choke's bend does not show above
CATALOGUE = ("line_friction", "switching_volume", "pulse_bias", "valve_delay", "leakage")
FORMS: dict[str, tuple[str, ...]] = {
    "compressible_line": ("line_friction",),
    "orifice_leak": ("leakage",),
    "pressed_valve": ("valve_delay", "switching_volume"),
    "warm_dead_volume": ("switching_volume",),
}
PAIRS = (("injector_flow", "switching_volume"), ("injector_flow", "pulse_bias"))
OUTSIDE = ("sticky_valve", "saturated_meter", "stepping_gain", "wearing_choke")


def pulses() -> list[Case]:
    """All cases of valve pulses."""
    return [*_catalogue(), *_forms(), *_pairs(), *_nothing(), *_outside()]


def _case(
    name: str,
    row: str,
    laws: tuple[str, ...],
    expected: Expected,
    ratio: float | None,
    noises: tuple[float, ...] = NOISES,
    **options: object,
) -> Case:
    hidden = tuple((law, {}) for law in laws)
    return Case(name, row, "valve_pulse", hidden, expected, ratio, options, noises)


def _catalogue() -> list[Case]:
    choke = ("injector_flow",)
    made = [
        _case(f"valve_pulse/{law}/{word}", "catalogue", (law,), named(law), ratio)
        for law, (word, ratio) in product(CATALOGUE, RATIOS.items())
    ]
    made.append(_case("valve_pulse/injector_flow", "catalogue", choke, named(*choke), 2.0, FINEST))
    return made


def _forms() -> list[Case]:
    made = [
        _case(f"form/valve_pulse/{law}/{word}", "other form", (law,), named(*family), ratio)
        for (law, family), (word, ratio) in product(
            FORMS.items(), {"medium": 4.0, "strong": 8.0}.items()
        )
    ]
    choke = named("injector_flow")
    made.append(
        _case("form/valve_pulse/iso_choke", "other form", ("iso_choke",), choke, 2.0, FINEST)
    )
    return made


def _pairs() -> list[Case]:
    return [
        _case(
            f"pair/valve_pulse/{first}+{second}",
            "pairs",
            (first, second),
            Expected("effects_missing", (frozenset({first}), frozenset({second}))),
            3.0,
            FINEST,
        )
        for first, second in PAIRS
    ]


def _nothing() -> list[Case]:
    ways = {"repeats": {}, "no_repeats": {"repeats": 1, "runs": 6}}
    return [
        _case(f"nothing/valve_pulse/{word}", "nothing", (), Expected("adequate"), None, **way)
        for word, way in ways.items()
    ]


def _outside() -> list[Case]:
    return [
        _case(
            f"outside/valve_pulse/{law}/5",
            "outside",
            (law,),
            Expected("unexplained"),
            5.0,
            NOISES[:2],
            adjacent=law == "wearing_choke",
        )
        for law in OUTSIDE
    ]
