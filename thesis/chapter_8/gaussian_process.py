"""Cross-validated regression by a Gaussian process: how well a smooth map of the inputs predicts
outputs that it has not seen.

After Rasmussen and Williams, Gaussian Processes for Machine Learning (2006): prediction (2.25),
marginal likelihood (2.30) and its gradient (5.9), a length scale for each input (5.1). All outputs
share one kernel, the sum of a linear and a smooth part.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

Array = NDArray[np.float64]

FOLDS = 10
# bounds of the kernel's parameters: slope, amplitude, noise [-] of outputs that are scaled to a
# spread of 1, and lengths [-] of inputs from 0 to 1
SLOPE, AMPLITUDE, NOISE, LENGTH = (1e-2, 1e1), (1e-2, 1e1), (1e-3, 1e0), (2e-1, 1e1)
START = (1.0, 1.0, 0.1, 1.0)


def cross_validated_errors(inputs: Array, outputs: Array, folds: int = FOLDS) -> Array:
    """Squared prediction error of each row, summed over its outputs; each row is predicted without
    its fold.

    Args:
        inputs: (n, m) [-], from 0 to 1.
        outputs: (n, d), in any unit.
        folds: number of parts, each of which is left out in turn.

    Returns:
        Errors (n,) in the square of the outputs' unit.

    >>> x = np.linspace(0.0, 1.0, 20)[:, None]
    >>> errors = cross_validated_errors(x, np.sin(4 * x))
    >>> bool(errors.sum() / np.var(np.sin(4 * x)) / 20 < 0.01)
    True
    """
    count = len(inputs)
    errors = np.zeros(count)
    start = GaussianProcess(inputs, outputs).logarithms  # where the search of each fold begins
    for fold in range(min(folds, count)):
        left = np.arange(count) % folds == fold
        process = GaussianProcess(inputs[~left], outputs[~left], start)
        errors[left] = ((process.predict(inputs[left]) - outputs[left]) ** 2).sum(axis=1)
    return errors


class GaussianProcess:
    """A Gaussian process through outputs (n, d) at inputs (n, m) with the kernel of maximum
    likelihood; `logarithms` of the kernel's parameters start the maximisation.
    """

    def __init__(self, inputs: Array, outputs: Array, start: Array | None = None) -> None:
        self._inputs, self._mean = inputs, outputs.mean(axis=0)
        centred = outputs - self._mean
        self._scale = float(np.sqrt((centred**2).mean())) or 1.0
        self._outputs = centred / self._scale
        bounds = np.log([SLOPE, AMPLITUDE, NOISE, *[LENGTH] * inputs.shape[1]])
        if start is None:
            start = np.log([*START[:3], *[START[3]] * inputs.shape[1]])
        found = minimize(self._unlikeliness, start, jac=True, method="L-BFGS-B", bounds=bounds)
        self.logarithms: Array = found.x
        self._parameters = np.exp(found.x)
        factor = cho_factor(self._noisy(self._parameters), lower=True)
        self._weights = cho_solve(factor, self._outputs)

    def predict(self, inputs: Array) -> Array:
        """Expected outputs (k, d) at inputs (k, m)."""
        covariance = _kernel(inputs, self._inputs, self._parameters)
        return self._mean + self._scale * covariance @ self._weights

    def _noisy(self, parameters: Array) -> Array:
        covariance = _kernel(self._inputs, self._inputs, parameters)
        return covariance + parameters[2] ** 2 * np.eye(len(self._inputs))

    def _unlikeliness(self, logarithms: Array) -> tuple[float, Array]:
        """Negative log likelihood up to a constant, and its gradient (5.9)."""
        parameters, outputs = np.exp(logarithms), self._outputs
        factor = cho_factor(self._noisy(parameters), lower=True)
        weights = cho_solve(factor, outputs)
        size, count = outputs.shape[1], len(outputs)
        value = 0.5 * (outputs * weights).sum() + size * np.log(np.diag(factor[0])).sum()
        inner = 0.5 * (size * cho_solve(factor, np.eye(count)) - weights @ weights.T)
        return float(value), np.array([(inner * part).sum() for part in self._slopes(parameters)])

    def _slopes(self, parameters: Array) -> list[Array]:
        """Slopes of the covariance in the logarithms of the parameters."""
        inputs = self._inputs
        linear = parameters[0] ** 2 * inputs @ inputs.T
        smooth = _kernel(inputs, inputs, parameters) - linear
        noise = parameters[2] ** 2 * np.eye(len(inputs))
        apart = ((inputs[:, None] - inputs[None]) / parameters[3:]) ** 2
        return [2 * linear, 2 * smooth, 2 * noise, *(smooth * np.moveaxis(apart, 2, 0))]


def _kernel(first: Array, second: Array, parameters: Array) -> Array:
    slope, amplitude, lengths = parameters[0], parameters[1], parameters[3:]
    apart = (first[:, None] - second[None]) / lengths
    smooth = amplitude**2 * np.exp(-0.5 * (apart**2).sum(axis=2))
    return np.asarray(slope**2 * first @ second.T + smooth)
