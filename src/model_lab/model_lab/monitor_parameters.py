"""Parameters of the node `monitor`: default, description with unit, range. All are read-only."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Parameter:
    """One node parameter; `bounds` are the least and the greatest value, None for no range."""

    name: str
    default: float | str
    text: str
    bounds: tuple[float, float] | None = None


PARAMETERS = (
    Parameter("hand", "rbo_hand_2", "hand by name or path of its YAML"),
    Parameter("model_file", "", "softhand-model/1 file; empty: actuators with their weight"),
    Parameter("temperature", 293.15, "of the rubber [K]", (200.0, 500.0)),
    Parameter("window", 5.0, "measured time over which the residual is averaged [s]", (0.1, 600.0)),
    Parameter("warn_above", 0.05, "rms residual that is worth a warning [rad]", (0.0, 10.0)),
    Parameter("stale_after", 2.0, "wall time without a comparison that is stale [s]", (0.1, 600.0)),
    Parameter(
        "settle_time",
        0.1,
        "for which the pressure must have stood for a sample to count [s]; 0: all count",
        (0.0, 4.0),
    ),
    Parameter("settle_band", 1000.0, "within which a pressure counts as standing [Pa]", (0.0, 1e5)),
)
