"""Hand descriptions: the shipped ones, and what is said about broken ones."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from softhand_model.chain.chain import ChainModel
from softhand_model.data_files import data_file
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import Strut, Web, hand_names, load_hand
from softhand_model.model_file import Model


def test_shipped_hands():
    assert hand_names() == ["rbo_hand_1", "rbo_hand_1_split", "rbo_hand_2", "single_finger"]


def test_rbo_hand_2_has_seven_actuators_in_six_chains():
    hand = load_hand("rbo_hand_2")
    assert len(hand.chains) == 6
    assert len(hand.actuator_names) == 7
    fed = {name: hand.channels[hand.channel_of(name)] for name in hand.actuator_names}
    assert fed == {
        "little": "a",
        "ring": "a",
        "middle": "a",
        "index": "b",
        "palm_inner": "c",
        "palm_outer": "d",
        "thumb": "c",
    }
    assert hand.tips == ("thumb", "index", "middle", "ring", "little")
    assert hand.mass == 0.178


def test_thumb_rides_on_the_outer_arc_of_the_palm():
    hand = load_hand("rbo_hand_2")
    mount, palm = hand.chain("thumb").mount, hand.chain("palm")
    assert mount.parent == "palm"
    outer = palm.actuators["palm_outer"].arc_radius
    middle = (outer + palm.actuators["palm_inner"].arc_radius) / 2
    assert mount.position[1] == pytest.approx(-palm.turn * (outer - middle))


@pytest.mark.parametrize("name", ["rbo_hand_1", "rbo_hand_1_split", "rbo_hand_2", "single_finger"])
def test_actuators_and_struts_weigh_less_than_the_hand(name):
    hand = load_hand(name)
    rubber = sum(part.mass for chain in hand.chains for part in chain.actuators.values())
    struts = sum(chain.strut.mass for chain in hand.chains if chain.strut)
    assert 0 < rubber + struts < hand.mass


def test_rbo_hand_1_feeds_three_pairs_of_p5_from_one_channel():
    hand = load_hand("rbo_hand_1")
    assert [part.name for chain in hand.chains for part in chain.actuators.values()] == ["P5"] * 6
    assert hand.channels == ("a",)
    assert hand.max_pressures() == pytest.approx([250e3])
    lean = [chain.mount.rpy[1] for chain in hand.chains]
    assert lean == pytest.approx([np.radians(30)] * 3)
    assert all(chain.web.length == 0.5 * 0.120 for chain in hand.chains)


def test_palm_sheets_are_of_the_rubber_that_the_thesis_states():
    """Section 7.2: 100 x 80 x 5 mm, E = 600 kPa, bent by 180 deg; 7.3: much like it."""
    sheet = load_hand("rbo_hand_1").sheet
    assert (sheet.length, sheet.width, sheet.thickness) == (0.100, 0.080, 0.005)
    assert sheet.angle == pytest.approx(np.pi)
    assert [load_hand(f"rbo_hand_{k}").sheet.modulus for k in (1, 2)] == [600e3, 600e3]


def test_struts_of_rbo_hand_2_are_as_thick_and_as_stiff_as_the_thesis_states():
    """Section 7.3: 2 mm of sintered polyamide; its maker states 1.7 GPa. They bend about y."""
    for name in ("little", "ring", "middle", "index"):
        strut = load_hand("rbo_hand_2").chain(name).strut
        assert (strut.thickness, strut.modulus) == (0.002, 1.7e9)
        bend = 1.7e9 * strut.width * 0.002**3 / 12.0 / strut.length
        assert strut.stiffness()[1] == pytest.approx(bend)


def test_fingers_of_rbo_hand_2_are_90_mm_long_and_the_thumb_70():
    hand = load_hand("rbo_hand_2")
    lengths = {name: hand.chain(name).actuators[name].length for name in ("index", "thumb")}
    assert lengths == {"index": 0.090, "thumb": 0.070}


def test_rest_volume_of_a_channel_is_the_sum_of_its_actuators():
    hand = load_hand("rbo_hand_2")
    finger = hand.chain("index").actuators["index"]
    one = finger.chamber_volume() + finger.supply_volume
    assert hand.rest_volumes()[:2] == pytest.approx([3 * one, one])
    assert 1e-5 < one < 3e-5


def test_strut_bends_like_a_cantilever_under_an_end_moment():
    """Rotation of the tip of a beam under a moment: M*L/(E*I)."""
    strut = Strut(0.05, 0.012, 0.002, 1.7e9)
    flat = 1.7e9 * 0.012 * 0.002**3 / 12
    assert strut.stiffness()[1] == pytest.approx(flat / 0.05)
    assert strut.stiffness()[0] == pytest.approx(flat * 36 / 0.05)
    assert 0 < strut.stiffness()[2] < strut.stiffness()[0]


def test_strut_twists_like_saint_venant_says():
    """Series solution of a bar of 6:1, J = w*t**3/3*(1 - 192*t/(pi**5*w)*sum tanh/odd**5)."""
    odd = np.arange(1, 60, 2)
    series = np.sum(np.tanh(odd * np.pi * 6 / 2) / odd**5)
    exact = 0.012 * 0.002**3 / 3 * (1 - 192 / (np.pi**5 * 6) * series)
    strut = Strut(0.05, 0.012, 0.002, 1.7e9)
    assert strut.stiffness()[2] == pytest.approx(1.7e9 / 2.8 * exact / 0.05, rel=1e-3)


def chain_of(web=None, types=("P5", "P5")):
    """Segments of a chain of RBO Hand 1 with another web and other actuators."""
    chain = load_hand("rbo_hand_1").chain("middle")
    parts = {str(k): load_actuator(kind) for k, kind in enumerate(types)}
    return ChainModel(replace(chain, actuators=parts, web=web), 10, Model())


def test_a_pair_is_as_stiff_as_both_and_bends_like_one():
    pair, one = chain_of(), chain_of(types=("P5",))
    np.testing.assert_allclose(pair.segments.stiffness, 2 * one.segments.stiffness)
    np.testing.assert_allclose(pair.segments.mass, 2 * one.segments.mass)
    np.testing.assert_allclose(pair.rest_rotation([4e4, 4e4]), one.rest_rotation([4e4]))
    half = pair.rest_rotation([4e4, 0.0])
    np.testing.assert_allclose(half, 0.5 * one.rest_rotation([4e4]), atol=1e-12)


def test_mesh_stiffens_the_joined_half_sideways_and_in_twist_alone():
    bare, joined = chain_of().segments.stiffness, chain_of(Web(3, 0.060)).segments.stiffness
    expected = np.ones((10, 3))
    expected[:5, [0, 2]] = 3.0
    np.testing.assert_allclose(joined / bare, expected)


def test_split_fingers_hold_the_rubber_and_air_of_whole_ones():
    whole, split = load_hand("rbo_hand_1"), load_hand("rbo_hand_1_split")
    for name in ("left", "right"):
        assert split.chain(f"{name}_tip").mount.parent == name
    parts = [
        sum(part.chamber_volume() for chain in hand.chains for part in chain.actuators.values())
        for hand in (whole, split)
    ]
    assert parts[0] == pytest.approx(parts[1])


def broken(change, hand="rbo_hand_2"):
    """The description of a hand with one change made to it."""
    text = data_file("hands", f"{hand}.yaml").read_text(encoding="utf-8")
    document = yaml.safe_load(text)
    change(document)
    return yaml.safe_dump(document, sort_keys=False)


def set_in(*keys, value):
    def change(document):
        for key in keys[:-1]:
            document = document[key]
        document[keys[-1]] = value

    return change


LITTLE = ("chains", "little", "actuators", "little")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (set_in(*LITTLE, "type", value="P11"), "little.type: expected one of P5, P10.finger"),
        (set_in(*LITTLE, "channel", value="e"), "little.channel: expected one of a, b, c, d, got"),
        (set_in("channels", value=["a", "b", "c", "d", "e"]), "channels: expected channels that"),
        (
            set_in("chains", "little", "mount", "parent", value="thumb"),
            "parent: expected one of wr",
        ),
        (set_in("chains", "little", "mount", "position", value=[0, 0]), "expected 3 numbers"),
        (
            set_in("chains", "little", "mount", "rpy", value=[0, 0, "x"]),
            "rpy[2]: expected a number",
        ),
        (
            set_in("chains", "little", "strut", "length", value=0),
            "strut.length: expected a number from 0.002 to 2 m",
        ),
        (set_in("chains", "little", "turn", value=1), "expected no key turn"),
        (set_in("chains", "palm", "turn", value=2), "palm.turn: expected one of 1, -1, got 2"),
        (set_in("chains", "little", "actuators", value={}), "expected one actuator, or two str"),
        (set_in("chains", "little", "actuators", value=LITTLE), "actuators: expected a mapping"),
        (set_in("tips", value=["thumb", "toe"]), "tips[1]: expected one of little, ring"),
        (set_in("mass", value="heavy"), "mass: expected a number from 0.001 to 20 kg, got 'heavy'"),
        (set_in("plate", "size", value=[1, 1, 0]), "plate.size[2]: expected a number from 0.0005"),
        (set_in("chains", value={}), "chains: expected at least one chain, got {}"),
        (set_in("name", value="../../evil"), "name: expected a name of letters, digits, _ and -"),
        (set_in("mass", value=178), "mass: expected a number from 0.001 to 20 kg, got 178"),
        (set_in("mass", value=0.05), "mass: expected at least 0.1"),
        (
            set_in("chains", "little", "mount", "position", value=[0, -36, 60]),
            "position[1]: expected a number from -2 to 2 m, got -36",
        ),
        (
            set_in("chains", "little", "mount", "rpy", value=[0, 0, 90]),
            "rpy[2]: expected a number from -6.283 to 6.283 rad, got 90",
        ),
        (
            set_in("chains", "little", "strut", "thickness", value=2),
            "strut.thickness: expected a number from 2e-05 to 0.05 m, got 2",
        ),
        (
            set_in("chains", "little", "strut", "modulus", value=1.7),
            "strut.modulus: expected a number from 5000 to 1e+12 Pa, got 1.7",
        ),
        (
            set_in("sheet", "width", value=90),
            "sheet.width: expected a number from 0.001 to 1 m, got 90",
        ),
        (set_in("format", value="softhand-hand/2"), "format: expected one of softhand-hand/1"),
        (set_in("colour", value="blue"), "got colour"),
        (set_in("chains", "little", "pitch", value=0.02), "expected no key pitch"),
        (set_in("chains", "palm", "web", value={}), "palm.web: expected no web, as"),
        (
            set_in("chains", "little", "web", value={"chains": 1, "length": 0.1}),
            "web.chains: expected one of 2, 3",
        ),
        (set_in("sheet", "angle", value=4.0), "sheet.angle: expected a number"),
        (lambda document: document.pop("channels"), "expected the key channels, got"),
    ],
)
def test_broken_hand_is_named(tmp_path, change, message):
    path = tmp_path / "hand.yaml"
    path.write_text(broken(change), encoding="utf-8")
    with pytest.raises(ValueError) as caught:
        load_hand(path)
    assert str(path) in str(caught.value)
    assert message in str(caught.value)


def turned_away(document):
    document["chains"]["middle"]["mount"]["rpy"][2] = 3.0


def put_last(document):
    document["chains"]["middle"]["mount"]["position"][1] = 0.05


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            set_in("chains", "left", "pitch", value=0.001),
            "left.pitch: expected a number from 0.009 to 0.3 m, got 0.001",
        ),
        (
            set_in("chains", "left", "web", "length", value=0.6),
            "left.web.length: expected a number above 0 and at most 0.12, got 0.6",
        ),
        (
            set_in("chains", "right", "web", "chains", value=2),
            "left.web.chains: expected a divisor of 2, the number of chains side by side that have "
            "this web, got 3",
        ),
        (
            lambda document: document["chains"]["middle"].pop("web"),
            "expected a divisor of 1, the number of chains",
        ),
        (turned_away, "left.web.chains"),
        (
            set_in("chains", "right", "mount", "parent", value="left"),
            "expected a divisor of 2, the number of chains",
        ),
    ],
)
def test_mesh_and_pairs_that_cannot_be_are_named(tmp_path, change, message):
    path = tmp_path / "hand.yaml"
    path.write_text(broken(change, "rbo_hand_1"), encoding="utf-8")
    with pytest.raises(ValueError) as caught:
        load_hand(path)
    assert str(path) in str(caught.value)
    assert message in str(caught.value)


def test_mesh_joins_neighbours_in_whatever_order_they_are_written(tmp_path):
    path = tmp_path / "hand.yaml"
    path.write_text(broken(put_last, "rbo_hand_1"), encoding="utf-8")
    assert all(chain.web.chains == 3 for chain in load_hand(path).chains)


def test_actuator_used_twice_is_named(tmp_path):
    def twice(document):
        document["chains"]["ring"]["actuators"] = document["chains"]["little"]["actuators"]

    path = tmp_path / "hand.yaml"
    path.write_text(broken(twice), encoding="utf-8")
    with pytest.raises(ValueError, match="expected names that no other chain uses, got little"):
        load_hand(path)


def test_outer_arc_before_the_inner_is_refused(tmp_path):
    def swap(document):
        arcs = document["chains"]["palm"]["actuators"]
        document["chains"]["palm"]["actuators"] = dict(reversed(arcs.items()))

    path = tmp_path / "hand.yaml"
    path.write_text(broken(swap), encoding="utf-8")
    with pytest.raises(ValueError, match="inner first"):
        load_hand(path)


def test_wrong_names_are_answered_with_lists():
    hand = load_hand("single_finger")
    with pytest.raises(ValueError, match="chain: expected one of finger, got thumb"):
        hand.chain("thumb")
    with pytest.raises(ValueError, match="actuator: expected one of finger, got thumb"):
        hand.channel_of("thumb")
    with pytest.raises(ValueError, match="rbo_hand_2"):
        load_hand("rbo_hand_9")


OWN = {
    "length": 0.1,
    "height": [[0.0, 0.03], [0.1, 0.01]],
    "width": 0.02,
    "wall": 0.002,
    "side_wall": 0.002,
    "max_pressure": 50e3,
}


def own(**changes):
    """RBO Hand 2 with an actuator of its own for the little finger."""

    def change(document):
        document["types"] = {"stub": {**OWN, **changes}}
        set_in(*LITTLE, "type", value="stub")(document)

    return broken(change)


def test_a_hand_brings_actuators_of_its_own(tmp_path):
    path = tmp_path / "hand.yaml"
    path.write_text(own(shear_modulus=113e3, density=1200.0), encoding="utf-8")
    stub = load_hand(path).chain("little").actuators["little"]
    assert (stub.shear_modulus, stub.max_pressure) == (113e3, 50e3)
    assert float(stub.height(0.05)) == pytest.approx(0.02)
    # top: 20 mm x 2 mm; side walls: twice 2 mm of the height less the wall, 18 mm in the mean
    assert stub.mass == pytest.approx(1200 * 0.1 * (0.02 * 0.002 + 2 * 0.002 * 0.018))
    assert load_hand(path).chain("ring").actuators["ring"] == load_actuator("P10.finger")


def test_the_wall_of_an_own_actuator_may_vary_along_it(tmp_path):
    path = tmp_path / "hand.yaml"
    path.write_text(own(wall=[[0, 0.004], [0.1, 0.002]], side_wall=0.001), encoding="utf-8")
    stub = load_hand(path).chain("little").actuators["little"]
    assert stub.wall([0.0, 0.05, 0.1]) == pytest.approx([0.004, 0.003, 0.002])
    # top: 20 mm x 3 mm in the mean; side walls: twice 1 mm of the height less the wall, 17 mm
    assert stub.mass == pytest.approx(1070 * 0.1 * (0.02 * 0.003 + 2 * 0.001 * 0.017))


def test_own_actuators_are_of_the_rubber_of_the_shipped_ones_unless_they_say(tmp_path):
    path = tmp_path / "hand.yaml"
    path.write_text(own(), encoding="utf-8")
    stub = load_hand(path).chain("little").actuators["little"]
    assert stub.shear_modulus == 67e3
    assert stub.mass == pytest.approx(1070 * 0.1 * (0.02 * 0.002 + 2 * 0.002 * 0.018))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (own(wall=0.012), "types.stub.wall: expected a number below the height, 0.01"),
        (
            own(wall=[[0, 0.002], [0.1, 0.012]]),
            "types.stub.wall: expected a number below the heigh",
        ),
        (own(wall=[[0, 0.002], [0.05, 0.002]]), "types.stub.wall: expected [x, value] from x = 0"),
        (own(side_wall=0.01), "types.stub.side_wall: expected a number below half the width, 0.01"),
        (own(colour="blue"), "types.stub: expected only the keys height"),
        (own(mass=0.1, density=1e3), "types.stub: expected either mass or density, got both"),
        (own(density=-1), "types.stub.density: expected a number from 100 to 2e+04 kg/m3, got -1"),
        (own(height=[[0, 0.02]]), "types.stub.height: expected at least two [x, value]"),
        (own(height=[[0.01, 0.03], [0.1, 0.01]]), "expected [x, value] from x = 0 to the length"),
        (own(height=[[0, 0.03], [0.05, 0.01]]), "from x = 0 to the length, 0.1 m, got [[0, 0.03]"),
        (own(height=[[0, 30], [0.1, 10]]), "height[0][1]: expected a number from 0.0003 to 0.3 m"),
        (own(length=85), "types.stub.length: expected a number from 0.002 to 2 m, got 85"),
        (own(width=18), "types.stub.width: expected a number from 0.0003 to 0.3 m, got 18"),
        (own(circumference=76), "stub.circumference: expected a number from 0.001 to 1 m, got 76"),
        (own(wall=1.8), "types.stub.wall: expected a number from 2e-05 to 0.05 m, got 1.8"),
        (own(side_wall=1.8), "types.stub.side_wall: expected a number from 0 to 0.05 m, got 1.8"),
        (
            own(max_pressure=75),
            "stub.max_pressure: expected a number from 1000 to 1e+07 Pa, got 75",
        ),
        (own(shear_modulus=113), "shear_modulus: expected a number from 1000 to 1e+08 Pa, got 113"),
        (own(density=1.07), "density: expected a number from 100 to 2e+04 kg/m3, got 1.07"),
        (own(supply_volume=0.94), "supply_volume: expected a number from 0 to 0.001 m3, got 0.94"),
        # 11.2 cm3 of rubber
        (own(mass=0.001), "mass: expected a number from 0.00112 to 0.224 kg for this volume of"),
        (own(mass=12), "to 0.224 kg for this volume of rubber, got 12"),
        (
            broken(set_in("types", value={"P5": OWN})),
            "types.P5: expected a name other than",
        ),
        (broken(set_in("types", value=[])), "types: expected a mapping, got []"),
        (
            broken(set_in("types", value={"stub": OWN})).replace("type: P10.thumb", "type: nail"),
            "thumb.type: expected one of stub, P5, P10.finger",
        ),
    ],
)
def test_a_broken_actuator_of_ones_own_is_named(tmp_path, text, message):
    path = tmp_path / "hand.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError) as caught:
        load_hand(path)
    assert str(path) in str(caught.value)
    assert message in str(caught.value)
