"""Torque at the base of a finger bent by about 90 deg whose tip is moved (Figs. 5.12-5.14).

The finger is gripped in the middle of the last link but one, where the last segment begins. The
joint within the last segment is free, as the segment is rigid where it is gripped.

The finger lies level with its base towards the camera and bends upwards: the thesis's axes x (left
to right), y (along the finger at its base) and z (up) are y, z and x of the finger's frame here.
The motion recorded in the thesis is not printed. Here the tip is moved by 10 mm as a point force
would move it (the thesis uses a chopstick), and rolled about its own axis by 30 deg.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import root
from scipy.spatial.transform import Rotation, Slerp

from pneuflex_sim.bullet import pybullet
from softhand_model.chain.segments import SegmentChain
from softhand_model.equilibrium.chain_march import straight_links, tip_pose
from softhand_model.equilibrium.joint_springs import springs_of
from softhand_model.equilibrium.spatial import HeldChain, Hold
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.joint_stiffness import THESIS, SpringModel
from thesis.chapter_3_and_5.stand import FingerStand
from thesis.chapter_3_and_5.wall_thickness import actuator_of
from thesis.frame import Array, Figure, Finding, Job, Report, Results, at_most, number, option

SIZE = (8.0, 6.0)
PRESSURE, ANGLE = 31e3, np.pi / 2.0  # [Pa, rad], both as the thesis states them
WALL = 0.0025  # [m]
SEGMENTS = 10
LEFT, UP = np.array([0.0, -1.0, 0.0]), np.array([1.0, 0.0, 0.0])
PUSHES = (("left", LEFT), ("right", -LEFT), ("down", -UP), ("up", UP))
ROLLED = "rolled"
AXES = {"x": 1, "y": 2, "z": 0}  # the thesis's axes in the finger's frame
SECTION = SpringModel(lateral="section", twist="section")
MODELS = {
    "thesis's": THESIS,
    "section's": SECTION,
    "twist-stiff": SpringModel(twist=2.0),
    "rubber's": SpringModel(bending="curvature"),
}
LEAST = 0.5  # [mN m]: changes of smaller torques are not told
CURVES = (  # of the figure: key of the results, style, label
    ("simulated", {"color": "C0", "lw": 4, "alpha": 0.5}, "simulator"),
    ("chain", {"color": "k", "ls": "", "marker": "o", "ms": 3.5, "mfc": "none"}, "static chain"),
    ("stiffer_in_twist", {"color": "C1", "lw": 1}, "twice as stiff in twist"),
    ("section", {"color": "C2", "lw": 1}, "by section"),
    ("rubber", {"color": "C3", "lw": 1, "ls": "--"}, "by 3.24"),
)
STRONGEST = 1e4  # [N, N m] of the constraint
MOVING = 60  # steps from one pose to the next
FORCE, MOMENT = 1.0, 0.05  # [N, N m] units of the search
SMALL = {"shares": (0.0, 1.0)}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    shift: float = option(0.010, "by which the tip is pushed [m]")
    roll: float = option(float(np.radians(30.0)), "by which it is rolled about its own axis [rad]")
    shares: tuple[float, ...] = option(
        (0.0, 0.33, 0.67, 1.0, 0.67, 0.33), "poses of one disturbance, there and back [-]"
    )


@dataclass(frozen=True)
class Pose:
    """Place (3,) [m] and orientation in the frame of the finger's base."""

    place: Array
    orientation: Rotation


