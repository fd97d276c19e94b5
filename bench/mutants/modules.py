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
CONTROL, OBSERVER = f"{DRIVER}/control", f"{DRIVER}/observer"
KNOWN = f"{OBSERVER}/test_known_masses.py"
DECISIONS = f"{CONTROL}/test_decisions.py"
MODULES = (
    Row(
        "grasp_strategies.judging.judge",
        (
            "test/grasp_strategies/judging/test_judge.py",
            "test/grasp_strategies/judging/test_verdicts.py",
            "test/grasp_strategies/judging/test_failure.py",
        ),
    ),
    Row("grasp_strategies.judging.failure", ("test/grasp_strategies/judging/test_failure.py",)),
    Row("grasp_strategies.sequencer", ("test/grasp_strategies/test_sequencer.py",)),
    Row("pneumaticbox_driver.safety", (f"{DRIVER}/test_safety.py",)),
    Row(
        "pneumaticbox_driver.faults.fault_watch",
        (
            f"{DRIVER}/faults/test_frozen_reading.py",
            f"{DRIVER}/faults/test_fault_evidence.py",
        ),
    ),
    Row(
        "pneumaticbox_driver.faults.pulse_effect",
        (f"{DRIVER}/faults/test_pulse_effect.py", f"{DRIVER}/faults/test_fault_evidence.py"),
        interpreted=True,
    ),
    Row("pneumaticbox_driver.modes", (f"{DRIVER}/test_modes.py",)),
    Row(
        "pneumaticbox_driver.control.channels",
        (f"{CONTROL}/test_pulse_timing.py", DECISIONS),
    ),
    Row("pneumaticbox_driver.control.interface", (DECISIONS,)),
    Row("pneumaticbox_driver.control.mass", (DECISIONS,), interpreted=True),
    Row(
        "pneumaticbox_driver.control.pulsewise",
        (DECISIONS,),
    ),
    Row("pneumaticbox_driver.observer.observer", (f"{OBSERVER}/test_observer.py",)),
    Row(
        "pneumaticbox_driver.observer.pulses",
        (f"{OBSERVER}/test_pulses.py", f"{OBSERVER}/test_observer.py"),
        interpreted=True,
    ),
    Row(
        "pneumaticbox_driver.observer.coefficients",
        (f"{OBSERVER}/test_pulses.py", f"{OBSERVER}/test_observer.py"),
    ),
    Row("pneumaticbox_driver.observer.volume_model", (f"{OBSERVER}/test_volume_model.py",)),
    Row(
        "pneumaticbox_driver.observer.drift",
        (KNOWN, f"{OBSERVER}/test_drift_bound.py"),
    ),
    Row(
        "pneumaticbox_driver.observer.still_pressure", (f"{OBSERVER}/test_still_pressure.py", KNOWN)
    ),
    Row(
        "pneumaticbox_driver.observer.zeroing",
        (KNOWN,),
    ),
    Row("softhand_model.hand.section", ("test/softhand_model/hand/test_section.py",)),
    Row(
        "softhand_model.equilibrium.joint_springs",
        ("test/softhand_model/equilibrium/test_joint_springs.py",),
    ),
    Row(
        "softhand_model.dynamics.joint_springs",
        ("test/softhand_model/dynamics/test_joint_springs.py",),
        interpreted=True,
    ),
    Row("model_lab.fitting.noise_floor", ("test/model_lab/fitting/test_noise_floor.py",)),
    Row("model_lab.diagnosis.selection", ("test/model_lab/diagnosis/test_selection.py",)),
    Row("model_lab.diagnosis.criteria", ("test/model_lab/diagnosis/test_criteria.py",)),
)
