"""Physical effects beyond the base model: one class in one file each, found by name.

The modules of this package are searched for subclasses of `Effect`; a user's file is searched the
same way.
"""

from softhand_model.effects.discovery import effect_classes, effects_in_file
from softhand_model.effects.effect import STAGES, Effect, Parameter

__all__ = ["STAGES", "Effect", "Parameter", "effect_classes", "effects_in_file"]
