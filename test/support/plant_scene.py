"""The scene of a strategy in process, with the plant's valves and the driver's box in place of
imposed air: what a grasp over ROS has, without the nodes.
"""

from dataclasses import replace

import numpy as np

from grasp_strategies.in_process_scene import InProcessScene
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.hand.hand import load_hand


class PlantScene(InProcessScene):
    """Takes air masses; a sample of the sensors and an answer of the box each physics step."""

    def __init__(self, simulation):
        super().__init__(simulation)
        name = simulation.config.hand
        hand = load_hand(name)
        settings = BoxSettings(
            channels=hand.channels,
            rest_volumes=tuple(hand.rest_volumes().tolist()),
            pressure_limits=tuple(hand.max_pressures().tolist()),
            control_modes=("mass",) * len(hand.channels),
            volume_model="hand",
            hand=name,
        )
        self.box = PneumaticBox(settings, load_calibration(None, len(hand.channels)))
        self.step(0.2)  # until the box has averaged its sensors

    def command_air(self, masses):
        point = TrajectoryPoint(0.0, positions=masses.tolist())
        self.box.command(self.channels, [point], 0.0, self.time)

    def step(self, duration):
        simulation = self.simulation
        for _ in range(max(1, round(duration / simulation.step_size))):
            valves = self.box.on_sample(simulation.time, simulation.read_sensors())
            simulation.step(np.array(valves, float))

    def observe(self):
        mass, pressure = self.box.observer.mass.copy(), self.box.pressures.copy()
        return replace(super().observe(), air_mass=mass, pressure=pressure)
