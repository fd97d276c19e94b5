"""What candidates achieve on noise alone: the largest improvement that any of them finds in it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from model_lab.candidates import Signature
from model_lab.spectrum import Spectrum

Array = NDArray[np.float64]

DRAWS = 2000


def null_maxima(signatures: Sequence[Signature], spectrum: Spectrum, seed: int) -> Array:
    """Largest fall of the deviance over all candidates (draws,), sorted, in sets of mere noise.

    Noise of every band is drawn with a level that is itself only known from that band's
    coefficients. Each candidate is represented by its signatures, scaled as suits it best.
    """
    changes = [found.change[found.size > 0.0] for found in signatures]
    stacked = np.concatenate([change for change in changes if len(change)] or [np.zeros((0, 1))])
    if not len(stacked):
        return np.zeros(DRAWS)
    stacked = stacked / np.linalg.norm(stacked, axis=1, keepdims=True)
    random = np.random.default_rng(seed)
    drawn = np.zeros((DRAWS, len(stacked)))
    for band, count in enumerate(spectrum.counts()):
        part = stacked[:, spectrum.bands == band]
        level, vectors = np.linalg.eigh(part @ part.T)
        root = vectors * np.sqrt(np.maximum(level, 0.0))
        spread = np.sqrt(count / random.chisquare(count, DRAWS))
        drawn += spread[:, None] * (random.standard_normal((DRAWS, len(root))) @ root.T)
    return np.sort(np.max(drawn**2, axis=1))


def p_value(maxima: Array, improvement: float) -> float:
    """Share of noise sets in which some candidate improves as much; one of them at least."""
    beyond = len(maxima) - int(np.searchsorted(maxima, improvement))
    return (beyond + 1) / (len(maxima) + 1)
