"""What a noisy course of readings is at rest: at its beginning, and where it is lowest."""

from __future__ import annotations

import numpy as np

from model_lab.aliases import Array

FEWEST_ON_LINE = 8  # first samples that tell where a course begins; by hand, as all here
BENT = 2.0  # standard deviations of a bend that is none of the noise
SIGMA_OF_MEDIAN = 1.4826  # standard deviation over the median of the size, of white noise
REACH_OF_NOISE = 6.0  # standard deviations by which noise lowers the lowest of many readings


def beginning(course: Array) -> float:
    """Value of a course (samples,) at its first sample, without most of its noise.

    It is the start of a parabola through as many first samples as lie on one within the noise; of a
    straight line if it hardly bends, or their mean if that is level: a camera's first frame alone
    would give each run a zero of its own, and a line through a ramp that bends one that is too low.
    Without noise it is the first sample.
    """
    noise, found, count = white_noise(course), float(course[0]), FEWEST_ON_LINE
    while count <= len(course) // 2:
        shapes = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, count), 3, increasing=True))[0]
        size = shapes.T @ course[:count]  # of mean, slope and bend, each with the noise's sigma
        left = course[:count] - shapes @ size
        if np.sqrt(left @ left / (count - 3)) > noise * (1.0 + 2.0 / np.sqrt(count)):
            break
        kept = 3 if abs(size[2]) > BENT * noise else 2 if abs(size[1]) > noise else 1
        found, count = float(shapes[0, :kept] @ size[:kept]), 2 * count
    return found


def lowest(course: Array) -> list[float]:
    """The values at beginning and end of a course (samples,), without most of their noise, of which
    no reading is lower by more than noise; if there is no such value, the lowest reading.

    The lowest reading alone is too low: the more readings there are, the farther noise reaches.

    >>> course = np.append(np.full(400, 100.0), np.linspace(100.0, 200.0, 400))
    >>> course += np.random.default_rng(0).normal(0.0, 1.0, 800)
    >>> round(float(course.min())), [round(level) for level in lowest(course)]
    (96, [100])
    """
    least, reach = float(np.min(course)), REACH_OF_NOISE * white_noise(course)
    ends = beginning(course), beginning(course[::-1])
    return [end for end in ends if end - least <= reach] or [least]


def white_noise(course: Array) -> float:
    """Standard deviation of white noise, from the second differences of a course (samples,); 0
    where these follow a curve and do not alternate as those of noise do.
    """
    if len(course) < FEWEST_ON_LINE:
        return 0.0
    bends = np.diff(course, 2)
    if bends[1:] @ bends[:-1] >= 0.0:
        return 0.0
    return float(np.median(np.abs(bends))) * SIGMA_OF_MEDIAN / float(np.sqrt(6.0))
