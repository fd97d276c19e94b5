"""What is simulated: hand, object, scene, model and friction, by name, by file or as they are."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from pneuflex_sim.hand.collision import PIECES, check_kind
from pneuflex_sim.hand.wrist import WristParameters
from pneuflex_sim.scene.friction import FrictionTable, load_friction
from pneuflex_sim.scene.objects import ObjectDescription, load_object
from pneuflex_sim.scene.scenes import SceneDescription, load_scene
from pneuflex_sim.world import SolverSettings
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.model_file import Model, load_model

LARGEST_STEP = 0.05  # [s]; contacts are missed there, see docs/understand/simulator.md


@dataclass(frozen=True)
class SimulationConfig:
    """What is simulated: names or files of hand, object, scene and model, or their descriptions,
    step [s], segments an actuator, seed, offsets [m], collision shapes of the links (`pieces` along
    the outline, or `boxes`), inclination of the wall [deg] (None: the scene's),
    table or file of friction (None: the shipped one), whether neighbouring fingers touch, whether
    the Python files of effects that the model names are run. `object_rpy` [rad] is how the object
    rests (None: as it is described), `object_yaw` [rad] turns it about the vertical,
    `friction_scale` is a factor on the friction of all pairs, `modulus_scale` one on the shear
    modulus of the hand's rubber.

    Raises ValueError for a step, a number of segments, a scale or shapes that cannot be used.
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
    modulus_scale: float = 1.0
    collision: str = PIECES
    wrist: WristParameters = field(default_factory=WristParameters)
    solver: SolverSettings = field(default_factory=SolverSettings)
    wall_inclination: float | None = None
    friction: FrictionTable | str | Path | None = None
    finger_contact: bool = False
    allow_effect_files: bool = False

    def __post_init__(self) -> None:
        if not 1e-4 <= self.step <= LARGEST_STEP:
            raise ValueError(f"step: expected 0.0001 to {LARGEST_STEP} s, got {self.step}")
        if self.segments < 1:
            raise ValueError(f"segments: expected 1 or more, got {self.segments}")
        if not 2 <= len(self.object_offset) <= 3 or not np.isfinite(self.object_offset).all():
            raise ValueError(
                f"object_offset: expected two or three finite numbers, got {self.object_offset}"
            )
        check_kind(self.collision)
        if not np.isfinite(self.object_yaw):
            raise ValueError(f"object_yaw: expected a finite number, got {self.object_yaw}")
        for name in ("object_mass_scale", "friction_scale", "modulus_scale"):
            if not 0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name}: expected a positive number, got {getattr(self, name)}")

    def described_hand(self) -> HandDescription:
        """The hand."""
        return self.hand if isinstance(self.hand, HandDescription) else load_hand(self.hand)

    def friction_table(self) -> FrictionTable:
        """Friction of all pairs of materials."""
        found = self.friction
        return found if isinstance(found, FrictionTable) else load_friction(found)

    def described_scene(self, friction: FrictionTable) -> SceneDescription:
        """The scene, its wall inclined as asked for."""
        found = self.scene
        scene = found if isinstance(found, SceneDescription) else load_scene(found, friction)
        return scene.inclined(self.wall_inclination)

    def described_object(self, friction: FrictionTable) -> ObjectDescription:
        """The object, resting as asked for."""
        found = self.object
        if not isinstance(found, ObjectDescription):
            found = load_object(found, friction)
        return found if self.object_rpy is None else replace(found, rpy=tuple(self.object_rpy))

    def described_model(self) -> Model:
        """The model, its rubber as stiff as asked for; raises ValueError for one that the simulator
        does not have.
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
