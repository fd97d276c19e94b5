"""Running nodes as the source of a page; topics and commands are handled in a thread."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from pneuflex_sim.hand.layout import build_layout
from pneuflex_sim.pictures.render import HandState
from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.urdf import joint_orientations
from pneumaticbox_driver.ros.client import PneumaticboxClient, PneumaticboxError
from softhand_bringup.figures import recorded_segments
from softhand_common.documents.quoted import listed, quoted
from softhand_common.numerics.arrays import Array
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from softhand_play.frames import INTERVAL, NO_ARROWS, Frame, StaticScene
from softhand_play.messages import Look, Report
from softhand_play.player import Source
from softhand_ros.client_link import ClientLink
from softhand_ros.topics import latched, seconds

FRAME_SPACING = INTERVAL - 1e-6  # smallest time between frames [s]
ANSWER_LIMIT = 5.0  # wall time for the answer of a service [s]
DRIVER_LIMIT = 3.0  # wall time for the discovery of the driver [s]
MESSAGE_TIME = 3.0  # wall time for which an error stays shown after the last wrong message [s]
POSE_LENGTH_ERROR = 0.01  # by which the length of a quaternion may differ from 1
MOST_HANDS = 8  # whose static scenes are kept
JOINTS_NAME, AIR_NAME = "hand/joint_states", "pneumaticbox/state"
POSES = {"wrist/pose": "wrist", "scene/object_pose": "object"}


class LivePlayer(Source):
    """Shows and commands the nodes of this ROS domain; hand, object and scene must be those of the
    nodes.

    A message that does not fit hand or object is skipped and reported.

    Raises ValueError for names that do not exist.
    """

    def __init__(self, hand: str, object_name: str, scene: str, report: Report) -> None:
        super().__init__(report)
        self._file, self._hand, self._object = hand, load_hand(hand), load_object(object_name)
        self._scene = load_scene(scene)
        self._seen: dict[str, tuple[Array, Array]] = {}
        self._air: tuple[Array, Array] | None = None
        self._jobs: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._was_paused = False
        self._wrong: dict[str, tuple[str, float]] = {}  # by topic: error, time of the last one
        self._static_scenes: dict[tuple[str, ...], StaticScene | None] = {}  # by names of joints
        self._thread.start()

    # ---------------------------------------------------------------- commands
    def command_pressures(self, pressures: Array) -> None:
        """Command gauge pressures (channels,) [Pa]; NaN leaves a channel as it is."""
        self._jobs.put(lambda: self._command("pressure", pressures))

    def command_masses(self, masses: Array) -> None:
        """Command air masses (channels,) [kg above rest]; NaN leaves a channel as it is."""
        self._jobs.put(lambda: self._command("mass", masses))

    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Command a wrist pose: position (3,) [m], quaternion x, y, z, w (4,)."""
        message = PoseStamped()
        place, turn = message.pose.position, message.pose.orientation
        place.x, place.y, place.z = position.tolist()
        turn.x, turn.y, turn.z, turn.w = orientation.tolist()
        self._jobs.put(lambda: self._wrist.publish(message))

    def vent_box(self) -> None:
        """Open all outlets of the box until `reset_box`; earlier commands are dropped."""
        self._drop_jobs()
        self._jobs.put(lambda: self._report(self._box.vent()))

    def reset_box(self) -> None:
        """End the vent: the box closes its outlets and takes commands again."""
        self._jobs.put(lambda: self._report(self._box.reset()))

    def _drop_jobs(self) -> None:
        with suppress(Empty):
            while True:
                self._jobs.get_nowait()

    def reset(self) -> None:
        """Reset the simulator."""
        self._jobs.put(lambda: self._ask(Trigger, "sim/reset", Trigger.Request()))

    def _command(self, mode: str, values: Array) -> None:
        named = zip(self._box.channels, values.tolist(), strict=True)
        targets = {name: value for name, value in named if np.isfinite(value)}
        if any(self._box.modes[name] != mode for name in targets):
            self._box.configure(control_mode=self._box.modes | dict.fromkeys(targets, mode))
        self._box.run(targets)

    def _ask(self, kind: type, service: str, request: object) -> None:
        client = self._link.client(kind, service)
        answer = (
            self._link.ask(client, request, ANSWER_LIMIT) if client.service_is_ready() else None
        )
        self._report(
            "" if answer is not None else f"{service}: expected an answer, got none", Look.ERROR
        )
        self._link.node.destroy_client(client)

    # ---------------------------------------------------------------- the thread
    def _work(self) -> None:
        with ClientLink("softhand_play") as self._link:
            link = self._link
            self._wrist = link.node.create_publisher(PoseStamped, "wrist/target_pose", 10)
            self._listen(JointState, JOINTS_NAME, self._on_joints)
            self._listen(JointState, AIR_NAME, self._on_air)
            for topic, name in POSES.items():
                self._listen(PoseStamped, topic, partial(self._on, name))
            link.node.create_subscription(String, "grasp/phase", self._on_phase, latched(1))
            self._report("waiting for a simulator and a driver in this ROS domain")
            while not (self._closing.is_set() or self.now):
                link.spin(INTERVAL)
            self._serve()

    def _serve(self) -> None:
        """Connect to the driver and carry out commands until the end."""
        while not self._closing.is_set():
            try:
                with PneumaticboxClient(DRIVER_LIMIT, name="softhand_play_box") as self._box:
                    self._drop_jobs()  # nobody expects them any more
                    self._report_wrong()
                    self._carry_out()
            except PneumaticboxError as error:
                self._report(str(error), Look.ERROR)
                self._link.spin(INTERVAL)

    def _carry_out(self) -> None:
        """Carry out commands; refusals of nodes are reported. Without a browser, the driver's
        `command_timeout` counts.
        """
        while not self._closing.is_set():
            try:
                if self.is_watched():
                    self._box.keep_alive()
                self._jobs.get_nowait()()
            except Empty:
                self._link.spin(0.5 * INTERVAL)
            except (PneumaticboxError, ValueError) as error:
                self._report(str(error), Look.ERROR)
            if self.paused != self._was_paused:
                self._was_paused = self.paused
                self._ask(SetBool, "sim/pause", SetBool.Request(data=self.paused))

    def _listen(self, kind: Any, topic: str, read: Callable[[Any], None]) -> None:
        """Subscribe to a topic: `read` gets each message. Its ValueError is reported and stays
        shown as long as such messages come.
        """

        def receive(message: Any) -> None:
            known, last = self._wrong.get(topic, ("", 0.0))
            try:
                read(message)
            except ValueError as error:
                sentence = f"{topic}: {error}"
                self._wrong[topic] = sentence, time.monotonic()
                if sentence != known:
                    self._report(sentence, Look.ERROR)
            else:
                if known and time.monotonic() > last + MESSAGE_TIME:
                    del self._wrong[topic]
                    self._report_wrong()

        self._link.listen(kind, topic, receive)

    def _report_wrong(self) -> None:
        """Report the error of a current wrong message, or clear the message line."""
        self._report(next((sentence for sentence, _ in self._wrong.values()), ""), Look.ERROR)

    def _on(self, name: str, message: PoseStamped) -> None:
        place, turn = message.pose.position, message.pose.orientation
        position = _numbers("position", [place.x, place.y, place.z], 3)
        orientation = _numbers("orientation", [turn.x, turn.y, turn.z, turn.w], 4)
        if abs(np.linalg.norm(orientation) - 1.0) > POSE_LENGTH_ERROR:
            raise ValueError(f"orientation: expected a quaternion of length 1, got {orientation}")
        self._seen[name] = position, orientation

    def _on_air(self, message: JointState) -> None:
        channels = self._hand.channels
        if tuple(message.name) != tuple(channels):
            raise ValueError(
                f"name: expected the channels {listed(channels)} of {self._hand.name}, "
                f"got {listed(message.name)}"
            )
        masses = _numbers("position", message.position, len(channels))
        self._air = masses, _numbers("effort", message.effort, len(channels))

    def _on_phase(self, message: String) -> None:
        self.phase = message.data

    def _on_joints(self, message: JointState) -> None:
        """Add a frame when one is due and the other topics have arrived."""
        stamp, now = seconds(message.header.stamp), self.now
        static_scene = self._static_scene_of(tuple(message.name))
        if now is not None and now.frames[-1].time <= stamp < now.frames[-1].time + FRAME_SPACING:
            return
        angles = _numbers("position", message.position, len(message.name))
        if self._air is None or "wrist" not in self._seen:
            return
        poses = (*self._seen["wrist"], *self._seen.get("object", ()))
        state = HandState(joint_orientations(angles), *poses)
        masses, pressures = self._air
        volumes = static_scene.volumes(masses, pressures)
        frame = Frame(stamp, state, pressures, masses, volumes, NO_ARROWS, self.phase)
        reset = now is not None and (
            stamp < now.frames[-1].time or static_scene is not now.static_scene
        )
        if now is None or reset:
            self._begin(static_scene, frame)
        else:
            now.frames.append(frame)

    def _static_scene_of(self, names: tuple[str, ...]) -> StaticScene:
        """The static scene for joints of these names; raises ValueError for another hand."""
        if names not in self._static_scenes:
            if len(self._static_scenes) >= MOST_HANDS:
                self._static_scenes.clear()
            self._static_scenes[names] = self._build_static_scene(names)
        static_scene = self._static_scenes[names]
        if static_scene is None:
            raise ValueError(
                f"name: expected the joints of {self._hand.name}, got {len(names)} other names: "
                f"{listed(names[:3])}"
            )
        return static_scene

    def _build_static_scene(self, names: tuple[str, ...]) -> StaticScene | None:
        try:
            segments = recorded_segments(self._file, names)
        except ValueError:
            return None
        layout = build_layout(self._hand, segments, load_model(None))
        return StaticScene(layout, self._object if self._scene.has_object else None, self._scene)


def _numbers(what: str, values: Sequence[float], count: int) -> Array:
    """The values as an array (count,); raises ValueError unless they are finite numbers."""
    found = np.array(values, float)
    if found.shape != (count,) or not np.isfinite(found).all():
        raise ValueError(f"{what}: expected {count} finite numbers, got {quoted(list(values))}")
    return found
