"""Residuals as coefficients whose errors are nearly independent: a gain, then ever finer wiggles.

Errors of a measurement are not alike at all scales: a run as a whole is a little too large, a
sensor drifts slowly, and only then comes white noise. An orthonormal transform of every series,
its first vector along the prediction itself (a gain error), the others cosines of growing
frequency, takes them apart; a level of error for each band of frequencies then describes the noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct

from model_lab.measurements.measurement_set import Series, SeriesLayout

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

BAND_WIDTH = 3  # each band reaches to this many times the frequency of the one before


@dataclass(frozen=True)
class Spectrum:
    """The transform of one measurement set; bands (samples,) numbers the band of a coefficient.

    Bands of different outputs differ. Coefficients are laid out like the samples.
    """

    layout: SeriesLayout
    bands: IntArray
    band_output: IntArray
    _reflections: tuple[Array, ...]
    _by_length: tuple[tuple[int, IntArray], ...]

    def in_one_band(self) -> Spectrum:
        """The same with all coefficients of an output in one band: the errors count as white."""
        outputs, bands = np.unique(self.band_output[self.bands], return_inverse=True)
        return replace(self, bands=bands.reshape(-1).astype(np.int64), band_output=outputs)

    @property
    def band_count(self) -> int:
        """Number of bands over all outputs."""
        return len(self.band_output)

    def coefficients(self, residual: Array) -> Array:
        """Coefficients (lanes, samples) of residuals (lanes, samples), in the residuals' unit."""
        result = np.empty_like(residual)
        for part, (_, indices) in enumerate(self._by_length):
            transformed = dct(residual[:, indices], type=2, norm="ortho", axis=-1)
            mirror = self._reflections[part]
            along = np.einsum("lsn,sn->ls", transformed, mirror)
            result[:, indices] = transformed - 2.0 * along[..., None] * mirror
        return result

    def power(self, coefficients: Array) -> Array:
        """Sum of squares (lanes, bands) of coefficients (lanes, samples)."""
        return np.stack(
            [np.bincount(self.bands, lane, self.band_count) for lane in coefficients**2]
        )

    def counts(self) -> Array:
        """Number of coefficients (bands,) of each band."""
        return np.bincount(self.bands, minlength=self.band_count).astype(float)


def make_spectrum(layout: SeriesLayout, reference: Array) -> Spectrum:
    """The transform whose first vectors lie along a reference prediction (samples,)."""
    lengths = sorted({part.stop - part.start for part in layout.series})
    by_length, reflections = [], []
    for length in lengths:
        starts = [part.start for part in layout.series if part.stop - part.start == length]
        indices = np.array(starts)[:, None] + np.arange(length)
        by_length.append((length, indices))
        reflections.append(_mirror(dct(reference[indices], type=2, norm="ortho", axis=-1)))
    bands, band_output = _bands(layout)
    return Spectrum(layout, bands, band_output, tuple(reflections), tuple(by_length))


def _mirror(along: Array) -> Array:
    """Unit normals (series, n) of the reflections that turn `along` into the first axis."""
    size = np.linalg.norm(along, axis=-1, keepdims=True)
    normal = along / np.where(size > 0.0, size, 1.0)
    sign = np.where(normal[:, :1] < 0.0, -1.0, 1.0)
    normal[:, :1] += sign
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    return normal / length


def _bands(layout: SeriesLayout) -> tuple[IntArray, IntArray]:
    """Band of every coefficient, and the output of every band."""
    keys = np.concatenate([_keys(part) for part in layout.series])
    found, bands = np.unique(keys, axis=0, return_inverse=True)
    return bands.reshape(-1).astype(np.int64), found[:, 0].astype(np.int64)


def _keys(part: Series) -> IntArray:
    order = np.arange(part.stop - part.start)
    band = np.where(order == 0, 0, 1 + np.floor(np.log(np.maximum(order, 1)) / np.log(BAND_WIDTH)))
    return np.stack([np.full(len(order), part.output), band.astype(np.int64)], axis=1)
