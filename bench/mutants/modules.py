"""The modules that decide, and the tests that have to see a bug in each."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """A module and its tests. interpreted: its compiled code is run as Python, as mutated."""

    module: str
    tests: tuple[str, ...]
    interpreted: bool = False


DRIVER = "test/pneumaticbox_driver"
MODULES = (
    Row("grasp_strategies.judge", ("test/grasp_strategies/test_judge.py",)),
    Row("grasp_strategies.sequencer", ("test/grasp_strategies/test_sequencer.py",)),
    Row("pneumaticbox_driver.safety", (f"{DRIVER}/test_safety.py",)),
    Row(
        "pneumaticbox_driver.faults.fault_watch",
        (f"{DRIVER}/faults/test_frozen_reading.py", f"{DRIVER}/faults/test_fault_watch.py"),
    ),
    Row(
        "pneumaticbox_driver.faults.pulse_effect",
        (f"{DRIVER}/faults/test_pulse_effect.py", f"{DRIVER}/faults/test_fault_watch.py"),
    ),
    Row("pneumaticbox_driver.modes", (f"{DRIVER}/test_modes.py",)),
    Row("pneumaticbox_driver.control.channels", (f"{DRIVER}/control",)),
    Row("pneumaticbox_driver.control.interface", (f"{DRIVER}/control",)),
    Row("pneumaticbox_driver.control.mass", (f"{DRIVER}/control",), interpreted=True),
    Row("pneumaticbox_driver.control.pulsewise", (f"{DRIVER}/control",)),
    Row("pneumaticbox_driver.observer.observer", (f"{DRIVER}/observer",)),
    Row("pneumaticbox_driver.observer.pulses", (f"{DRIVER}/observer",), interpreted=True),
    Row("pneumaticbox_driver.observer.coefficients", (f"{DRIVER}/observer",)),
    Row("pneumaticbox_driver.observer.volume_model", (f"{DRIVER}/observer",)),
    Row("pneumaticbox_driver.observer.drift", (f"{DRIVER}/observer",)),
    Row("pneumaticbox_driver.observer.zeroing", (f"{DRIVER}/observer",)),
    Row("softhand_model.hand.section", ("test/softhand_model/hand/test_section.py",)),
    Row(
        "softhand_model.equilibrium.joint_springs",
        ("test/softhand_model/equilibrium/test_joint_springs.py",),
    ),
    Row(
        "pneuflex_sim.dynamics.joint_springs",
        ("test/pneuflex_sim/dynamics/test_joint_springs.py",),
        interpreted=True,
    ),
    Row("model_lab.fitting.noise_floor", ("test/model_lab/fitting/test_noise_floor.py",)),
    Row("model_lab.diagnosis.selection", ("test/model_lab/diagnosis/test_selection.py",)),
    Row("model_lab.diagnosis.verdict", ("test/model_lab/diagnosis/test_verdict.py",)),
)