class Grip:
    """Grips a simulated finger at its present pose, and moves the gripped point from pose to
    pose.
    """

    def __init__(self, stand: FingerStand) -> None:
        self._stand = stand
        layout = stand.simulation.bodies.layout
        self._link = len(layout.mass) - 2
        self._point = np.array([0.0, 0.0, layout.offset[-1, 2] / 2.0])
        self._held = self.pose()
        self._constraint = pybullet.createConstraint(
            stand.simulation.bodies.ids[0],
            self._link,
            -1,
            -1,
            pybullet.JOINT_FIXED,
            [0, 0, 0],
            (self._point - layout.center[self._link]).tolist(),
            (self._held.place + stand.origin).tolist(),
            [0, 0, 0, 1],
            self._held.orientation.as_quat().tolist(),
            physicsClientId=stand.client,
        )
        self._command(self._held)

    def pose(self) -> Pose:
        """Where the gripped point is."""
        simulation = self._stand.simulation
        places, axes, _ = simulation.shape.frames(simulation.bodies.q)
        own = axes[self._link]
        return Pose(places[self._link] + own @ self._point, Rotation.from_matrix(own))

    def move(self, pose: Pose, pressure: float) -> None:
        """Go to a pose, the chamber at a pressure [Pa], and wait until the finger is at rest."""
        ends = Rotation.concatenate([self._held.orientation, pose.orientation])
        between = Slerp([0.0, 1.0], ends)
        for share in np.linspace(0.0, 1.0, MOVING + 1)[1:]:
            place = self._held.place + share * (pose.place - self._held.place)
            self._command(Pose(place, between(share)))
            self._stand.step(pressure)
        self._held = pose
        self._stand.rest(pressure)

    def _command(self, pose: Pose) -> None:
        pybullet.changeConstraint(
            self._constraint,
            (pose.place + self._stand.origin).tolist(),
            pose.orientation.as_quat().tolist(),
            maxForce=STRONGEST,
            physicsClientId=self._stand.client,
        )


def gripped_part(chain: SegmentChain) -> SegmentChain:
    """The chain from its base to the gripped point, which becomes its tip."""
    rows = {
        name: getattr(chain, name)[:-1]
        for name in ("names", "offset", "rest", "axes", "stiffness", "stretching")
        + ("body_size", "body_center", "mass")
    }
    return replace(chain, **rows, tip_offset=chain.offset[-1] / 2.0)


def pushed(chain: SegmentChain, rest: Array, direction: Array, distance: float) -> Pose:
    """Pose of the tip of a chain after a force at the tip, in a direction (3,), has moved it by a
    distance [m] in that direction; without the force the joints rest at angles (n,) [rad] about y.

    Raises RuntimeError where no force does that.

    >>> from thesis.chapter_3_and_5.static_finger import chain_of
    >>> from softhand_model.hand.actuator import load_actuator
    >>> chain = chain_of(load_actuator("P10.finger"), 4).segments
    >>> pushed(chain, np.zeros(4), np.array([1.0, 0.0, 0.0]), 0.0).place.round(6).tolist()
    [0.0, 0.0, 0.09]
    """
    links, springs = straight_links(chain), springs_of(chain, rest[:, None])

    def tip(force: float, moment: Array) -> tuple[Array, Array]:
        return tip_pose(links, springs, np.concatenate([force * direction, moment]))

    start = float(direction @ tip(0.0, np.zeros(3))[0])
    length = float(links.along.sum())

    def off(unknown: Array) -> Array:
        force, moment = FORCE * unknown[0], MOMENT * unknown[1:]
        place, _ = tip(force, moment)
        left = moment - np.cross(place, force * direction)
        return np.append(left / MOMENT, (direction @ place - start - distance) / length)

    found = root(off, np.zeros(4), tol=1e-12).x
    if np.abs(off(found)).max() > 1e-8:
        raise RuntimeError(f"no force moves the tip by {distance} m along {direction}")
    place, turn = tip(FORCE * found[0], MOMENT * found[1:])
    return Pose(place, Rotation.from_matrix(turn))


def actuator() -> Actuator:
    """The finger of section 5.2.2 with a wall of 2.5 mm and the modulus fitted there.

    The thesis does not say which finger was measured; of those it names, this one bends nearest to
    the stated angle.
    """
    return actuator_of(WALL)


def wrist_poses(stand: FingerStand, start: Pose, given: Parameters) -> list[tuple[str, Pose]]:
    """Poses of the gripped point: every push twice, then three rolls to either side."""
    chain, rest = gripped_part(stand.chain), stand.rest_angles(PRESSURE)[:-1]
    poses = []
    for name, direction in PUSHES:
        ways = [share * given.shift for share in given.shares]
        poses += 2 * [(name, pushed(chain, rest, direction, way)) for way in ways]
    for side in (1.0, -1.0) * 3:
        for share in given.shares:
            roll = Rotation.from_rotvec([0.0, 0.0, side * share * given.roll])
            poses.append((ROLLED, Pose(start.place, start.orientation * roll)))
    return [*poses, (ROLLED, start)]


