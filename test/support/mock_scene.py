"""A scene whose behaviour is known in closed form, for tests of what runs on scenes."""

import numpy as np

from grasp_strategies.pose import Pose
from grasp_strategies.scene import Observation, SceneError

CHANNELS = ("a", "b", "c", "d")
HAND = frozenset({"thumb", "index", "middle", "ring", "little", "palm", "palm_plate"})
REST_HEIGHT = 0.0325  # of the object's centre on the table [m]
PRESSURE_OF_AIR = 3e9  # [Pa/kg]
GRIP = 1e-5  # every channel above this holds the object [kg]


class MockScene:
    """The wrist goes where it is told at once, the air too unless `air_rate` [kg/s] limits it.

    A table under the wrist at `touch_height` [m] pushes back with `table_stiffness` [N/m]. While
    all channels hold more than GRIP the object hangs on the wrist, sinking in the wrist's frame by
    `slip_speed` [m/s] of its x axis. `drop_at` [s] is when it falls, `stick` holds it to the table,
    `also_touching` are bodies that touch it beside the hand, `break_at` [s] when the scene fails.
    """

    channels = CHANNELS
    hand_bodies = HAND

    def __init__(
        self,
        *,
        slip_speed=0.0,
        air_rate=np.inf,
        touch_height=-np.inf,
        drop_at=np.inf,
        also_touching=frozenset(),
        stick=False,
        break_at=np.inf,
        object_orientation=(0.0, 0.0, 0.0, 1.0),
    ):
        self.slip_speed, self.air_rate, self.touch_height = slip_speed, air_rate, touch_height
        self.drop_at, self.also_touching, self.stick = drop_at, frozenset(also_touching), stick
        self.break_at = break_at
        self.table_stiffness = 1000.0
        self.time = 0.0
        self.wrist = Pose(np.array([0.0, 0.0, 0.4]), np.array([0.0, 0.0, 0.0, 1.0]))
        self.object_position = np.array([0.02, -0.01, REST_HEIGHT])
        self.object_orientation = np.array(object_orientation)
        self.air = np.zeros(len(CHANNELS))
        self.air_goal = self.air.copy()
        self.held_at = None
        self.vented = 0
        self.wrist_commands, self.air_commands, self.pressure_commands = [], [], []
        self.object_commands = []
        self.on_step = lambda: None

    def command_wrist(self, position, orientation):
        self.wrist_commands.append((self.time, np.array(position), np.array(orientation)))
        self.wrist = Pose(np.array(position), np.array(orientation))

    def command_air(self, masses):
        self.air_commands.append((self.time, np.array(masses)))
        self.air_goal = np.where(np.isnan(masses), self.air_goal, masses)

    def command_pressure(self, pressures):
        self.pressure_commands.append((self.time, np.array(pressures)))
        masses = np.array(pressures) / PRESSURE_OF_AIR
        self.air_goal = np.where(np.isnan(masses), self.air_goal, masses)

    def hold_object(self, position, orientation):
        self.object_commands.append((self.time, tuple(position), tuple(orientation)))

    def release_object(self, duration):
        self.object_commands.append((self.time, duration))

    def vent(self):
        self.vented += 1
        self.air_goal = np.zeros(len(CHANNELS))

    def step(self, duration):
        self.time = round(self.time + duration, 9)
        if self.time > self.break_at:
            raise SceneError("the mock broke as asked")
        most = self.air_rate * duration
        self.air = self.air + np.clip(self.air_goal - self.air, -most, most)
        self._move_object()
        self.on_step()

    @property
    def grips(self):
        return bool((self.air > GRIP).all()) and self.time < self.drop_at

    def _move_object(self):
        if not self.grips or self.stick:
            self.held_at = None
            if not self.stick:
                self.object_position[2] = REST_HEIGHT
            return
        if self.held_at is None:
            self.held_at = self.wrist.locate(self.object_position)
            self.held_since = self.time
        sunk = self.slip_speed * (self.time - self.held_since)
        in_wrist = self.held_at + [sunk, 0.0, 0.0]
        self.object_position = self.wrist.compose(Pose(in_wrist, np.array([0, 0, 0, 1.0]))).position

    @property
    def touching(self):
        bodies = set(self.also_touching)
        bodies |= {"thumb", "index"} if self.grips else set()
        bodies |= {"table"} if abs(self.object_position[2] - REST_HEIGHT) < 1e-9 else set()
        return frozenset(bodies)

    def observe(self):
        push = self.table_stiffness * max(0.0, self.touch_height - self.wrist.position[2])
        return Observation(
            self.time,
            self.wrist.position,
            self.wrist.orientation,
            np.array([0.0, 0.0, push]),
            self.object_position.copy(),
            self.object_orientation,
            self.air.copy(),
            self.air * PRESSURE_OF_AIR,
            self.touching,
        )
