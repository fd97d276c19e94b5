"""Noise of a set: errors in bands of frequency, and the lowest error that a model can reach.

Errors of a measurement are not alike at all scales: a run as a whole is a little too large, a
sensor drifts slowly, and only then comes white noise. An orthonormal transform of every series,
its first vector along the prediction itself (a gain error), the others cosines of growing
frequency, takes them apart; a level of error for each band of frequencies then describes the noise.
The floor has these levels from repeats, else as stated, else from a smoothing spline.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.fft import dct
from scipy.special import chdtri

from model_lab.aliases import Array, IntArray, Mask
from model_lab.fitting.pulse_noise import pulse_level
from model_lab.fitting.smoothing import short_spline_rest, spline_square
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.resolution import rounding_errors
from model_lab.measurements.sample_table import SampleTable, Series
from model_lab.rules import RULES

MOST_BANDS = 64  # of an output: series of 3**62 samples
BAND_WIDTH = 3  # each band reaches to this many times the frequency of the one before
REPEATS, STATED, SPLINE = "repeats", "stated", "spline"
SPLINE_PIECE = 250  # samples of one, as the effort grows with their square
FLOOR_SPLINE_PIECES = 12  # of each output
ALIKE_DRAWS = 4000
SMALLEST_SHARE = 1e-9  # of the measured scale: a floor is never exactly zero
SMALLEST_LEVEL = 1e-15  # in the unit of the outputs; masses of pulses are above 1e-9 kg


@dataclass(frozen=True)
class Spectrum:
    """The transform of one measurement set into bands of frequency.

    bands (samples,): number of the band of each coefficient; coefficients are laid out like the
    samples. band_output (bands,): output of each band, as outputs have bands of their own.
    """

    table: SampleTable
    bands: IntArray
    band_output: IntArray
    _reflections: tuple[Array, ...]
    _by_length: tuple[tuple[int, IntArray], ...]

    def in_one_band(self) -> Spectrum:
        """The spectrum with all coefficients of an output in one band, so that errors count as
        white.
        """
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
        result = np.empty((len(coefficients), self.band_count))
        for row, lane in zip(result, coefficients**2, strict=True):
            row[:] = np.bincount(self.bands, lane, self.band_count)
        return result

    def counts(self) -> Array:
        """Number of coefficients in each band (bands,)."""
        return self._counts.copy()

    @cached_property
    def _counts(self) -> Array:
        return np.bincount(self.bands, minlength=self.band_count).astype(float)

    @cached_property
    def bands_of_outputs(self) -> list[IntArray]:
        """Numbers of the bands of each output, by growing frequency."""
        outputs = np.unique(self.band_output)
        return [np.flatnonzero(self.band_output == output) for output in outputs]


def make_spectrum(table: SampleTable, reference: Array) -> Spectrum:
    """The transform in which the first vector of each series lies along a reference prediction
    (samples,).
    """
    by_length, reflections = [], []
    for length in sorted({part.length for part in table.series}):
        starts = [part.start for part in table.series if part.length == length]
        indices = np.array(starts)[:, None] + np.arange(length)
        by_length.append((length, indices))
        reflections.append(_mirror(dct(reference[indices], type=2, norm="ortho", axis=-1)))
    bands, band_output = _bands(table)
    return Spectrum(table, bands, band_output, tuple(reflections), tuple(by_length))


def _mirror(along: Array) -> Array:
    """Unit normals (series, n) of the reflections that turn `along` into the first axis."""
    size = np.linalg.norm(along, axis=-1, keepdims=True)
    normal = along / np.where(size > 0.0, size, 1.0)
    sign = np.where(normal[:, :1] < 0.0, -1.0, 1.0)
    normal[:, :1] += sign
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    return normal / length


def _bands(table: SampleTable) -> tuple[IntArray, IntArray]:
    """Band of every coefficient, and the output of every band."""
    short = _has_short_runs(table)  # too few coefficients for more than two levels
    keys = np.concatenate([_keys(part, short) for part in table.series])
    found = np.flatnonzero(np.bincount(keys))
    return np.searchsorted(found, keys), found // MOST_BANDS


def _has_short_runs(table: SampleTable) -> bool:
    return table.samples <= RULES.short_run * table.runs


def _keys(part: Series, short: bool) -> IntArray:
    """For each coefficient the number of its band among those that any output could have."""
    order = np.arange(part.length)
    band = np.where(order == 0, 0, 1 + np.floor(np.log(np.maximum(order, 1)) / np.log(BAND_WIDTH)))
    if short:
        band = np.minimum(band, 1)
    return part.output * MOST_BANDS + band.astype(np.int64)


@dataclass(frozen=True)
class NoiseFloor:
    """The lowest error that a model can reach, as a standard deviation in the SI unit of the
    outputs.

    total: root mean square over the samples. within, between: its parts within and between runs.
    upper: its 95 % upper bound. variance (bands,): mean square of a coefficient in each band. dof
    (bands,): degrees of freedom from which that was estimated; 0 for a band that repeats do not
    show. source: what it was estimated from.
    """

    total: float
    within: float
    between: float
    upper: float
    variance: Array
    dof: Array
    source: str

    @property
    def gain_known(self) -> bool:
        """Whether it is known how much whole runs differ, from repeats or from usual values."""
        return bool(self.dof.any())


def noise_floor(
    data: MeasurementSet, spectrum: Spectrum, residual: Array, own_error: float | Array = 0.0
) -> NoiseFloor:
    """The noise floor of a set, from the residual (samples,) of a model fitted to it.

    With repeats, an error of the model that is the same in all of them has no influence. own_error:
    error of the predictions themselves, which is added to the noise: a root mean square, which
    counts in every band, or errors (k, samples), which count in their bands. Raises ValueError for
    sets from which no floor can be estimated.
    """
    known = _measured_floor(data, spectrum, residual)
    if not np.any(own_error):
        return known
    if isinstance(own_error, np.ndarray):
        power = spectrum.power(spectrum.coefficients(own_error)).sum(axis=0)
        own = power / spectrum.counts()
    else:
        own = np.full(spectrum.band_count, own_error**2)
    return _floor(known.variance + own, known.dof, spectrum, known.source)


def _measured_floor(data: MeasurementSet, spectrum: Spectrum, residual: Array) -> NoiseFloor:
    """The floor as noise alone has it."""
    scale = max(SMALLEST_SHARE * float(np.abs(residual).max()), SMALLEST_LEVEL)
    power, dof = _contrasts(spectrum, residual)
    counts = spectrum.counts()
    if dof.sum() > 0.0:
        seen = dof > 0.0
        variance = np.where(seen, power / np.where(seen, dof, 1.0), 0.0)
        variance = _falling(np.where(seen, variance, variance[seen].min()), dof, spectrum)
        rounding = rounding_errors(data, data.table.value - residual, repeated=True)
        if rounding is not None:  # alike in all repeats that pass through the same values
            rounded, freedom = _level(spectrum.power(spectrum.coefficients(rounding)) / counts)
            larger = rounded > variance
            variance = np.where(larger, rounded, variance)
            dof = np.where(larger & seen, np.minimum(dof, freedom), dof)
        return _floor(np.maximum(variance, scale**2), dof, spectrum, REPEATS)
    stated = [data.noise.get(name) for name in data.outputs]
    if all(level is not None for level in stated):
        squares = [np.mean(data.scales_of(run) ** 2, axis=1) for run in data.runs]
        samples = [run.samples for run in data.runs]
        scales = np.sqrt(np.average(squares, axis=0, weights=samples))
        levels, source = scales * np.array(stated, float), STATED
    else:
        levels, source = spline_levels(data, spectrum, residual), SPLINE
    variance = np.maximum(levels[spectrum.band_output] ** 2, scale**2)
    rounding = rounding_errors(data, data.table.value - residual)
    if rounding is not None:
        variance += spectrum.power(spectrum.coefficients(rounding)).mean(axis=0) / counts
    if source == SPLINE and data.stretched:
        variance[0] += _unseen_gain(spectrum)
        return _floor(variance, counts * 0.0 + RULES.rubber_freedom, spectrum, source)
    return _floor(variance, counts * 0.0, spectrum, source)


def _level(drawn: Array) -> tuple[Array, Array]:
    """Mean (bands,) of mean squares (draws, bands), and the degrees of freedom of one draw."""
    mean, spread = drawn.mean(axis=0), drawn.var(axis=0)
    return mean, 2.0 * mean**2 / np.maximum(spread, SMALLEST_SHARE * mean**2 + SMALLEST_LEVEL**4)


def _floor(variance: Array, dof: Array, spectrum: Spectrum, source: str) -> NoiseFloor:
    counts = spectrum.counts()
    share = counts / counts.sum()
    total = float(share @ variance)
    white = np.array([_white_level(variance, counts, spectrum, band) for band in range(len(dof))])
    within = float(share @ np.minimum(white, variance))
    spread = float(share**2 @ (2.0 * variance**2 / np.where(dof > 0.0, dof, counts)))
    freedom = 2.0 * total**2 / spread
    upper = total * freedom / chdtri(freedom, RULES.floor_level)
    between = max(total - within, 0.0)
    roots = np.sqrt([total, within, between, upper]).tolist()
    return NoiseFloor(roots[0], roots[1], roots[2], roots[3], variance, dof, source)


def _white_level(variance: Array, counts: Array, spectrum: Spectrum, band: int) -> float:
    """Level of the widest band of the same output: what is alike at all frequencies."""
    same = np.flatnonzero(spectrum.band_output == spectrum.band_output[band])
    return float(variance[same[np.argmax(counts[same])]])


def _falling(variance: Array, dof: Array, spectrum: Spectrum) -> Array:
    """Levels that do not rise with frequency, by pooling adjacent violators for each output."""
    result = variance.copy()
    for mine in spectrum.bands_of_outputs:
        result[mine] = falling(variance[mine], np.maximum(dof[mine], 1.0))
    return result


def falling(values: Array, weights: Array) -> Array:
    """The sequence (n,) that never rises and is nearest to values (n,) in the weighted mean square.

    >>> falling(np.array([1.0, 3.0, 1.0]), np.ones(3)).tolist()
    [2.0, 2.0, 1.0]
    """
    blocks: list[list[float]] = []  # value, weight, length
    for value, weight in zip(values, weights, strict=True):
        blocks.append([float(value), float(weight), 1])
        while len(blocks) > 1 and blocks[-2][0] < blocks[-1][0]:
            last, before = blocks.pop(), blocks.pop()
            both = before[1] + last[1]
            mean = (before[0] * before[1] + last[0] * last[1]) / both
            blocks.append([mean, both, before[2] + last[2]])
    return np.concatenate([np.full(int(block[2]), block[0]) for block in blocks])


def _contrasts(spectrum: Spectrum, residual: Array) -> tuple[Array, Array]:
    """Sum of squares and degrees of freedom (bands,) of the scatter between repeats.

    Runs that differ from their repeats by far more than others do, over all outputs, are left out:
    something happened in one of them, and no model of the actuator should be excused by that.
    """
    coefficients = spectrum.coefficients(residual[None])[0]
    scatter = [
        np.sum([_scatter(spectrum, coefficients, repeats) for repeats in outputs], axis=0)
        for outputs in _repeated(spectrum.table.series)
    ]
    if not scatter:
        return np.zeros(spectrum.band_count), np.zeros(spectrum.band_count)
    power, dof = np.swapaxes(scatter, 0, 1)
    kept = _alike(power[:, _slow(spectrum)].sum(axis=1), dof[:, _slow(spectrum)].sum(axis=1))
    return power[kept].sum(axis=0), dof[kept].sum(axis=0)


def _scatter(spectrum: Spectrum, coefficients: Array, repeats: list[Series]) -> tuple[Array, Array]:
    """Sum of squares and degrees of freedom (bands,) of one group of repeats."""
    length = min(part.length for part in repeats)  # coefficients of one order: of one frequency
    rows = np.stack([coefficients[part.start : part.start + length] for part in repeats])
    bands = spectrum.bands[repeats[0].start : repeats[0].start + length]
    squares = np.sum((rows - rows.mean(axis=0)) ** 2, axis=0)
    freedom = (len(repeats) - 1) * np.bincount(bands, minlength=spectrum.band_count)
    power = np.bincount(bands, squares, spectrum.band_count)
    return np.asarray(power, float), np.asarray(freedom, float)


def _slow(spectrum: Spectrum) -> Mask:
    """Bands (bands,) of slow errors, without those of a run's gain."""
    first = np.searchsorted(spectrum.band_output, spectrum.band_output)
    order = np.arange(spectrum.band_count) - first
    return np.asarray((order >= 1) & (order <= RULES.odd_bands))


