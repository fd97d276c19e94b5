"""Errors of the predictions themselves, which repeats of a measurement do not show."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from model_lab.aliases import Array
from model_lab.measurements.sample_table import SampleTable


@dataclass(frozen=True)
class OwnErrors:
    """Independent errors of the predictions for a set, in the unit of its outputs, each of the size
    of one standard deviation.

    whole (k, samples): errors whose size is the same throughout the set, such as that of a sensor's
    zero. apart (m, samples): errors that are the same in all repeats of a protocol, but independent
    between protocols and between outputs.
    """

    whole: Array
    apart: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def rows(self) -> Array:
        """All errors (k + m, samples); 0 where a prediction has no result."""
        parts = [part for part in (self.whole, self.apart) if len(part)]
        return np.nan_to_num(np.concatenate(parts))

    def covariance(self, rows: Array, gain: Array, table: SampleTable) -> Array:
        """Covariance (p, p) of p numbers that are linear in the prediction, with the transposed
        factors gain (p, samples). rows: the errors as `rows`, transformed as the gain is.
        """
        count = len(self.whole)
        moved = gain @ rows[:count].T
        found = moved @ moved.T
        for group, output in sorted({(part.group, part.output) for part in table.series}):
            mine = (table.group == group) & (table.output == output)
            moved = gain[:, mine] @ rows[count:, mine].T
            found = found + moved @ moved.T
        return np.asarray(found)
