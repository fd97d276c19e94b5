"""Places on the skin: found again from their points, on every side, bent or straight."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand.kinematics import HandShape
from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.hand.skin_places import BACK, LEFT, PAD, RIGHT, SkinPlaces
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model


@pytest.fixture(scope="module")
def shape():
    return HandShape(build_layout(load_hand("rbo_hand_2"), 8, load_model(None)))


def bent(shape, angle):
    """Joint orientations with this bend [rad] in each joint of the fingers and the thumb."""
    q = np.tile([0.0, 0.0, 0.0, 1.0], (len(shape.layout.mass), 1))
    q[:] = shape.layout.rest
    for name in ("index", "little"):
        q[shape.layout.chain_joints[name]] = Rotation.from_rotvec([0, angle, 0]).as_quat()
    return q


@pytest.mark.parametrize("angle", [0.0, 0.15])
@pytest.mark.parametrize("side", (PAD, BACK, LEFT, RIGHT))
@pytest.mark.parametrize("share", [0.1, 0.45, 0.75])
def test_the_point_of_a_place_is_found_there(shape, angle, side, share):
    places, q = SkinPlaces(shape), bent(shape, angle)
    for chain in ("index", "little", "thumb"):
        found = places.locate(chain, places.point(chain, share, side, q), q)
        assert found.side == side
        assert found.distance(share, side) < 1.5e-3
        assert found.along == pytest.approx(share * places.length(chain), abs=1.5e-3)


def test_flanks_are_on_their_sides_of_the_hand(shape):
    places, q = SkinPlaces(shape), bent(shape, 0.0)
    left, right = (places.point("index", 0.5, side, q) for side in ("+y", "-y"))
    pad, back = (places.point("index", 0.5, side, q) for side in ("pad", "back"))
    assert left[1] > right[1] + 0.015  # +y: towards the thumb
    assert pad[0] > back[0] + 0.01  # x: palmar
    assert places.point("index", 0.9, "pad", q)[2] > pad[2] + 0.02


def test_distance_runs_around_the_section_not_through_it(shape):
    places, q = SkinPlaces(shape), bent(shape, 0.0)
    pad = places.locate("index", places.point("index", 0.5, "pad", q), q)
    through = np.ptp([places.point("index", 0.5, s, q)[0] for s in ("pad", "back")])
    assert pad.distance(0.5, "back") == pytest.approx(0.5 * pad.girth, rel=1e-3)
    assert pad.distance(0.5, "back") > 1.3 * through
    assert pad.distance(0.5, "+y") == pytest.approx(pad.flank, rel=1e-3)
    assert pad.distance(0.6, "pad") == pytest.approx(0.1 * pad.length, rel=1e-3)


def test_the_tip_is_as_near_over_the_back_as_over_the_pad(shape):
    places, q = SkinPlaces(shape), bent(shape, 0.1)
    for side in ("pad", "back"):
        place = places.locate("index", places.point("index", 0.97, side, q), q)
        assert place.distance(1.0, "tip") == pytest.approx(0.03 * place.length, abs=1e-3)


def test_the_skin_of_the_last_part_lies_there(shape):
    places, q = SkinPlaces(shape), bent(shape, 0.1)
    length = places.length("thumb")
    cloud = places.points("thumb", np.array([length - 0.02, length]), q)
    found = [places.locate("thumb", point, q).along for point in cloud]
    assert min(found) > length - 0.0215 and max(found) == pytest.approx(length, abs=1e-3)
