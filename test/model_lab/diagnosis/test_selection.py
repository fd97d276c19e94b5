"""What candidates achieve in noise: the stated chance is the one that is met."""

import numpy as np
from scipy.stats import kstest
from toy_forward import toy_forward, toy_set

from model_lab.diagnosis.search import Signature
from model_lab.diagnosis.selection import null_maxima, p_value
from model_lab.fitting.noise_floor import make_spectrum


def test_chances_of_the_best_of_several_candidates_are_even_in_noise():
    data = toy_set(np.random.default_rng(0))
    spectrum = make_spectrum(data.table, toy_forward(data).measured)
    random = np.random.default_rng(1)
    samples = spectrum.table.samples
    shapes = random.standard_normal((5, samples)).cumsum(axis=1)
    shapes /= np.linalg.norm(shapes, axis=1, keepdims=True)
    one = np.ones(5)
    found = Signature(one[:, None], np.zeros((2, 1)), shapes, one, one)
    maxima = null_maxima([found], spectrum, seed=2)
    chances = []
    counts = spectrum.counts()
    for _ in range(400):
        noise = random.standard_normal(samples)
        level = np.bincount(spectrum.bands, noise**2) / counts  # known from the noise alone
        whitened = noise / np.sqrt(level[spectrum.bands])
        chances.append(p_value(maxima, float(np.max((shapes @ whitened) ** 2))))
    assert kstest(chances, "uniform").pvalue > 1e-3
    assert np.mean(np.array(chances) < 0.05) < 0.085  # 0.05 and three standard errors


def test_a_candidate_that_changes_nothing_achieves_nothing():
    data = toy_set(np.random.default_rng(0))
    spectrum = make_spectrum(data.table, toy_forward(data).measured)
    none = np.zeros(1)
    idle = Signature(none[:, None], np.zeros((2, 1)), np.zeros((1, 1200)), none, none)
    assert np.all(null_maxima([idle], spectrum, seed=0) == 0.0)
