"""How far a P10 finger bends: exact, and by the approximation that the thesis prints.

`python examples/bend_a_finger.py` prints three angles and draws both curves
to out/bend_a_finger.png.
"""

import numpy as np

from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.section import free_curvature, free_curvature_printed, side_wall_ratio

LENGTH, HEIGHT, WALL, MODULUS = 0.090, 0.020, 0.002, 73.7e3  # constant section of chapter 5


def tip_angles(pressure):
    """Angle of the tip [deg] at gauge pressures [Pa]: (exact, by the printed approximation)."""
    section = (pressure, HEIGHT, HEIGHT, WALL, WALL, MODULUS)
    exact, printed = free_curvature(*section), free_curvature_printed(*section)
    return np.degrees(exact * LENGTH), np.degrees(printed * LENGTH)


def test_at_31_kpa_the_finger_of_constant_section_bends_by_122_degrees():
    exact, _ = tip_angles(np.array([31e3]))
    np.testing.assert_allclose(exact, 122.2, atol=0.1)


if __name__ == "__main__":
    from pathlib import Path

    import matplotlib.pyplot as plt

    pressure = np.linspace(0.0, 60e3, 200)
    exact, printed = tip_angles(pressure)
    tapered = np.degrees([load_actuator("P10.finger").tip_angle(p) for p in pressure])
    for wanted in (20e3, 40e3, 60e3):
        (at_once,), (as_printed,) = tip_angles(np.array([wanted]))
        print(f"{wanted / 1e3:.0f} kPa: {at_once:.1f} deg, {as_printed:.1f} deg as printed")
    plt.plot(pressure / 1e3, exact, label="constant section, exact")
    plt.plot(pressure / 1e3, printed, "--", label="constant section, as printed (5.2)")
    plt.plot(pressure / 1e3, tapered, label="P10.finger with its taper, G = 67 kPa")
    plt.xlabel("gauge pressure [kPa]")
    plt.ylabel("tip angle [deg]")
    plt.title(f"P10 finger, side wall ratio {side_wall_ratio(HEIGHT, HEIGHT, WALL, WALL):.3f}")
    plt.legend()
    Path("out").mkdir(exist_ok=True)
    plt.savefig("out/bend_a_finger.png", dpi=120)
