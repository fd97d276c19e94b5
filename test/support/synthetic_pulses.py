"""Test pulses that obey equation 4.1, and the same with noise of known size."""

from dataclasses import replace

import numpy as np

from pneumaticbox_driver.calibration.regression import Pulse, regressors
from pneumaticbox_driver.observer.coefficients import PulseCoefficients

KNOWN = PulseCoefficients(-2e-7, 3e-13, 1.2e-10, 2.5e-12, -1.9e-12)
VENTING = PulseCoefficients(1e-8, 2e-11, 9.8e-10, -1.2e-11)
SENSOR = 50e-9  # one sigma [kg]


def design(inflating, count=50, seed=0, durations=(0.045, 1.0), supplies=(361e3, 421e3)):
    """Pulses without noise, of plausible integrals."""
    random = np.random.default_rng(seed)
    coefficients = KNOWN if inflating else VENTING
    pulses = []
    for _ in range(count):
        duration, channel = random.uniform(*durations), random.uniform(105e3, 160e3)
        p_in = random.choice(supplies) if inflating else channel
        p_out = channel if inflating else 101.3e3
        psi = 0.484 if inflating else np.sqrt(1 - p_out / p_in)
        pulse = Pulse(
            inflating, duration, (p_in - p_out) * duration, p_in * psi * duration, p_in, p_out, 0.0
        )
        mass = float(regressors([pulse])[0] @ coefficients.as_array())
        pulses.append(replace(pulse, mass=mass, noise=SENSOR))
    return pulses


def noisy(pulses, random, jitter):
    """The same pulses with sensor noise and with scattered valve delays [s]."""
    return [
        replace(
            pulse,
            mass=pulse.mass
            + random.normal(0, SENSOR)
            + random.normal(0, jitter) * pulse.mass / pulse.duration,
        )
        for pulse in pulses
    ]
