"""Physical effects beyond the base model: one class each, one file per family, found by name.

The modules of this package are searched for subclasses of `Effect`; a user's file is searched the
same way. An effect derives from the class of its stage.
"""

from softhand_common.numerics.compiled import compiled
from softhand_model.effects.catalogue import effect_classes
from softhand_model.effects.effect import STAGES, Effect, Parameter
from softhand_model.effects.kernel import Kernel, Trial
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
    "Kernel",
    "LoadEffect",
    "OutputEffect",
    "Parameter",
    "SectionShape",
    "StructureEffect",
    "Trial",
    "compiled",
    "effect_classes",
    "effects_in_file",
]