def run(given: Parameters, job: Job) -> Results:
    """Torques on the base at all poses, in the thesis's axes: of the simulator and of the static
    chain with the thesis's springs and with those of the section, and of the simulator with other
    springs.
    """
    finger = actuator()
    names, goals = plan(finger, given)
    moved: dict[str, tuple[list[Pose], Array]] = {}
    for key, springs in MODELS.items():
        job.progress(f"{key} springs", len(moved) / len(MODELS))
        moved[key] = _measure(finger, goals, springs)
    poses, torques = moved["thesis's"]
    section_poses, of_section = moved["section's"]
    return {
        "pressure": PRESSURE,
        "shear_modulus": finger.shear_modulus,
        "tip_angle": float(finger.tip_angle(PRESSURE)),
        "shift": given.shift,
        "roll": given.roll,
        "disturbance": names,
        "places": [pose.place.tolist() for pose in poses],
        "simulated": _named(torques),
        "chain": _named(_of_chain(finger, poses)),
        "section": _named(of_section),
        "section_chain": _named(_of_chain(finger, section_poses, SECTION)),
        "stiffer_in_twist": _named(moved["twist-stiff"][1]),
        "rubber": _named(moved["rubber's"][1]),
    }


def plan(finger: Actuator, given: Parameters) -> tuple[list[str], list[Pose]]:
    """Names and poses of the gripped point, computed with the thesis's springs."""
    with FingerStand(finger, SEGMENTS) as stand:
        stand.settle(PRESSURE)
        names, goals = zip(*wrist_poses(stand, Grip(stand).pose(), given), strict=True)
    return list(names), list(goals)


def _measure(finger: Actuator, goals: list[Pose], springs: SpringModel) -> tuple[list[Pose], Array]:
    """Measured poses, and torques (k, 3) [N m] at them."""
    poses, torques = [], []
    with FingerStand(finger, SEGMENTS, with_sensor=True, springs=springs) as stand:
        stand.settle(PRESSURE)
        grip = Grip(stand)
        for goal in goals:
            grip.move(goal, PRESSURE)
            poses.append(grip.pose())
            torques.append(stand.base_torque())
    return poses, np.array(torques)


def _of_chain(finger: Actuator, poses: list[Pose], springs: SpringModel = THESIS) -> Array:
    """Torques (k, 3) [N m] of the static chain in these poses."""
    with FingerStand(finger, SEGMENTS, springs=springs) as stand:
        chain, rest = gripped_part(stand.chain), stand.rest_angles(PRESSURE)[:-1]
    joints = springs_of(chain, np.repeat(rest[:, None], len(poses), axis=1))
    places = np.array([pose.place for pose in poses]).T
    axes = np.moveaxis(np.array([pose.orientation.as_matrix() for pose in poses]), 0, -1)
    load = HeldChain(chain).base_load(Hold(joints, places, axes))
    return np.where(load.settled, load.torque, np.nan).T


def _named(torques: Array) -> dict[str, list[float]]:
    return {axis: torques[:, column].tolist() for axis, column in AXES.items()}


def _peak(results: Results, key: str, axis: str, name: str) -> float:
    """Torque [mN m] of the largest size in a disturbance."""
    values = np.array(results[key][axis])[np.array(results["disturbance"]) == name]
    return round(1e3 * float(values[np.abs(values).argmax()]), 4) + 0.0  # no -0


def _repeat(results: Results) -> float:
    """Largest difference [N m] between the first and the second time of a push."""
    named = np.array(results["disturbance"])
    gaps = [
        np.abs(np.subtract(*np.split(values, 2))).max()
        for name, _ in PUSHES
        for values in (np.array(results["simulated"][axis])[named == name] for axis in AXES)
    ]
    return float(max(gaps))


def report(results: Results, given: Parameters) -> Report:
    """Peak torques of every disturbance; simulator against the static chain; effect of other
    springs.
    """
    named, stated = [*(name for name, _ in PUSHES), ROLLED], f"{np.degrees(ANGLE):.0f} deg"
    bend = float(np.degrees(results["tip_angle"]))
    findings = [number(f"bend at {PRESSURE / 1e3:g} kPa", bend, "deg", stated)]
    seen = {
        "left": "y considerably less than expected",
        "right": "y considerably less than expected",
        "down": "x larger than measured in one of the two directions",
        "up": "x larger than measured in one of the two directions",
        "rolled": "tracked well",
    }
    for name in named:
        peaks = [_peak(results, "simulated", axis, name) for axis in AXES]
        text = ", ".join(f"{axis} {peak:.1f}" for axis, peak in zip(AXES, peaks, strict=True))
        text = text.replace("-0.0", "0.0")
        findings.append(Finding(f"{name}: largest torques [mN m]", seen[name], text))
    for key, of_chain, what in (
        ("simulated", "chain", "simulator"),
        ("section", "section_chain", "springs of the section, simulator"),
    ):
        worst = 100.0 * _gap(results, key, of_chain)
        what += " against the static chain, of the peak"
        findings.append(at_most(what, "-", worst, 0.1, "%"))
    largest = max(np.abs(results["simulated"][axis]).max() for axis in AXES)
    repeat = 100.0 * _repeat(results) / float(largest)
    what = "second push against the first, of the peak"
    findings.append(
        at_most(what, "drifts: the finger has 1 to 2 mm of hysteresis", repeat, 0.1, "%")
    )
    return Report([*findings, *_other_springs(results)], conclude(results))


