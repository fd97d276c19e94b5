"""Air as the soft hand's working gas: enclosed mass, flow through an orifice and along a tube.

Source: R. Deimel, *Soft Robotic Hands For Compliant Grasping*, section 4.4. All pressures here are
absolute; flow is positive from `pressure_in_abs` to `pressure_out_abs`.
"""

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array

GAS_CONSTANT = 287.05  # of dry air [J/(kg K)]
ROOM_TEMPERATURE = 293.15  # the 20 degrees Celsius of the thesis [K]
AMBIENT_PRESSURE = 101_300.0  # absolute, section 4.4.1 [Pa]
VISCOSITY = 1.82e-5  # dynamic, of air at room temperature [Pa s]
HEAT_CAPACITY_RATIO = 1.4
CHOKED_PSI = 0.484  # flow function at sonic flow, as printed in section 4.4.1
CRITICAL_RATIO = (2 / (HEAT_CAPACITY_RATIO + 1)) ** (
    HEAT_CAPACITY_RATIO / (HEAT_CAPACITY_RATIO - 1)
)  # p_out/p_in below which an orifice is choked, 1/1.894


def air_mass(
    pressure_abs: ArrayLike, volume: ArrayLike, temperature: float = ROOM_TEMPERATURE
) -> Array:
    """Mass of the air that fills a volume: `m = p_abs V/(R_s T)` (section 4.2).

    Args:
        pressure_abs: absolute pressure [Pa].
        volume: volume of air [m3].
        temperature: of the air [K].

    Returns:
        Mass [kg], in the common shape of the arguments.

    >>> round(1e6 * float(air_mass(101_300.0, 30e-6)), 1)  # mg in a finger's 30 cm3
    36.1
    """
    product = np.asarray(pressure_abs, dtype=float) * np.asarray(volume, dtype=float)
    return np.asarray(product / (GAS_CONSTANT * temperature))


def psi(ratio: ArrayLike) -> Array:
    """Flow function of an orifice (section 4.4.1).

    ERRATUM: the thesis prints the factor 7.0 under the root for air; `kappa/(kappa - 1) = 3.5` is
    right and meets the 0.484 of sonic flow.

    Args:
        ratio: outlet over inlet pressure, absolute [-]; above 1 counts as 1 (no flow).

    Returns:
        Psi [-], from 0 (no pressure drop) to 0.484 (choked).

    >>> [round(float(psi(r)), 4) for r in (0.2, 0.5283, 0.8, 1.0)]
    [0.4842, 0.4842, 0.3964, 0.0]
    """
    r = np.minimum(np.maximum(ratio, CRITICAL_RATIO), 1.0)
    root = r ** (1 / HEAT_CAPACITY_RATIO)
    exponent = HEAT_CAPACITY_RATIO / (HEAT_CAPACITY_RATIO - 1)
    return np.asarray(np.sqrt(exponent * root * (root - r)))


def orifice_conductance(area: ArrayLike, temperature: float = ROOM_TEMPERATURE) -> Array:
    """Mass flow of an orifice per inlet pressure and Psi: `A sqrt(2/(R_s T))`.

    Args:
        area: effective area, discharge coefficient included [m2].
        temperature: of the air upstream [K].

    Returns:
        Conductance [kg/(s Pa)].

    >>> hole = 3.14159e-8  # 0.2 mm across
    >>> round(1e10 * float(orifice_conductance(hole)), 3)
    1.532
    """
    return np.asarray(np.asarray(area, dtype=float) * np.sqrt(2 / (GAS_CONSTANT * temperature)))


def orifice_flow(
    pressure_in_abs: ArrayLike,
    pressure_out_abs: ArrayLike,
    area: ArrayLike,
    temperature: float = ROOM_TEMPERATURE,
) -> Array:
    """Isentropic mass flow through an orifice: `A p_in sqrt(2/(R_s T)) Psi(p_out/p_in)`.

    Args:
        pressure_in_abs: absolute pressure upstream [Pa]; no flow where it is below the other one.
        pressure_out_abs: absolute pressure downstream [Pa].
        area: effective area, discharge coefficient included [m2].
        temperature: of the air upstream [K].

    Returns:
        Mass flow [kg/s], zero or above.

    >>> round(1e6 * float(orifice_flow(300e3, 101.3e3, 3.14159e-8)), 2)  # mg/s, choked
    22.25
    """
    upstream = np.asarray(pressure_in_abs, dtype=float)
    ratio = np.asarray(pressure_out_abs, dtype=float) / upstream
    return np.asarray(orifice_conductance(area, temperature) * upstream * psi(ratio))


def line_conductance(
    diameter: ArrayLike, length: ArrayLike, temperature: float = ROOM_TEMPERATURE
) -> Array:
    """Mass flow of a tube per drop of squared pressure, laminar and isothermal.

    Hagen-Poiseuille with the density of an ideal gas: `pi r**4/(16 mu L R_s T)`.

    Args:
        diameter: inner diameter [m].
        length: of the tube [m].
        temperature: of the air [K].

    Returns:
        Conductance `K` of `flow = K (p_in**2 - p_out**2)` [kg/(s Pa2)].

    >>> round(1e13 * float(line_conductance(2e-3, 0.6)), 2)
    2.14
    """
    resistance = 16 * VISCOSITY * np.asarray(length, dtype=float) * GAS_CONSTANT * temperature
    return np.asarray(np.pi * (np.asarray(diameter, dtype=float) / 2) ** 4 / resistance)
