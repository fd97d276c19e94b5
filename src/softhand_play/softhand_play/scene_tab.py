"""The tab `Scene`: choice of hand, scene, object, mass, friction and model with effects."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import viser
import yaml

from pneuflex_sim.scene.objects import load_objects
from pneuflex_sim.scene.scenes import MAX_INCLINATION, MIN_INCLINATION, load_scene, load_scenes
from softhand_common.documents.output_file import write_file
from softhand_model.data_files import find_document
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import hand_names
from softhand_model.model_file import model_names
from softhand_play.frames import World
from softhand_play.page_context import PageContext
from softhand_trials.trials import Placement

OF_STRATEGY = "of the strategy"
NO_EFFECT, BASE_MODEL = "none", "gravity"
BENDING_STAGES = ("input", "load", "elastic", "structure")  # stages of effects that bend a finger
FACTOR_RANGE = (0.25, 4.0, 0.05)  # lowest, highest, step: of mass and friction
OFFSET_RANGE = (-0.2, 0.2, 0.005)  # likewise, of the object [m]


class SceneTab:
    """The tab that chooses the world that the page's player simulates."""

    def __init__(self, page: PageContext, tab: viser.GuiTabHandle) -> None:
        self._page, gui = page, page.server.gui
        self._folder = tempfile.TemporaryDirectory(prefix="softhand-play-")
        self._made: set[str | None] = set()  # model files with an added effect
        with tab:
            self.hand = gui.add_dropdown("hand", (OF_STRATEGY, *hand_names()))
            self.scene = gui.add_dropdown("scene", tuple(load_scenes()))
            self.inclination = gui.add_slider(
                "incline of the wall [deg]", MIN_INCLINATION, MAX_INCLINATION, 5.0, 90.0
            )
            self.object = gui.add_dropdown("object", tuple(load_objects()))
            self.x = gui.add_slider("object x [m]", *OFFSET_RANGE, 0.0)
            self.y = gui.add_slider("object y [m]", *OFFSET_RANGE, 0.0)
            self.mass = gui.add_slider("mass (factor)", *FACTOR_RANGE, 1.0)
            self.friction = gui.add_slider("friction (factor)", *FACTOR_RANGE, 1.0)
            self.model = gui.add_dropdown("model", tuple(model_names()), initial_value=BASE_MODEL)
            self.effect = gui.add_dropdown("effect on top", (NO_EFFECT, *_effects()))
            self.share = gui.add_slider(
                "its strength", 0.0, 1.0, 0.05, 0.8, hint="within its usual range"
            )
            build = gui.add_button("build this world")
        self.scene.on_update(lambda _: self._show_needed())
        self.effect.on_update(lambda _: self._show_needed())
        build.on_click(lambda _: page.attempt(lambda: page.player.play(self.wanted())))

    def _show_needed(self) -> None:
        """Show only the controls that matter for the chosen scene and effect."""
        self.inclination.visible = load_scene(self.scene.value).wall is not None
        self.share.visible = self.effect.value != NO_EFFECT

    def show_world(self) -> None:
        """Set the controls to the simulated world."""
        world = self._page.player.world
        settings, placement = world.settings, world.placement
        _choose(self.hand, settings.hand or OF_STRATEGY)
        _choose(self.scene, settings.scene)
        _choose(self.object, settings.object)
        if settings.model not in self._made:
            _choose(self.model, settings.model or BASE_MODEL)
        wall = load_scene(settings.scene).inclined(settings.wall_inclination).wall
        if wall is not None:
            self.inclination.value = wall.inclination
        self.x.value, self.y.value = placement.offset
        self.mass.value, self.friction.value = placement.mass_scale, placement.friction_scale
        self._show_needed()

    def wanted(self) -> World:
        """The chosen world; raises ValueError for a scene or a model that cannot be loaded."""
        world = self._page.player.world
        scene, hand = self.scene.value, self.hand.value
        walled = load_scene(scene).wall is not None
        settings = replace(
            world.settings,
            hand=None if hand == OF_STRATEGY else hand,
            scene=scene,
            object=self.object.value,
            model=self._model_file(),
            wall_inclination=self.inclination.value if walled else None,
        )
        offset = (self.x.value, self.y.value)
        placed = Placement(offset, self.mass.value, 0.0, self.friction.value)
        return World(settings, placed)

    def _model_file(self) -> str | None:
        """Name of the model, or path of a new model file with the added effect; None: the default
        model.
        """
        name, effect = self.model.value, self.effect.value
        if effect == NO_EFFECT:
            return None if name == BASE_MODEL else name
        base = find_document(name, "models", "model")
        content = yaml.safe_load(base.read_text())
        share, known = self.share.value, effect_classes()[effect].parameters
        values = {parameter.name: parameter.usual(share) for parameter in known}
        others = [each for each in content.get("effects", []) if each["name"] != effect]
        content["effects"] = [*others, {"name": effect, "parameters": values}]
        path = Path(self._folder.name) / f"{base.stem}_{effect}_{share:.2f}.yaml"
        write_file(path, yaml.safe_dump(content))
        self._made.add(str(path))
        return str(path)


def _choose(dropdown: viser.GuiDropdownHandle, value: Any) -> None:
    """Select a value, which becomes an option if it is none of the shipped names."""
    if value not in dropdown.options:
        dropdown.options = (*dropdown.options, value)
    dropdown.value = value


def _effects() -> list[str]:
    """Names of the effects that the simulator supports and that change the bending of a finger."""
    return sorted(
        name
        for name, kind in effect_classes().items()
        if kind.stage in BENDING_STAGES
        and kind.physical
        and not kind.not_simulated
        and not kind.axes
    )
