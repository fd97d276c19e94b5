"""Calls of the lab: a diagnosis and a comparison of a set on disk."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def diagnosis_of(folder: Path, seed: int, jobs: int = 1) -> dict[str, Any]:
    """The JSON of `model-lab diagnose` for a set, the base model given."""
    from model_lab.diagnosis.diagnose import diagnose_folder

    return diagnose_folder(folder, model="base", seed=seed, jobs=jobs)


def comparison_of(folder: Path) -> object:
    """What `model-lab compare` computes for a set, the base model given."""
    from model_lab.comparison.compare import compare
    from model_lab.measurements.load import load_measurements
    from softhand_model.model_file import load_model

    return compare(load_measurements(folder), load_model("base"))
