"""The model file: base model, calibration and effects, the same for simulator, monitor and lab.

format: softhand-model/1
base: pneuflex                                  # or linear
calibration: {modulus_scale: {A: 1.03}}         # or a scalar; modulus [Pa] likewise, or `free`
springs: {bending: curvature, lateral: section, twist: 0.5}  # of the simulator's joints
effects:
  - {name: gravity, parameters: {mass_scale: 1.0}}
  - {name: actuator_scatter, where: {actuator: index}, parameters: {modulus_factor: 0.8}}
  - {name: my_effect, file: my_effect.py, parameters: {...}}
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from softhand_common.documents.yaml_document import DocumentError, Node, read_document
from softhand_model.data_files import find_document, shipped_names
from softhand_model.effects import Effect, effect_classes, effects_in_file
from softhand_model.effects.effect import BASES
from softhand_model.effects.hand import HandEffect
from softhand_model.effects.pipeline import in_order
from softhand_model.hand import plausible
from softhand_model.hand.joint_stiffness import SpringModel, read_springs

FORMAT = "softhand-model/1"
ALLOW_EFFECT_FILES = "--allow-effect-files"  # option of the commands that take a model file
ALLOW_HELP = "run the Python files that model files name; only for files that you trust"
FREE_VALUE = "free"
MODULUS_BOUNDS = (0.1, 10.0)  # the lab calibrates within 15 %; a file may hold more


CALIBRATION_BOUNDS = {
    "modulus_scale": MODULUS_BOUNDS,
    "modulus": (plausible.SHEAR_MODULUS.low, plausible.SHEAR_MODULUS.high),
}


@dataclass(frozen=True)
class Model:
    """A model: base, calibration, effects, and springs of simulated joints.

    base: name of the base model. calibration: numbers by name, or numbers by batch, specimen or
    direction below the name. `modulus` in it is the measured shear modulus [Pa] of the rubber,
    which takes the place of what actuators and specimens state; `modulus_scale` is a factor on
    either. effects: in the order of the file. std: standard errors of effect parameters, by effect
    name, as far as they are known. files: Python files of effects that are not built in, by effect
    name. springs: of the joints of simulated chains. free_modulus: whether the lab fits the modulus
    without bounds (`modulus: free`).
    """

    base: str = "pneuflex"
    calibration: Mapping[str, float | Mapping[str, float]] = field(default_factory=dict)
    effects: tuple[Effect, ...] = ()
    std: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    files: Mapping[str, Path] = field(default_factory=dict)
    springs: SpringModel = field(default_factory=SpringModel)
    free_modulus: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "effects", in_order(self.effects))

    def stage(self, name: str) -> tuple[Effect, ...]:
        """The effects of one stage, in the order of the file."""
        return tuple(effect for effect in self.effects if effect.stage == name)

    def modulus_scale(self, batch: str | None = None) -> float:
        """Factor [-] on the shear modulus of a batch; batch None: of the only batch.

        Raises ValueError for a batch that is not in the file, and for None if there are several
        batches.
        """
        scale = self.calibration.get("modulus_scale", 1.0)
        if not isinstance(scale, Mapping):
            return scale
        if batch is None and len(scale) == 1:
            return next(iter(scale.values()))
        if batch is None or batch not in scale:
            raise ValueError(
                f"calibration.modulus_scale: expected one of the batches {', '.join(scale)}, "
                f"got {batch}"
            )
        return scale[batch]

    def shear_modulus(self, stated: float, batch: str | None = None) -> float:
        """Shear modulus [Pa] of a part whose description states `stated` [Pa]: that of the
        calibration if it has one. `modulus_scale` is not applied. batch None: the only batch.

        >>> Model(calibration={"modulus": 50e3}).shear_modulus(67e3)
        50000.0
        """
        own = self.calibration.get("modulus", stated)
        if not isinstance(own, Mapping):
            return own
        if batch is None and len(own) == 1:
            return next(iter(own.values()))
        return own.get(batch or "", stated)

    def stiffened(self, factor: float) -> Model:
        """The model for a rubber with `factor` [-] times the shear modulus.

        >>> Model(calibration={"modulus_scale": 1.5}).stiffened(2.0).modulus_scale()
        3.0
        """
        scale = self.calibration.get("modulus_scale", 1.0)
        scaled = (
            {batch: factor * value for batch, value in scale.items()}
            if isinstance(scale, Mapping)
            else factor * scale
        )
        return replace(self, calibration={**self.calibration, "modulus_scale": scaled})

    @property
    def gravity_scale(self) -> float:
        """Weight of the actuators over the nominal one; 0 without the effect `gravity`."""
        scales = [
            effect.values["mass_scale"] for effect in self.effects if effect.name == "gravity"
        ]
        return scales[0] if scales else 0.0


def model_names() -> list[str]:
    """Names of the shipped model files."""
    return shipped_names("models")


def load_model(
    path: str | Path | None = None,
    own: Mapping[str, type[Effect]] | None = None,
    allow_effect_files: bool = False,
) -> Model:
    """Load a model by the path of its file or by the name of a shipped one; None: `gravity`, the
    one that the hands use.

    Args:
        path: path, name or None.
        own: effect classes by name that the file may use besides the built-in ones.
        allow_effect_files: whether to run Python files that the model names; they must lie in its
            folder.

    Raises ValueError for a file that is not valid; the message names file, key, what was expected
    and what came.

    >>> load_model().gravity_scale, load_model("base").gravity_scale
    (1.0, 0.0)
    """
    document = read_document(find_document(path or "gravity", "models", "model"), FORMAT)
    fields = document.fields(["format", "base"], ["calibration", "effects", "springs"])
    calibration, free = (
        _calibration(fields["calibration"]) if "calibration" in fields else ({}, False)
    )
    effects, std, files = (
        _effects(fields["effects"], own or {}, allow_effect_files)
        if "effects" in fields
        else ((), {}, {})
    )
    springs = read_springs(fields["springs"]) if "springs" in fields else SpringModel()
    return Model(fields["base"].choice(BASES), calibration, effects, std, files, springs, free)


def _calibration(node: Node) -> tuple[dict[str, float | Mapping[str, float]], bool]:
    """Numbers or mappings of numbers, those of the modulus within their bounds; and whether the
    modulus is free.
    """
    calibration: dict[str, float | Mapping[str, float]] = {}
    free = False
    for key, value in node.mapping().items():
        bounds = CALIBRATION_BOUNDS.get(key, (-float("inf"), float("inf")))
        if key == "modulus" and value.value == FREE_VALUE:
            free = True
            continue
        if isinstance(value.value, dict):
            if not value.value:
                raise value.error("at least one entry")
            calibration[key] = {
                name: entry.number(*bounds) for name, entry in value.mapping().items()
            }
        else:
            calibration[key] = value.number(*bounds)
    return calibration, free


def _effects(
    node: Node, own: Mapping[str, type[Effect]], allow_files: bool
) -> tuple[tuple[Effect, ...], dict[str, dict[str, float]], dict[str, Path]]:
    """Effects, standard errors of their parameters by name, and files of those that have one."""
    effects: dict[str, Effect] = {}
    std: dict[str, dict[str, float]] = {}
    files: dict[str, Path] = {}
    for entry in node.items():
        fields = entry.fields(["name"], ["file", "where", "parameters", "std"])
        name = fields["name"].text()
        place = _place(fields, {**effect_classes(), **own})
        name = place.name if place else name
        if name in effects:
            raise fields["name"].error("every effect once")
        foreign = "file" in fields and name not in own
        if foreign:
            files[name] = _file(fields["file"], allow_files)
        known = effects_in_file(files[name]) if foreign else {**effect_classes(), **own}
        effects[name] = _effect(entry, fields, known, place)
        if "std" in fields:
            std[name] = {
                key: value.number(low=0.0) for key, value in fields["std"].mapping().items()
            }
    return tuple(effects.values()), std, files


def _file(node: Node, allowed: bool) -> Path:
    """The Python file that an entry names; refuses one that must not be run."""
    folder = Path(node.file).parent
    path = folder / node.text()
    if not path.resolve().is_relative_to(folder.resolve()):
        raise node.error("a file in the model file's folder")
    if not allowed:
        raise node.error(
            f"no Python file; if you trust its code, allow it by {ALLOW_EFFECT_FILES}, by "
            "--effects FILE, or by a node's parameter allow_effect_files: true"
        )
    return path


def _place(
    fields: Mapping[str, Node], known: Mapping[str, type[Effect]]
) -> type[HandEffect] | None:
    """The class of an effect of a hand at its place; None for any other effect."""
    effect = known.get(fields["name"].text())
    if effect is None or not issubclass(effect, HandEffect):
        if "where" in fields:
            raise fields["where"].error("no key `where`, as only effects of a hand have a place")
        return None
    stated = fields["where"].mapping() if "where" in fields else {}
    try:
        return effect.at(**{key: node.text() for key, node in stated.items()})
    except ValueError as reason:
        raise DocumentError(f"{fields['name'].place}: {reason}") from reason


def _effect(
    entry: Node,
    fields: dict[str, Node],
    known: Mapping[str, type[Effect]],
    place: type[Effect] | None,
) -> Effect:
    kind = place or known[fields["name"].choice(known)]
    values = fields["parameters"].mapping() if "parameters" in fields else {}
    try:
        return kind(**{key: value.value for key, value in values.items()})
    except ValueError as reason:
        raise DocumentError(f"{entry.place}: {reason}") from reason
