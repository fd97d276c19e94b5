"""Frames of a bag, read by `rosbags` and `mcap`, against the simulation's own poses."""

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from pneuflex_sim.simulation import Simulation, SimulationConfig
from pneuflex_sim.urdf import joint_names, joint_positions, write_urdf
from softhand_bringup.bags.frames import FrameWriter
from softhand_bringup.bags.writing import BagWriter

TYPES = get_typestore(Stores.ROS2_JAZZY)
STEPS, EVERY = 105, 5  # of 2 ms; between messages
LINKS = 6  # messages with the links, from 10 ms on every 40 ms; the last one at the end


def made(kind, **fields):
    return TYPES.types[kind](**fields)


def header(time):
    sec, nanosec = divmod(round(time * 1e9), 10**9)
    stamp = made("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
    return made("std_msgs/msg/Header", stamp=stamp, frame_id="world")


def pose_message(time, position, orientation):
    pose = made(
        "geometry_msgs/msg/Pose",
        position=made("geometry_msgs/msg/Point", **dict(zip("xyz", position, strict=True))),
        orientation=made(
            "geometry_msgs/msg/Quaternion", **dict(zip("xyzw", orientation, strict=True))
        ),
    )
    return made("geometry_msgs/msg/PoseStamped", header=header(time), pose=pose)


@pytest.fixture(scope="module", params=["", "left/"], ids=["root", "namespace"])
def recorded(request, tmp_path_factory):
    """A bag of a hand that moves with the frames, its prefix, and the fingertips at the end."""
    prefix, folder = request.param, tmp_path_factory.mktemp("bag") / "bag"
    simulation = Simulation(SimulationConfig(step=0.002))
    bag = BagWriter(folder)
    frames = FrameWriter(bag, [], [])

    def take(topic, kind, message, time):
        data = bytes(TYPES.serialize_cdr(message, kind))
        logged = round(time * 1e9)
        frames.take(f"/{prefix}{topic}", kind, logged, logged, data)

    urdf = write_urdf(simulation.bodies.layout)
    text = made("std_msgs/msg/String", data=urdf)
    take("robot_description", "std_msgs/msg/String", text, 0.0)
    for number in range(1, STEPS + 1):
        simulation.step(np.array([1, 1, 1, 1], dtype=np.int8))
        if number % EVERY:
            continue
        time = simulation.time
        wrist = pose_message(time, *(part.tolist() for part in simulation.wrist_pose()))
        thing = pose_message(time, *(part.tolist() for part in simulation.object_pose()))
        take("wrist/pose", "geometry_msgs/msg/PoseStamped", wrist, time)
        take("scene/object_pose", "geometry_msgs/msg/PoseStamped", thing, time)
        joints = made(
            "sensor_msgs/msg/JointState",
            header=header(time),
            name=joint_names(simulation.bodies.layout),
            position=joint_positions(simulation.bodies.q),
            velocity=np.zeros(0),
            effort=np.zeros(0),
        )
        take("hand/joint_states", "sensor_msgs/msg/JointState", joints, time)
    bag.close()
    yield folder, prefix, simulation
    simulation.close()


def transforms(folder):
    """Topic, log time [ns] and transform of each frame in the bag, in order."""
    with AnyReader([folder]) as reader:
        for connection, logged, data in reader.messages():
            for found in reader.deserialize(data, connection.msgtype).transforms:
                yield connection.topic, logged, found


def matrix(found):
    move, turn = found.transform.translation, found.transform.rotation
    whole = np.eye(4)
    whole[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    whole[:3, 3] = move.x, move.y, move.z
    return whole


def test_the_frames_are_one_tree_below_the_world_with_every_link_of_the_urdf(recorded):
    folder, prefix, simulation = recorded
    parents = {}
    for _, _, found in transforms(folder):
        parent = parents.setdefault(found.child_frame_id, found.header.frame_id)
        assert parent == found.header.frame_id
    links = set(parents)
    for frame in links:
        path = [frame]
        while path[-1] in parents:
            path.append(parents[path[-1]])
            assert len(path) <= len(parents) + 1
        assert path[-1] == "world"
    urdf = write_urdf(simulation.bodies.layout)
    assert links == {f"{prefix}object"} | {
        f"{prefix}{piece.split(chr(34))[0]}" for piece in urdf.split('<link name="')[1:]
    }


def test_times_do_not_go_back_and_the_wrist_comes_at_every_pose(recorded):
    folder, prefix, _ = recorded
    stamps, logs = {}, []
    for topic, logged, found in transforms(folder):
        logs.append(logged)
        if topic == "/tf":
            stamp = found.header.stamp.sec * 10**9 + found.header.stamp.nanosec
            assert stamp == logged
            stamps.setdefault(found.child_frame_id, []).append(stamp)
    assert logs == sorted(logs)
    assert all((np.diff(times) > 0).all() for times in stamps.values())
    assert len(stamps[f"{prefix}wrist"]) == STEPS / EVERY
    assert len(stamps[f"{prefix}little_0_x_link"]) == LINKS


def test_by_the_tree_the_tips_are_where_the_simulation_has_them(recorded):
    folder, prefix, simulation = recorded
    last = {found.child_frame_id: found for _, _, found in transforms(folder)}

    def in_wrist(frame):
        whole = np.eye(4)
        while frame != f"{prefix}wrist":
            whole = matrix(last[frame]) @ whole
            frame = last[frame].header.frame_id
        return whole

    for finger, (position, orientation) in simulation.fingertips().items():
        number = max(
            int(name.rsplit("_", 1)[1])
            for name in last
            if name.startswith(f"{prefix}{finger}_") and name.rsplit("_", 1)[1].isdigit()
        )
        link = in_wrist(f"{prefix}{finger}_{number}")
        turned = Rotation.from_quat(orientation).inv() * Rotation.from_matrix(link[:3, :3])
        assert turned.magnitude() == pytest.approx(0.0, abs=1e-6)
        tip = np.linalg.solve(link, [*position, 1.0])[:3]
        assert tip[:2] == pytest.approx(0.0, abs=1e-9)
        assert 0.0 < tip[2] < 0.03  # along the last segment
    bent = Rotation.from_matrix(in_wrist(f"{prefix}little_1")[:3, :3]).magnitude()
    assert bent > 0.02  # it has moved


def test_mcap_reads_the_types_by_their_name(recorded):
    folder, _, _ = recorded
    with next(folder.glob("*.mcap")).open("rb") as file:
        reader = make_reader(file)
        channels = {c.topic: c for c in reader.get_summary().channels.values()}
        schemas = reader.get_summary().schemas
        assert {"/tf", "/tf_static"} <= set(channels)
        for topic in ("/tf", "/tf_static"):
            assert schemas[channels[topic].schema_id].name == "tf2_msgs/msg/TFMessage"
        times = [message.log_time for _, _, message in reader.iter_messages()]
        assert times == sorted(times) and times


@pytest.mark.parametrize(
    ("urdf", "told"),
    [
        ("<robot/>", ""),
        ("none", "expected a URDF, got text that is not XML"),
        ('<robot><joint name="a" type="fixed"/></robot>', "expected a parent and a child link"),
    ],
    ids=["no joints", "no XML", "no links"],
)
def test_a_description_without_usable_links_is_told_and_ends_nothing(tmp_path, urdf, told):
    bag = BagWriter(tmp_path / "bag")
    frames = FrameWriter(bag, [], [])
    data = bytes(TYPES.serialize_cdr(made("std_msgs/msg/String", data=urdf), "std_msgs/msg/String"))
    frames.take("/robot_description", "std_msgs/msg/String", 1, 1, data)
    other = bytes(4)  # of another type than the suite's
    frames.take("/wrist/pose", "std_msgs/msg/Empty", 1, 1, other)
    assert told in frames.refused and bool(told) == bool(frames.refused)
    bag.close()
    assert not list(transforms(tmp_path / "bag"))
