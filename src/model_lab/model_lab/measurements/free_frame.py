"""Frame in which positions were tracked, relative to the frame in which they are predicted, by
least squares.
"""

from __future__ import annotations

import numpy as np

from model_lab.aliases import Array, IntArray
from model_lab.measurements.hands import MARKER_AXES
from model_lab.measurements.sample_table import SampleTable


def frame_of(places: Array, seen: Array) -> tuple[Array, Array]:
    """(rotation (3, 3), translation (3,) [m]) that move places (n, 3) [m] closest to where they
    were seen (n, 3) [m]: seen = rotation @ place + translation (Kabsch, Acta Cryst. A32, 1976,
    922).
    """
    from scipy.spatial.transform import Rotation  # here, as it takes long to load

    middle, middle_seen = places.mean(axis=0), seen.mean(axis=0)
    turn = Rotation.align_vectors(seen - middle_seen, places - middle)[0].as_matrix()
    return np.asarray(turn), np.asarray(middle_seen - turn @ middle)


class FreeFrame:
    """Moves predicted positions of markers into the frame of the measured ones, which is known from
    these alone.
    """

    def __init__(self, table: SampleTable) -> None:
        points = [
            table.of_run(np.arange(float(table.samples)), run).reshape(-1, len(MARKER_AXES), rows)
            for run, rows in enumerate(np.bincount(table.run) // (int(table.output[-1]) + 1))
        ]
        rows = [point.swapaxes(1, 2).reshape(-1, len(MARKER_AXES)) for point in points]
        self._index: IntArray = np.concatenate(rows).astype(int)
        self._seen = table.value[self._index]
        self._known = np.isfinite(self._seen).all(axis=1)

    def __call__(self, predicted: Array) -> Array:
        """Predictions (samples,) [m], moved rigidly to where all markers were seen; unchanged if
        some are NaN.
        """
        if not np.isfinite(predicted).all():
            return predicted
        places = predicted[self._index]
        turn, shift = frame_of(places[self._known], self._seen[self._known])
        moved = np.empty_like(predicted)
        moved[self._index] = places @ turn.T + shift
        return moved
