"""The experiments by name."""

import importlib
from types import ModuleType

EXPERIMENTS = (
    "pulse_error",
    "supply_rejection",
    "six_channels",
    "long_run",
    "finger_posture",
    "drift_pulses",
    "choke_size",
    "valve_speed",
    "dead_volume",
    "scheduled_events",
    "flow_function",
)


def experiment(name: str) -> ModuleType:
    """Return the module of an experiment.

    Raises:
        ValueError: no such experiment; the message lists them.
    """
    if name not in EXPERIMENTS:
        raise ValueError(f"experiment: expected one of {', '.join(EXPERIMENTS)}, got {name}")
    return importlib.import_module(f"pneumaticbox_driver.experiments.{name}")
