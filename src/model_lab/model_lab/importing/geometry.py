"""The specimen of imported files: a finger of a hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model_lab.importing.runs import ImportedRun
from model_lab.measurements.specimens import TAPER_POINTS
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.hand import HandDescription, load_hand
from softhand_model.hand.profile import Profile

STRAIGHT = 1e-9  # [m] by which a size that does not vary may vary


def finger_of_hand(hand: str, runs: Sequence[ImportedRun]) -> tuple[str, dict[str, object]]:
    """(name, entry in experiment.yaml) of a specimen that is a finger of a hand.

    hand: name or file of the hand, with `:FINGER` after it if its fingers differ and no file name
    contains the name of one. Raises DocumentError if no finger, or several different ones, may be
    meant.
    """
    name, _, finger = hand.partition(":")
    chains = _fingers(load_hand(name))
    named = [key for key in chains if any(key in str(run.files[0]) for run in runs)]
    wanted = [finger] if finger else named if len(named) == 1 else list(chains)
    entries = [_entry(chains[key]) for key in wanted if key in chains]
    if not entries or any(entry != entries[0] for entry in entries):
        raise DocumentError(
            f"--hand {hand}: expected the finger that was measured, got {finger or 'none'}; "
            f"write --hand {name}:FINGER with one of {listed(chains)}"
        )
    return wanted[0], entries[0]


def _fingers(hand: HandDescription) -> dict[str, Actuator]:
    """Actuators of chains of a single one, by the name of the chain."""
    return {
        chain.name: next(iter(chain.actuators.values()))
        for chain in hand.chains
        if len(chain.actuators) == 1 and not chain.turn
    }


def _entry(actuator: Actuator) -> dict[str, object]:
    """The entry of a specimen in experiment.yaml."""
    sizes = ("height", "width", "wall", "side_wall")
    profiles = {name: _profile(getattr(actuator, name), actuator.length) for name in sizes}
    return {
        "length": actuator.length,
        **profiles,
        "shear_modulus": actuator.shear_modulus,
        "mass": actuator.mass,
    }


def _profile(profile: Profile, length: float) -> float | list[list[float]]:
    x = np.linspace(0.0, length, TAPER_POINTS)
    values = np.asarray(profile(x), float) * np.ones(len(x))
    if np.ptp(values) < STRAIGHT:
        return float(values[0])
    return [
        [round(float(at), 9), round(float(value), 9)] for at, value in zip(x, values, strict=True)
    ]
