"""Configuration of a simulation: hand, object, scene, model and friction, by name, file or
object.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from pneuflex_sim.engines import check_engine, default_engine
from pneuflex_sim.hand.collision import HULL_PIECES, check_kind
from pneuflex_sim.hand.wrist import WristParameters
from pneuflex_sim.scene.friction import FrictionTable, load_friction
from pneuflex_sim.scene.objects import ObjectDescription, load_object
from pneuflex_sim.scene.scenes import SceneDescription, load_scene
from pneuflex_sim.world import SolverSettings
from softhand_model.effects.hand import friction_factor
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.model_file import Model, load_model

SCALE_FIELDS = ("object_mass_scale", "friction_scale", "rubber_friction_scale", "modulus_scale")
MAX_STEP_SIZE = 0.05  # [s]; contacts are missed there, see docs/understand/simulator-steps.md


@dataclass(frozen=True)
class SimulationConfig:
    """Configuration of a simulation.

    Attributes:
        hand, object, scene, model: each a name, a file or a description.
        step: physics step [s].
        segments: number of segments per actuator.
        seed: seed of the random errors of sensors and valves.
        gui: whether to open PyBullet's window.
        engine: `pybullet` or `mujoco`; by default PyBullet if it is installed, else MuJoCo.
        object_offset: (2,) or (3,) offset [m] of the object from its place in the scene.
        object_mass_scale: factor on the object's mass [-].
        object_rpy: orientation in which the object rests [rad]; None: as it is described.
        object_yaw: turn of the object about the vertical [rad].
        friction_scale: factor on the friction of all pairs [-].
        rubber_friction_scale: factor on the friction of the hand's rubber with anything else [-].
        modulus_scale: factor on the shear modulus of the hand's rubber [-].
        collision: shapes of the links, `pieces` along the outline or `boxes`.
        wrist, solver: parameters of wrist and contact solver.
        wall_inclination: inclination of the wall [deg]; None: that of the scene.
        friction: table of friction, or its file; None: the shipped one.
        finger_contact: whether neighbouring fingers touch each other.
        allow_effect_files: whether to run the Python files of effects that the model names.

    Raises:
        ValueError: a step, a number of segments, a scale, an offset or a shape is unusable.
    """

    hand: str | HandDescription = "rbo_hand_2"
    object: str | ObjectDescription = "cylinder"
    scene: str | SceneDescription = "table"
    model: str | Path | Model | None = None
    step: float = 0.001
    segments: int = 5
    seed: int = 0
    gui: bool = False
    object_offset: tuple[float, ...] = (0.0, 0.0)
    object_mass_scale: float = 1.0
    object_rpy: tuple[float, float, float] | None = None
    object_yaw: float = 0.0
    friction_scale: float = 1.0
    rubber_friction_scale: float = 1.0
    modulus_scale: float = 1.0
    collision: str = HULL_PIECES
    wrist: WristParameters = field(default_factory=WristParameters)
    solver: SolverSettings = field(default_factory=SolverSettings)
    wall_inclination: float | None = None
    friction: FrictionTable | str | Path | None = None
    finger_contact: bool = False
    allow_effect_files: bool = False
    engine: str = field(default_factory=default_engine)

    def __post_init__(self) -> None:
        if not 1e-4 <= self.step <= MAX_STEP_SIZE:
            raise ValueError(f"step: expected 0.0001 to {MAX_STEP_SIZE} s, got {self.step}")
        if self.segments < 1:
            raise ValueError(f"segments: expected 1 or more, got {self.segments}")
        if not 2 <= len(self.object_offset) <= 3 or not np.isfinite(self.object_offset).all():
            raise ValueError(
                f"object_offset: expected two or three finite numbers, got {self.object_offset}"
            )
        check_kind(self.collision)
        check_engine(self.engine)
        if not np.isfinite(self.object_yaw):
            raise ValueError(f"object_yaw: expected a finite number, got {self.object_yaw}")
        for name in SCALE_FIELDS:
            if not 0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name}: expected a positive number, got {getattr(self, name)}")

    def described_hand(self) -> HandDescription:
        """The hand's description, loaded if `hand` is a name or a file."""
        return self.hand if isinstance(self.hand, HandDescription) else load_hand(self.hand)

    def friction_table(self, model: Model) -> FrictionTable:
        """Friction of all pairs of materials, that of the rubber scaled by `rubber_friction_scale`
        and by the effects of the model.
        """
        found = self.friction
        table = found if isinstance(found, FrictionTable) else load_friction(found)
        return table.rubber_scaled(self.rubber_friction_scale * friction_factor(model.effects))

    def described_scene(self, friction: FrictionTable) -> SceneDescription:
        """The scene's description, with its wall at `wall_inclination`."""
        found = self.scene
        scene = found if isinstance(found, SceneDescription) else load_scene(found, friction)
        return scene.inclined(self.wall_inclination)

    def described_object(self, friction: FrictionTable) -> ObjectDescription:
        """The object's description, resting at `object_rpy`."""
        found = self.object
        if not isinstance(found, ObjectDescription):
            found = load_object(found, friction)
        return found if self.object_rpy is None else replace(found, rpy=tuple(self.object_rpy))

    def described_model(self) -> Model:
        """The model, its shear modulus scaled by `modulus_scale`; raises ValueError for a model
        that the simulator cannot simulate.
        """
        model = self.model
        if not isinstance(model, Model):
            model = load_model(model, allow_effect_files=self.allow_effect_files)
        if model.base != "pneuflex":
            raise ValueError(f"{self.model}: base: expected pneuflex, got {model.base}")
        for effect in model.effects:
            if effect.not_simulated:
                raise ValueError(
                    f"{self.model_name}: effects: {effect.name}: {effect.not_simulated}"
                )
        return model.stiffened(self.modulus_scale)

    @property
    def model_name(self) -> str:
        """Name or file of the model in a sentence."""
        return "model" if isinstance(self.model, Model) else str(self.model)
