"""Judges a grasp by its bag alone: nothing of what the sequencer says is used."""

import numpy as np

from softhand_bringup.bags.reading import latest_index, stamp_seconds

ENVIRONMENT = {"table", "wall", "floor", "ground", "plane"}


def contact_times(bag):
    """Times (k,) [s] of hand/contacts and the set of names that touched the object at each."""
    times, touching = [], []
    for time, message in bag.messages("/hand/contacts"):
        stamps = [stamp_seconds(marker.header.stamp) for marker in message.markers]
        pairs = [marker.ns.split("/") for marker in message.markers if marker.action == 0]
        times.append(stamps[0] if stamps else time)
        touching.append({name for pair in pairs if "object" in pair for name in pair} - {"object"})
    return np.array(times), touching


def held_time(bag, height):
    """Longest time [s] the object was at least `height` [m] above its start, touched by the hand
    and by nothing else."""
    poses = bag.poses("/scene/object_pose")
    times, touching = contact_times(bag)
    rise = poses.position[:, 2] - poses.position[0, 2]
    begun, longest = None, 0.0
    for time, up, names in zip(
        poses.time,
        rise >= height,
        (touching[k] for k in latest_index(times, poses.time)),
        strict=True,
    ):
        if up and names and not names & ENVIRONMENT:
            begun = time if begun is None else begun
            longest = max(longest, time - begun)
        else:
            begun = None
    return longest


def slip_in_hold(bag, phase):
    """Greatest distance of the object, in the wrist frame, from where a phase found it [m]."""
    texts = bag.texts("/grasp/phase")
    start = next(time for time, name in texts if name == phase)
    end = next((time for time, _ in texts if time > start), np.inf)
    poses = bag.poses("/scene/object_pose")
    inside = (poses.time >= start) & (poses.time <= end)
    wrist = bag.poses("/wrist/pose").at(poses.time[inside])
    local = rotate_back(wrist.orientation, poses.position[inside] - wrist.position)
    return float(np.linalg.norm(local - local[0], axis=1).max())


def rotate_back(quaternions, vectors):
    """Vectors (k, 3) in the frames whose orientations (k, 4) are given."""
    axis, real = -quaternions[:, :3], quaternions[:, 3:]
    twice = 2.0 * np.cross(axis, vectors)
    return vectors + real * twice + np.cross(axis, twice)
