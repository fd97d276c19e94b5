"""What the hand commands is air mass: with the valves closed it stays when a finger is squeezed.

`python examples/squeeze_a_finger.py` prints the outcome and draws mass and
pressure to out/squeeze_a_finger.png.
"""

import numpy as np

from softhand_model.pneumatics.plant import PneumaticPlant

STEP = 0.001  # [s]
VOLUME = 30e-6  # [m3] of a finger
FILL, SETTLE, SQUEEZE = 0.30, 1.0, 1.5  # [s] when filling ends, squeezing begins and ends


def squeeze():
    """Time [s], mass above rest [kg] and absolute pressure [Pa] of a finger that is filled, closed
    off, and squeezed to 90 % of its volume."""
    plant = PneumaticPlant(["finger"], [VOLUME])
    rest = plant.rest_mass([VOLUME])
    times = np.arange(0.0, SQUEEZE, STEP)
    masses, pressures = [], []
    for time in times:
        share = np.clip((time - SETTLE) / (SQUEEZE - SETTLE), 0.0, 1.0)
        volume = VOLUME * (1.0 - 0.1 * share)
        pressures.append(plant.step(STEP, [1 if time < FILL else 0], [volume])[0])
        masses.append((plant.mass - rest)[0])
    return times, np.array(masses), np.array(pressures)


def test_squeezed_by_a_tenth_the_pressure_rises_by_a_ninth_and_no_air_moves():
    times, masses, pressures = squeeze()
    before = np.searchsorted(times, SETTLE)
    assert masses[before] > 5e-6
    assert np.ptp(masses[before:]) < 1e-12
    np.testing.assert_allclose(pressures[-1] / pressures[before], 1.0 / 0.9, rtol=0.01)


if __name__ == "__main__":
    from pathlib import Path

    import matplotlib.pyplot as plt

    times, masses, pressures = squeeze()
    before, after = 1e-3 * pressures[np.searchsorted(times, SETTLE)], 1e-3 * pressures[-1]
    print(f"squeezed by a tenth: {before:.1f} to {after:.1f} kPa, {1e6 * masses[-1]:.1f} mg of air")
    _, (upper, lower) = plt.subplots(2, 1, sharex=True, layout="constrained")
    upper.plot(times, 1e6 * masses)
    upper.set_ylabel("air above rest [mg]")
    lower.plot(times, 1e-3 * pressures)
    lower.set_ylabel("absolute pressure [kPa]")
    lower.set_xlabel("time [s]")
    Path("out").mkdir(exist_ok=True)
    plt.savefig("out/squeeze_a_finger.png", dpi=120)
