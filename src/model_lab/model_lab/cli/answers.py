"""Cache of the results of `diagnose`, so that `plan` need not search again.

`diagnose` writes its answer to `--json`, to the folder of its report and to a cache. An answer
holds a fingerprint of set, model and effects, so that the answer for another set is not used.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import warnings
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from model_lab.diagnosis.result import DIAGNOSIS_FORMAT
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_common.documents.json_document import read_json
from softhand_common.documents.output_file import UnwritableFile, write_json
from softhand_model.model_file import Model

ANSWER = "report.json"  # beside the page of a report
PACKAGES = ("model_lab", "softhand_model")  # on whose code an answer depends


def fingerprint(arguments: argparse.Namespace, model: Model, data: MeasurementSet) -> str:
    """A hexadecimal hash of all that the answer of `diagnose` depends on but the code:
    measurements, model, effects that are searched, and seed.
    """
    key = hashlib.sha256()
    given = Path(arguments.model)
    key.update(given.read_bytes() if given.is_file() else arguments.model.encode())
    for path in [*model.files.values(), *arguments.effects]:
        key.update(Path(path).read_bytes())
    key.update(repr((model.free_modulus, arguments.seed, data.experiment, data.noise)).encode())
    for specimen in data.specimens.values():
        key.update(f"{specimen.name} {specimen.mount} {specimen.batch}".encode())
        for name, value in specimen.values.items():
            key.update(name.encode() + np.asarray(value, float).tobytes())
    for run in data.runs:
        about = (run.name, run.specimen, run.protocol, run.temperature, run.virgin, run.steady)
        key.update(repr((*about, run.mode)).encode())
        for name, values in (*run.columns.items(), *run.lead.items()):
            key.update(name.encode() + np.asarray(values, float).tobytes())
    return key.hexdigest()[:32]


def keep(answer: dict[str, Any]) -> None:
    """Write the answer of `diagnose` to the cache. If that fails, a warning is given, and `plan`
    will search again.
    """
    try:
        write_json(_cached(answer["fingerprint"]), answer, force=True)
    except UnwritableFile as reason:
        warnings.warn(f"{reason}; so `model-lab plan` has to diagnose again", stacklevel=2)


def kept(place: Path | None, expected: str) -> dict[str, Any] | None:
    """The cached answer of `diagnose` for this set, model and effects; None without one.

    Args:
        place: file of the answer, or folder of the report that holds it; None: look in the cache.
        expected: fingerprint of set, model and effects as they are now.

    Returns the answer as in the JSON file [SI units]; None if the cache has none. Raises ValueError
    if the file at `place` cannot be read, or if its answer has another fingerprint.
    """
    path = _cached(expected) if place is None else place / ANSWER if place.is_dir() else place
    if place is None and not path.is_file():
        return None
    answer: dict[str, Any] = read_json(path, DIAGNOSIS_FORMAT).value
    if answer.get("fingerprint") != expected:
        raise ValueError(
            f"{path}: expected a diagnosis of this set with this model and these effects, got one "
            "of others, or of earlier versions of them; run `model-lab diagnose` again"
        )
    return answer


def _cached(name: str) -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "softhand" / "diagnoses" / f"{name}_{_code()}.json"


@lru_cache(maxsize=1)
def _code() -> str:
    """A name of the code that answers."""
    key = hashlib.sha256()
    for package in PACKAGES:
        root = Path(str(files(package)))
        for path in sorted([*root.rglob("*.py"), *root.rglob("*.json")]):
            key.update(path.read_bytes())
    return key.hexdigest()[:16]