def _gap(results: Results, key: str, of_chain: str) -> float:
    """Largest difference [-] of the torques from the static chain's, over their peak."""
    found, chain = (np.array([results[part][axis] for axis in AXES]) for part in (key, of_chain))
    return float(np.abs(found - chain).max() / np.abs(found).max())


def _other_springs(results: Results) -> list[Finding]:
    """What other springs would change while the tip is moved."""
    sideways, suspected = ("left", ROLLED), "suspected for y"
    cases = [
        ("stiffer_in_twist", "with twice the stiffness in twist", suspected, sideways),
        ("section", "with lateral and torsional stiffness of the section", suspected, sideways),
        ("rubber", "with curvature-dependent stiffness (3.24)", "-", ("down", "up")),
    ]
    return [
        Finding(f"{name}, {what}", thesis, _changes(results, key, name))
        for key, what, thesis, names in cases
        for name in names
    ]


def _changes(results: Results, key: str, name: str) -> str:
    """Changes of the peak torques in a disturbance, where the peak exceeds LEAST."""
    changes = []
    for axis in AXES:
        ours = abs(_peak(results, "simulated", axis, name))
        other = abs(_peak(results, key, axis, name))
        if ours > LEAST:
            changes.append(f"{axis} {100.0 * (other / ours - 1.0):+.0f} %")
    return ", ".join(changes)


def conclude(results: Results) -> str:
    """The conclusion of the report."""
    down, up = (abs(_peak(results, "simulated", "x", name)) for name in ("down", "up"))
    return (
        f"Pushed up the x torque is {up / down:.1f} times that of down, by geometry alone: the "
        "mesh does not stretch. While the tip is pushed sideways, twice the stiffness in twist "
        f"would change the torques by {_changes(results, 'stiffer_in_twist', 'left')}: the "
        "thesis's suspicion fits, but the effect is small. The rubber of the section alone would "
        f"change them by {_changes(results, 'section', 'left')}, away from what was measured: "
        "it is the mesh that resists sideways. 3.24 would change the x torque of down by "
        f"{_changes(results, 'rubber', 'down')[2:]} and of up by "
        f"{_changes(results, 'rubber', 'up')[2:]}."
    )


def draw(figure: Figure, results: Results, report: Report) -> None:
    """Torques about the three axes over the poses, as in Fig. 5.14."""
    panels = figure.subplots(3, 1, sharex=True)
    steps = np.arange(len(results["disturbance"]))
    words = {"z": "up", "x": "left to right", "y": "along the base"}
    for axes, axis in zip(panels, ("z", "x", "y"), strict=True):
        for key, style, label in CURVES:
            axes.plot(steps, 1e3 * np.array(results[key][axis]), label=label, **style)
        axes.set_ylabel(f"{axis} ({words[axis]})\n[mN m]")
        axes.axhline(0.0, color="0.7", lw=0.5)
    named = np.array(results["disturbance"])
    over = panels[0].get_xaxis_transform()  # data along x, share of the panel along y
    for name in dict.fromkeys(results["disturbance"]):
        place = np.flatnonzero(named == name)
        panels[0].text(place.mean(), 1.02, name, ha="center", transform=over)
        for axes in panels:
            axes.axvline(place[0] - 0.5, color="0.8", lw=0.8)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, ncols=5, loc="upper center")
    figure.set_layout_engine("constrained", rect=(0.0, 0.0, 1.0, 0.95))
    panels[-1].set_xlabel(
        f"number of the pose [-]: pushes by {1e3 * results['shift']:g} mm and back, twice; "
        f"rolls by {np.degrees(results['roll']):g} deg to either side, three times"
    )
