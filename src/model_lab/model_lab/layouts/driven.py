"""Runs in which one input is driven over time: free bending, blocked tip, tension."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from model_lab.measurement import OUTPUTS, MeasurementSet, Run, Specimen
from model_lab.protocols import BANK

Array = NDArray[np.float64]

DURATION = 24.0  # [s] of a run
SAMPLES = 200
PEAKS = {"free_bending": 45e3, "blocked_tip": 45e3, "uniaxial": 2.0}  # [Pa], or stretch above 1
SHARES = (1.0, 1.0, 0.5, 0.5, 1.0, 2.0)  # of DURATION, by protocol
SPECIMENS = {
    "thin": {"length": 0.09, "height": 0.02, "width": 0.02, "wall": 0.0025, "side_wall": 0.0025},
    "thick": {"length": 0.09, "height": 0.02, "width": 0.02, "wall": 0.004, "side_wall": 0.0025},
}
SHARED = {"shear_modulus": 67e3, "mass": 0.035}
BAR = {"gauge_length": 0.033, "shear_modulus": 67e3}
SETTINGS = (  # temperature [K] and mount of each protocol in turn
    (293.15, "bending_plane_level"),
    (293.15, "base_up"),
    (313.15, "bending_plane_level"),
)


def driven_set(experiment: str) -> MeasurementSet:
    """Two actuators (of a strip one) under the protocols of the bank, some warm, some hanging."""
    runs = []
    specimens: dict[str, Specimen] = {}
    for repeat in "ab":
        for order, (protocol, share) in enumerate(zip(BANK, SHARES, strict=False)):
            warm, mount = SETTINGS[order % len(SETTINGS)]
            specimen = _specimen(experiment, order, mount)
            specimens[specimen.name] = specimen
            time, course = protocol.course(share * DURATION, PEAKS[experiment], SAMPLES)
            columns = {"time": time, **_driving(experiment, course)}
            columns[OUTPUTS[experiment][0]] = np.zeros(SAMPLES)
            name = f"r{order + 1}{repeat}"
            runs.append(Run(name, specimen.name, protocol.name, warm, columns))
    title = f"synthesised {experiment.replace('_', ' ')}"
    return MeasurementSet(experiment, title, specimens, tuple(runs))


def _driving(experiment: str, course: Array) -> dict[str, Array]:
    return {"stretch": 1.0 + course} if experiment == "uniaxial" else {"pressure": course}


def _specimen(experiment: str, order: int, mount: str) -> Specimen:
    if experiment == "uniaxial":
        return Specimen("bar", BAR, batch="A")
    kind = "thick" if order % 2 else "thin"
    if experiment == "blocked_tip":
        return Specimen(kind, {**SPECIMENS[kind], **SHARED}, batch="A")
    name = kind if mount == "bending_plane_level" else f"{kind}_{mount}"
    return Specimen(name, {**SPECIMENS[kind], **SHARED}, mount, "A")
