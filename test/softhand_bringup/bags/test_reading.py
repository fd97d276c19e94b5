"""Reading of a bag: values, names and times come back as they were sent."""

import random
import shutil

import numpy as np
import pytest
import synthetic_bag

from softhand_bringup.bags.reading import Bag
from softhand_bringup.figures import commanded_masses


def test_joint_states_come_back_with_names_and_stamps(grasp_bag):
    with Bag(grasp_bag) as bag:
        state = bag.joints("/pneumaticbox/state")
    assert state.names == ("a",)
    assert state.time == pytest.approx(np.arange(0.0, 4.001, 0.02))
    assert state.position[-1] == pytest.approx([2e-5])
    assert state.effort[100] == pytest.approx([1e9 * 2e-5])
    assert state.velocity.shape == (201, 0)


def test_times_of_messages_without_a_stamp_are_simulated_times(grasp_bag):
    with Bag(grasp_bag) as bag:
        texts = bag.texts("/grasp/phase")
    assert [name for _, name in texts] == ["idle", "close", "lift"]
    # received at half these times on the wall, as the synthetic clock runs at twice real time
    assert [time for time, _ in texts] == pytest.approx([0.2, 1.0, 3.0], abs=1e-6)


def test_a_pose_is_looked_up_at_any_time(grasp_bag):
    with Bag(grasp_bag) as bag:
        poses = bag.poses("/scene/object_pose").at(np.array([-1.0, 3.51, 99.0]))
    assert poses.position[:, 2] == pytest.approx([0.03, 0.08, 0.13], abs=1e-6)


def test_a_command_with_stamp_zero_starts_when_it_was_received(grasp_bag):
    with Bag(grasp_bag) as bag:
        commands = bag.commands("/pneumaticbox/command")
        state = bag.joints("/pneumaticbox/state")
    assert commands[0].start == pytest.approx(1.0, abs=1e-6)
    # in the synthetic grasp the contained mass follows the commanded one exactly
    masses = commanded_masses(commands, state.names, state.time)
    assert masses == pytest.approx(state.position, abs=1e-11)


def test_a_topic_that_was_not_recorded_is_named(grasp_bag):
    with Bag(grasp_bag) as bag, pytest.raises(ValueError, match="/none: expected messages"):
        bag.joints("/none")


def test_without_a_clock_times_count_from_the_start_of_the_bag(tmp_path):
    bag = synthetic_bag.SyntheticBag(tmp_path / "bag")
    bag.say("/grasp/phase", 1.0, "approach")
    bag.say("/grasp/phase", 3.0, "close")
    bag.close()
    with Bag(tmp_path / "bag") as read:
        assert list(read.messages("/clock")) == []
        assert read.texts("/grasp/phase") == [(0.0, "approach"), (1.0, "close")]


@pytest.mark.parametrize("seed", range(12))
def test_a_damaged_bag_is_read_or_refused_by_name(grasp_bag, tmp_path, seed):
    folder, chance = tmp_path / "damaged", random.Random(seed)
    shutil.copytree(grasp_bag, folder)
    path = chance.choice(sorted(folder.iterdir()))
    content = bytearray(path.read_bytes())
    for _ in range(chance.choice((1, 20, 500))):
        content[chance.randrange(len(content))] = chance.randrange(256)
    path.write_bytes(content[: chance.choice((len(content), len(content) // 2))])
    try:
        with Bag(folder) as bag:
            for topic in bag.topics():
                assert all(time is not None for time, _ in bag.messages(topic))
    except ValueError as reason:
        assert f"{folder}: expected a bag that can be read, got " in str(reason)
        assert "\n" not in str(reason)
