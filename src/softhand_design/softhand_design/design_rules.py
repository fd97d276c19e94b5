"""Rules of thumb for dimensioning an actuator (section 3.6.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from softhand_model.hand.rubber import USEFUL_STRETCH, Rubber, load_rubbers

LARGEST_WALL = 0.5  # of the height (eq. 3.6)
RULE_TOLERANCE = 0.1  # within which "about" holds; the thesis gives no number
MODEL_STRETCH = 3.0  # up to which section 3.4.6 compares models of rubber
MESSAGE_DIGITS = 4  # of a bound in a message
DIGIT_TOLERANCE = 1e-6  # of a bound's last digit, by which it may be off
LEAST_INDEX_SHARE = 0.75  # of the best index in Table 3.2; the thesis compares and gives no bound

RULE_TEXTS: dict[int | str, str] = {
    1: "wall d = dp/dkappa/(8 G) for the actuation ratio (eq. 3.32)",
    2: "circumference c = 4 (dM/dkappa/(2 G d))^(1/3) for the stiffness (eq. 3.26)",
    3: "height about equal to width, or pressure changes the shape (section 3.4.3)",
    4: "wall below half the height, or the rubber tires (section 3.4.5)",
    5: "rubber of a high suitability index S = (lambda_max - 1) G^(1/4) (eq. 3.10)",
    "in use": "stretch of 0.3 of the largest one, to spare the rubber (section 3.3.3)",
    "of the model": "stretch below 3, up to which rubber is neo-Hookean (section 3.4.6)",
}


@dataclass(frozen=True)
class BrokenRule:
    """A rule of section 3.6.1, or another limit, that an actuator breaks.

    rule: number of the rule, or name of the limit. quantity: name of what is limited. value, low,
    high: the actuator's value and the bounds it should keep, in `unit`; None where there is no
    bound. place [m]: where along the actuator the rule is broken most; None if it has no place.
    """

    rule: int | str
    quantity: str
    value: float
    low: float | None
    high: float | None
    unit: str
    place: float | None = None

    def __str__(self) -> str:
        bounds = [
            f"{word} {bound:.4g}"
            for word, bound in (("at least", self.low), ("at most", self.high))
            if bound is not None
        ]
        unit = "" if self.unit == "-" else f" {self.unit}"
        kind = "rule" if isinstance(self.rule, int) else "limit"
        place = "" if self.place is None else f" at {1e3 * self.place:.4g} mm"
        return (
            f"{kind} {self.rule}: {RULE_TEXTS[self.rule]}: {self.quantity} expected "
            f"{' and '.join(bounds)}{unit}, got {self.value:.4g}{unit}{place}"
        )


def allowed(bound: float, words: str) -> float:
    """A bound rounded to four digits so that a value at the rounded bound is allowed: up if `words`
    begin with "above" or "at least", down if they begin with "below" or "at most", else to the
    nearest.

    >>> allowed(1.94157, "at most {}"), allowed(0.28571, "above {}")
    (1.941, 0.2858)
    """
    if not math.isfinite(bound) or bound == 0.0:
        return bound
    scale = 10.0 ** (MESSAGE_DIGITS - 1 - math.floor(math.log10(abs(bound))))
    scaled = bound * scale
    if words.startswith(("above", "at least")):
        return math.ceil(scaled - DIGIT_TOLERANCE) / scale
    if words.startswith(("below", "at most")):
        return math.floor(scaled + DIGIT_TOLERANCE) / scale
    return round(scaled) / scale


def circumference_for_stiffness(stiffness: float, wall: float, shear_modulus: float) -> float:
    """Circumference c [m] that gives the bending stiffness [N m2]: rule 2 (eq. 3.26).

    >>> round(circumference_for_stiffness(2 * 0.02**3 * 67e3 * 0.002, 0.002, 67e3), 6)
    0.08
    """
    return float(4.0 * (stiffness / (2.0 * shear_modulus * wall)) ** (1.0 / 3.0))


def keeps_its_shape(height: float, width: float) -> bool:
    """Whether the section is square enough not to change shape under pressure: rule 3, h ~ z."""
    return abs(height - width) <= RULE_TOLERANCE * max(height, width)


def wall_is_thin(height: float, wall: float) -> bool:
    """Whether the wall is thin against the height: rule 4, d < 0.5*h."""
    return wall < LARGEST_WALL * height


def useful_stretch(max_stretch: float) -> tuple[float, float]:
    """Stretch [-] up to which a rubber should be used, cautious and at most (section 3.3.3)."""
    return USEFUL_STRETCH[0] * max_stretch, USEFUL_STRETCH[1] * max_stretch


def check_actuation_ratio(reached: float, wanted: float) -> BrokenRule | None:
    """Rule 1, if it is broken: the actuation ratio [1/(m Pa)] should be about the wanted one."""
    return _about(1, "actuation ratio", reached, wanted, "1/(m Pa)")


def check_stiffness(reached: float, wanted: float) -> BrokenRule | None:
    """Rule 2, if it is broken: the stiffness [N m2] should be about the wanted one."""
    return _about(2, "stiffness", reached, wanted, "N m2")


def check_shape(height: float, width: float) -> BrokenRule | None:
    """Rule 3, if it is broken: height and width [m] should be about the same."""
    if keeps_its_shape(height, width):
        return None
    low, high = 1.0 - RULE_TOLERANCE, 1.0 / (1.0 - RULE_TOLERANCE)
    return BrokenRule(3, "height over width", height / width, low, high, "-")


def check_wall(height: float, wall: float) -> BrokenRule | None:
    """Rule 4, if it is broken: the wall [m] should be below half the height [m]."""
    if wall_is_thin(height, wall):
        return None
    return BrokenRule(4, "wall over height", wall / height, None, LARGEST_WALL, "-")


def check_rubber(rubber: Rubber) -> BrokenRule | None:
    """Rule 5, if it is broken: the suitability index should not be far below the best of Table 3.2.

    >>> check_rubber(load_rubbers()["Dragon Skin 20"]) is None
    True
    """
    best = max(other.suitability for other in load_rubbers().values())
    if rubber.suitability >= LEAST_INDEX_SHARE * best:
        return None
    quantity = f"index of {rubber.name}"
    return BrokenRule(5, quantity, rubber.suitability, LEAST_INDEX_SHARE * best, None, "kPa^0.25")


def check_use(stretch: float, most: float) -> BrokenRule | None:
    """The rule of section 3.3.3, if it is broken: the largest `stretch` [-] in use should be at
    most `most` [-], 0.3 of the rubber's largest. None if `most` is no stretch at all.
    """
    if stretch <= most or most <= 1.0:
        return None
    return BrokenRule("in use", "stretch", stretch, None, most, "-")


def check_model(stretch: float) -> BrokenRule | None:
    """The limit of the rubber's model, if it is broken: the largest stretch [-] in use should be
    one for which the model was chosen.
    """
    if stretch <= MODEL_STRETCH:
        return None
    return BrokenRule("of the model", "stretch", stretch, None, MODEL_STRETCH, "-")


def _about(rule: int, quantity: str, value: float, wanted: float, unit: str) -> BrokenRule | None:
    low, high = (1.0 - RULE_TOLERANCE) * wanted, (1.0 + RULE_TOLERANCE) * wanted
    return None if low <= value <= high else BrokenRule(rule, quantity, value, low, high, unit)
