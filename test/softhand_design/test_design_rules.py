"""Rules of thumb invert the theory."""

import pytest

from softhand_design import design_rules as design
from softhand_model.hand import section


def test_circumference_gives_the_stiffness_back():
    around = design.circumference_for_stiffness(3e-3, 0.002, 67e3)
    assert section.rule_stiffness(around / 4, 0.002, 67e3) == pytest.approx(3e-3)


@pytest.mark.parametrize(("wall", "thin"), [(0.0099, True), (0.01, False), (0.012, False)])
def test_wall_must_stay_below_half_the_height(wall, thin):
    assert design.wall_is_thin(0.02, wall) is thin


def test_square_sections_keep_their_shape():
    assert design.keeps_its_shape(0.020, 0.0205)
    assert not design.keeps_its_shape(0.020, 0.030)


def test_dragon_skin_may_be_stretched_to_five():
    assert design.useful_stretch(11.0) == pytest.approx((3.3, 5.5))
