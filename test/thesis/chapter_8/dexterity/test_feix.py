"""The table of grasp types is whole and agrees with itself."""

from collections import Counter

import pytest

from thesis.chapter_8.dexterity.feix import COUNT, CUTKOSKY, PALM, THUMB, grasp_types

TYPES = grasp_types()
POWER_PALM = {1, 2, 3, 4, 5, 10, 11, 15, 17, 30}


def numbers(**wanted):
    return {
        number
        for number, found in TYPES.items()
        if all(getattr(found, key) == value for key, value in wanted.items())
    }


def test_there_are_33_types_with_names_of_their_own_and_17_objects():
    assert list(TYPES) == list(range(1, COUNT + 1)) and CUTKOSKY < COUNT
    assert len({found.name for found in TYPES.values()}) == COUNT
    assert len({found.object for found in TYPES.values()}) == 17


def test_oppositions_are_those_of_the_taxonomy():
    assert numbers(power="power", opposition="palm") == POWER_PALM == numbers(opposition="palm")
    assert numbers(power="power", opposition="pad") == {18, 19, 26, 28, 31}
    assert numbers(power="intermediate") == {16, 21, 23, 25, 29, 32}
    assert numbers(opposition="side") == {16, 20, 21, 23, 25, 29, 32}
    assert numbers(thumb="adducted") == {4, 5, 15, 16, 17, 22, 25, 29, 30, 32}


@pytest.mark.parametrize("number", sorted(TYPES))
def test_virtual_fingers_fit_the_opposition(number):
    found = TYPES[number]
    assert not set(found.first) & set(found.second)
    if found.opposition == "palm":
        assert found.first == (PALM,) and THUMB not in found.excluded
    elif number != 23:
        assert found.first == (THUMB,)
    assert not found.required & found.excluded
    assert PALM not in found.excluded


def test_how_many_fingers_oppose():
    fingers = Counter(len(found.second) for found in TYPES.values())
    assert fingers == {4: 15, 3: 4, 2: 4, 1: 10}
    assert TYPES[17].excluded == {"index"}
    assert TYPES[14].excluded == {"ring", "little"}
