"""States of a grasp in equal steps of time, for a film, from a trial or a bag."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grasp_strategies.in_process_scene import InProcessScene
from pneuflex_sim.pictures.render import HandState, Renderer
from pneuflex_sim.scene.scenes import SceneDescription
from pneuflex_sim.simulation import Simulation
from softhand_bringup.bags.reading import Bag, latest_index
from softhand_bringup.figures import (
    JOINTS_TOPIC,
    OBJECT_TOPIC,
    PHASE_MARGIN,
    PHASE_TOPIC,
    STATE_TOPIC,
    phases,
    recorded_segments,
    recorded_states,
)
from softhand_common.numerics.arrays import Array
from softhand_trials.trials import Placement, TrialSettings, run_in_process, started_scene

NEAR_WRIST = 0.40  # from wrist to object [m]; an object at the fingertips is nearer


@dataclass(frozen=True)
class Recording:
    """States every `interval` [s] of simulated time, their gauge pressures (k, channels) [Pa], the
    renderer, and the result of the grasp in words.
    """

    states: list[HandState]
    pressures: Array
    interval: float
    renderer: Renderer
    ending: str

    @property
    def path(self) -> Array:
        """Positions (k, 3) [m] of the wrist, and of the object at the start and while it is near
        the wrist, which leaves out an object that is thrown away.
        """
        wrist = np.array([state.wrist_position for state in self.states])
        thing = np.array([state.object_position for state in self.states])
        near = np.linalg.norm(thing - wrist, axis=1) < NEAR_WRIST
        near[0] = True
        return np.concatenate([wrist, thing[near]])


class FilmedScene(InProcessScene):
    """A scene that records its state every `interval` [s] of simulated time.

    The simulation is the same, bit for bit, as without recording.
    """

    def __init__(self, simulation: Simulation, interval: float) -> None:
        super().__init__(simulation)
        self.interval = interval
        self.states: list[HandState] = []
        self.pressures: list[Array] = []
        self._record()

    def step(self, duration: float) -> None:
        """Simulate `duration` [s] as an `InProcessScene` does, and record the due states."""
        size = self.simulation.step_size
        for _ in range(max(1, round(duration / size))):
            super().step(size)
            if self.time > len(self.states) * self.interval - 0.5 * size:
                self._record()

    def _record(self) -> None:
        """Append a copy of the current state."""
        simulation = self.simulation
        seen = (simulation.bodies.q, *simulation.wrist_pose(), *simulation.object_pose())
        self.states.append(HandState(*(np.array(part) for part in seen)))
        self.pressures.append(np.array(simulation.pressures()))


def film_trial(settings: TrialSettings, placement: Placement, interval: float) -> Recording:
    """Run a trial and record its states every `interval` [s].

    Args:
        settings: settings of the trial.
        placement: placement of the trial's object.
        interval: simulated time between states [s], at least a physics step.

    Raises:
        ValueError: a name does not exist, or `interval` is shorter than the step.
    """
    if interval < settings.step * (1 - 1e-9):
        raise ValueError(
            f"time between frames: expected at least the step, {settings.step:g} s, "
            f"got {interval:g} s"
        )
    started = started_scene(settings)
    scene = FilmedScene(started.place(placement).simulation, interval)
    result = run_in_process(scene, started.strategy, settings.options)
    simulation = scene.simulation
    renderer = Renderer(
        simulation.hand, settings.object, simulation.scene, segments=settings.segments
    )
    ending = f"{result.outcome}: {result.reason}"
    return Recording(scene.states, np.array(scene.pressures), interval, renderer, ending)


def film_bag(
    folder: Path, interval: float, hand: str, object_name: str, scene: str | SceneDescription
) -> Recording:
    """Read states every `interval` [s] from the first to the last phase of a grasp, or of the whole
    bag if it has no phases. Hand, object and scene must be those of the recording.

    Raises:
        ValueError: there is no such bag, it lacks a topic, or another hand was recorded.
    """
    if not (folder / "metadata.yaml").exists():
        raise ValueError(f"{folder}: expected a bag with its metadata.yaml, got none")
    with Bag(folder) as bag:
        joints = bag.joints(JOINTS_TOPIC)
        start, end = max(joints.time[0], bag.poses(OBJECT_TOPIC).time[0]), joints.time[-1]
        marks = phases(bag.texts(PHASE_TOPIC), end)
        if marks:
            start, end = max(start, marks[0].start - PHASE_MARGIN), min(end, marks[-1].end)
        times = np.arange(start, end + 1e-9, interval)
        states, air = recorded_states(bag, times), bag.joints(STATE_TOPIC)
    segments = recorded_segments(hand, joints.names)
    pressures = air.effort[latest_index(air.time, times)]
    renderer = Renderer(hand, object_name, scene, segments)
    return Recording(states, pressures, interval, renderer, "from a bag")
