"""The tab `Scene`: hand, surroundings, object, mass, friction, and the model with its effects."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import viser
import yaml

from grasp_strategies.trials import Placement
from pneuflex_sim.scene.objects import load_objects
from pneuflex_sim.scene.scenes import LEAST_INCLINATION, MOST_INCLINATION, load_scene, load_scenes
from softhand_model.documents.yaml_document import find_document
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import hand_names
from softhand_model.model_file import model_names
from softhand_play.board import Board
from softhand_play.shots import World

OF_STRATEGY = "of the strategy"
NO_EFFECT, BASE = "none", "gravity"
SHOWN = ("input", "load", "elastic", "structure")  # stages of effects that bend a finger
FACTORS = (0.25, 4.0, 0.05)  # on mass and friction
OFFSETS = (-0.2, 0.2, 0.005)  # of the object [m]


class SceneTab:
    """Chooses the world of a page's player."""

    def __init__(self, page: Board, tab: viser.GuiTabHandle) -> None:
        self._page, gui = page, page.server.gui
        self._folder = tempfile.TemporaryDirectory(prefix="softhand-play-")
        self._made: set[str | None] = set()  # model files with an effect on top
        with tab:
            self.hand = gui.add_dropdown("hand", (OF_STRATEGY, *hand_names()))
            self.scene = gui.add_dropdown("scene", tuple(load_scenes()))
            self.inclination = gui.add_slider(
                "incline of the wall [deg]", LEAST_INCLINATION, MOST_INCLINATION, 5.0, 90.0
            )
            self.object = gui.add_dropdown("object", tuple(load_objects()))
            self.x = gui.add_slider("object x [m]", *OFFSETS, 0.0)
            self.y = gui.add_slider("object y [m]", *OFFSETS, 0.0)
            self.mass = gui.add_slider("mass (factor)", *FACTORS, 1.0)
            self.friction = gui.add_slider("friction (factor)", *FACTORS, 1.0)
            self.model = gui.add_dropdown("model", tuple(model_names()), initial_value=BASE)
            self.effect = gui.add_dropdown("effect on top", (NO_EFFECT, *_effects()))
            self.share = gui.add_slider(
                "its strength", 0.0, 1.0, 0.05, 0.8, hint="within its usual range"
            )
            build = gui.add_button("build this world")
        self.scene.on_update(lambda _: self._show_needed())
        self.effect.on_update(lambda _: self._show_needed())
        build.on_click(lambda _: page.attempt(lambda: page.player.play(self.wanted())))

    def _show_needed(self) -> None:
        """Of what there is not, nothing can be chosen."""
        self.inclination.visible = load_scene(self.scene.value).wall is not None
        self.share.visible = self.effect.value != NO_EFFECT

    def stage(self) -> None:
        """Show what is played."""
        world = self._page.player.world
        settings, placement = world.settings, world.placement
        _choose(self.hand, settings.hand or OF_STRATEGY)
        _choose(self.scene, settings.scene)
        _choose(self.object, settings.object)
        if settings.model not in self._made:
            _choose(self.model, settings.model or BASE)
        wall = load_scene(settings.scene).inclined(settings.wall_inclination).wall
        if wall is not None:
            self.inclination.value = wall.inclination
        self.x.value, self.y.value = placement.offset
        self.mass.value, self.friction.value = placement.mass_scale, placement.friction_scale
        self._show_needed()

    def wanted(self) -> World:
        """The world that is chosen; raises ValueError for what cannot be."""
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
        """The model, with an effect on top as a file of its own."""
        name, effect = self.model.value, self.effect.value
        if effect == NO_EFFECT:
            return None if name == BASE else name
        base = find_document(name, "models", "model")
        content = yaml.safe_load(base.read_text())
        share, known = self.share.value, effect_classes()[effect].parameters
        values = {parameter.name: parameter.usual(share) for parameter in known}
        others = [each for each in content.get("effects", []) if each["name"] != effect]
        content["effects"] = [*others, {"name": effect, "parameters": values}]
        path = Path(self._folder.name) / f"{base.stem}_{effect}_{share:.2f}.yaml"
        path.write_text(yaml.safe_dump(content))
        self._made.add(str(path))
        return str(path)


def _choose(dropdown: viser.GuiDropdownHandle, value: Any) -> None:
    """Show a value, which may be a file that is none of the shipped names."""
    if value not in dropdown.options:
        dropdown.options = (*dropdown.options, value)
    dropdown.value = value


def _effects() -> list[str]:
    """Names of the effects that the simulator knows and that bend a finger otherwise."""
    return sorted(
        name
        for name, kind in effect_classes().items()
        if kind.stage in SHOWN and kind.physical and not kind.not_simulated and not kind.axes
    )
