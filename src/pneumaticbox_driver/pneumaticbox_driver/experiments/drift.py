"""Figures of a recorded sine: drift of the estimate, tracking error, pulses."""

import numpy as np

from pneumaticbox_driver.experiments.report import Floats, Series
from pneumaticbox_driver.experiments.sine import Sine


def under(prefix: str, series: Series) -> Series:
    """Series with a prefix before their names, so that two runs go into one file.

    >>> under("own", {"time": np.zeros(1)})
    {'own_time': array([0.])}
    """
    return {f"{prefix}_{name}": values for name, values in series.items()}


def of(prefix: str, series: Series) -> Series:
    """Those of the series that `under` has given this prefix."""
    head = f"{prefix}_"
    return {name[len(head) :]: v for name, v in series.items() if name.startswith(head)}


def drift(run: Series, truth: str = "truth") -> Floats:
    """Contained less estimated mass (samples, channels) [kg]; NaN unless the channel is still.

    Args:
        run: a record of `BenchRun.follow`.
        truth: "truth" of the plant, or "measured" as in the thesis.
    """
    still = np.isfinite(run["measured"])
    return np.where(still, run[truth] - run["estimate"], np.nan)


def final_drift(run: Series, truth: str = "truth") -> Floats:
    """Drift when the run is over (channels,) [kg]: the last sample at which a channel is still."""
    course = drift(run, truth)
    return np.array([column[np.isfinite(column)][-1] for column in course.T])


def in_sine(run: Series, sine: Sine) -> np.ndarray:
    """Marks the samples of the sine itself, without fill and hold (samples,)."""
    return (run["time"] >= sine.fill) & (run["time"] <= sine.end)


def tracking_error(run: Series, sine: Sine) -> Floats:
    """Contained less wanted mass over the sine (samples of it, channels) [kg]."""
    here = in_sine(run, sine)
    return np.asarray(run["truth"][here] - run["target"][here, None])


def control_error(run: Series, sine: Sine) -> Floats:
    """Estimated less wanted mass over the sine (samples of it, channels) [kg]: without drift."""
    here = in_sine(run, sine)
    return np.asarray(run["estimate"][here] - run["target"][here, None])


def pulses_in_sine(run: Series, sine: Sine) -> Floats:
    """Pulses per channel that the sine took (channels,)."""
    counts = run["pulses"][in_sine(run, sine)]
    return np.asarray(counts[-1] - counts[0])
