"""Physical effects beyond the base model: one class each, a file a family, found by name.

The modules of this package are searched for subclasses of `Effect`; a user's file is searched the
same way. An effect derives from the class of its stage.
"""

from softhand_model.effects.catalogue import effect_classes
from softhand_model.effects.effect import STAGES, Effect, Parameter
from softhand_model.effects.own.own_file import effects_in_file
from softhand_model.effects.stages import (
    ElasticEffect,
    FlowEffect,
    InputEffect,
    LoadEffect,
    OutputEffect,
    SectionShape,
    StructureEffect,
)

__all__ = [
    "STAGES",
    "Effect",
    "ElasticEffect",
    "FlowEffect",
    "InputEffect",
    "LoadEffect",
    "OutputEffect",
    "Parameter",
    "SectionShape",
    "StructureEffect",
    "effect_classes",
    "effects_in_file",
]
