"""Running nodes as a source of the page: topics in, commands out, in a thread of its own."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from queue import Empty, SimpleQueue

import numpy as np
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
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
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import load_model
from softhand_play.player import Source
from softhand_play.shots import INTERVAL, NO_ARROWS, Shot, Stage
from softhand_ros.client_link import ClientLink
from softhand_ros.topics import latched, seconds

Array = NDArray[np.float64]

DUE = INTERVAL - 1e-6  # from a kept instant to the next [s]
ANSWER = 5.0  # wall time for a service [s]
POSES = {"wrist/pose": "wrist", "scene/object_pose": "object"}


class LivePlayer(Source):
    """Shows nodes of this ROS domain; hand, object and scene are those that they run with.

    Raises ValueError for names that do not exist.
    """

    def __init__(
        self, hand: str, object_name: str, scene: str, tell: Callable[[str], None]
    ) -> None:
        super().__init__(tell)
        self._hand, self._object = load_hand(hand), load_object(object_name)
        self._scene = load_scene(scene)
        self._seen: dict[str, tuple[Array, Array]] = {}
        self._air: tuple[Array, Array] | None = None
        self._jobs: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._was_paused = False
        self._thread.start()

    # ---------------------------------------------------------------- commands
    def command_pressures(self, pressures: Array) -> None:
        """Gauge pressures (channels,) [Pa] to reach, NaN to leave a channel as it is."""
        self._jobs.put(lambda: self._command("pressure", pressures))

    def command_masses(self, masses: Array) -> None:
        """Air masses (channels,) [kg above rest] to reach, NaN likewise."""
        self._jobs.put(lambda: self._command("mass", masses))

    def command_wrist(self, position: Array, orientation: Array) -> None:
        """Target pose of the wrist: position (3,) [m], quaternion (4,)."""
        message = PoseStamped()
        place, turn = message.pose.position, message.pose.orientation
        place.x, place.y, place.z = position.tolist()
        turn.x, turn.y, turn.z, turn.w = orientation.tolist()
        self._jobs.put(lambda: self._wrist.publish(message))

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
        client = self._link.node.create_client(kind, service)
        answer = self._link.ask(client, request, ANSWER) if client.service_is_ready() else None
        self._tell("" if answer is not None else f"{service}: expected an answer, got none")
        self._link.node.destroy_client(client)

    # ---------------------------------------------------------------- the thread
    def _work(self) -> None:
        with ClientLink("softhand_play") as self._link:
            link = self._link
            self._wrist = link.node.create_publisher(PoseStamped, "wrist/target_pose", 10)
            link.listen(JointState, "hand/joint_states", self._on_joints)
            link.listen(JointState, "pneumaticbox/state", self._on_air)
            for topic, name in POSES.items():
                link.listen(PoseStamped, topic, partial(self._on, name))
            link.node.create_subscription(String, "grasp/phase", self._on_phase, latched(1))
            self._tell("waiting for a simulator and a driver in this ROS domain")
            while not (self._closing.is_set() or self.now):
                link.spin(INTERVAL)
            self._serve()

    def _serve(self) -> None:
        """Obey commands until the end; what nodes refuse is told."""
        if self._closing.is_set():
            return
        with PneumaticboxClient(name="softhand_play_box") as self._box:
            self._tell("")
            while not self._closing.is_set():
                try:
                    self._jobs.get_nowait()()
                except Empty:
                    self._link.spin(0.5 * INTERVAL)
                except (PneumaticboxError, ValueError) as error:
                    self._tell(str(error))
                if self.paused != self._was_paused:
                    self._was_paused = self.paused
                    self._ask(SetBool, "sim/pause", SetBool.Request(data=self.paused))

    def _on(self, name: str, message: PoseStamped) -> None:
        place, turn = message.pose.position, message.pose.orientation
        self._seen[name] = (
            np.array([place.x, place.y, place.z]),
            np.array([turn.x, turn.y, turn.z, turn.w]),
        )

    def _on_air(self, message: JointState) -> None:
        self._air = np.array(message.position), np.array(message.effort)

    def _on_phase(self, message: String) -> None:
        self.phase = message.data

    def _on_joints(self, message: JointState) -> None:
        """An instant, when all that belongs to it has been heard."""
        time, now = seconds(message.header.stamp), self.now
        if now is not None and now.shots[-1].time <= time < now.shots[-1].time + DUE:
            return
        if self._air is None or "wrist" not in self._seen:
            return
        poses = (*self._seen["wrist"], *self._seen.get("object", ()))
        state = HandState(joint_orientations(np.array(message.position)), *poses)
        masses, pressures = self._air
        stage = self._stage_of(message.name) if now is None else now.stage
        volumes = stage.volumes(masses, pressures)
        shot = Shot(time, state, pressures, masses, volumes, NO_ARROWS, self.phase)
        if now is None or time < now.shots[-1].time:  # the simulator was reset
            self._begin(stage, shot)
        else:
            now.shots.append(shot)

    def _stage_of(self, joint_names: list[str]) -> Stage:
        segments = recorded_segments(self._hand.name, joint_names)
        layout = build_layout(self._hand, segments, load_model(None))
        return Stage(layout, self._object if self._scene.has_object else None, self._scene)