def _alike(power: Array, dof: Array) -> Mask:
    """Groups (groups,) to keep: all, unless the upper half scatters too much for one level.

    The null distribution of the ratio of the halves is drawn; it depends on nothing but the degrees
    of freedom.
    """
    every = np.ones(len(power), bool)
    if len(power) < RULES.odd_groups or not np.all(dof > 0.0):
        return every
    drawn = np.random.default_rng(0).chisquare(dof, (ALIKE_DRAWS, len(dof))) / dof
    null = np.sort(_ratio_of_halves(drawn))
    level = power / dof
    if _ratio_of_halves(level[None])[0] <= null[int((1.0 - RULES.odd_p_value) * ALIKE_DRAWS)]:
        return every
    usual = float(np.median(np.sort(level)[: len(level) // 2]))
    return np.asarray(level <= RULES.odd_square * usual)


def _ratio_of_halves(levels: Array) -> Array:
    """Sum of the larger half over that of the smaller half (draws,) of levels (draws, groups)."""
    ordered = np.sort(levels, axis=1)
    half = levels.shape[1] // 2
    lower = np.maximum(ordered[:, :half].sum(axis=1), 1e-300)
    return np.asarray(ordered[:, -half:].sum(axis=1) / lower)


def _repeated(series: tuple[Series, ...]) -> list[list[list[Series]]]:
    """Series that repeat each other: same group and output, and the same block of their run; those
    of all outputs of a block together.
    """
    found: dict[tuple[int, int], dict[int, list[Series]]] = defaultdict(lambda: defaultdict(list))
    block: dict[tuple[int, int], int] = defaultdict(int)
    for part in series:
        place = block[part.run, part.output]
        block[part.run, part.output] += 1
        found[part.group, place][part.output].append(part)
    repeated = [
        [parts for parts in outputs.values() if len(parts) > 1] for outputs in found.values()
    ]
    return [outputs for outputs in repeated if outputs]


def spline_levels(data: MeasurementSet, spectrum: Spectrum, residual: Array) -> Array:
    """One sigma (outputs,), in the unit of the residual (samples,), of what smoothing splines
    through pieces of the series leave. Raises ValueError for runs that are too short.
    """
    if data.experiment == "valve_pulse":
        level = pulse_level(data, residual)
        if level is not None:
            return np.array([level])
    if data.stretched and _has_short_runs(spectrum.table):
        level = _short_series_level(data, spectrum, residual)
        if level is not None:
            return np.array([level])
    outputs = int(spectrum.band_output.max()) + 1
    levels = []
    for output in range(outputs):
        pieces = [
            residual[start:stop]
            for course in spectrum.table.courses
            if course.output == output
            for start, stop in _pieces(course.start, course.stop)
        ]
        chosen = pieces[:: -(-len(pieces) // FLOOR_SPLINE_PIECES)] if pieces else []
        squares = [spline_square(piece) for piece in chosen]
        if not squares:
            raise ValueError(
                "noise floor: expected repeated runs, `noise` in experiment.yaml, or runs of at "
                f"least {RULES.spline_samples} samples, got none of these three; add one of them"
            )
        levels.append(float(np.median(squares)))
    return np.sqrt(np.array(levels))


def _unseen_gain(spectrum: Spectrum) -> float:
    """Variance of the coefficient of a series' gain that repeats of a test of rubber would show."""
    squares = [np.sum(spectrum.table.value[part.samples] ** 2) for part in spectrum.table.series]
    return float(RULES.rubber_scatter**2 * np.mean(squares))


def _short_series_level(data: MeasurementSet, spectrum: Spectrum, residual: Array) -> float | None:
    """One sigma of what splines over the stretch leave of a few readings at uneven stretches, over
    all runs, with the freedom that the splines use up; None where stretches are too few or alike.
    """
    squares, freedom = 0.0, 0.0
    for course in spectrum.table.courses:
        stretch = data.driving(data.runs[course.run])
        part = short_spline_rest(stretch, residual[course.samples])
        squares, freedom = squares + part[0], freedom + part[1]
    return float(np.sqrt(squares / freedom)) if freedom >= RULES.fewest_freedom else None


def _pieces(start: int, stop: int) -> list[tuple[int, int]]:
    """Starts and ends of neighbouring pieces of a series that are long enough for a spline."""
    count = max((stop - start) // SPLINE_PIECE, 1)
    edges = np.linspace(start, stop, count + 1).astype(int).tolist()
    return [(low, high) for low, high in pairwise(edges) if high - low >= RULES.spline_samples]
