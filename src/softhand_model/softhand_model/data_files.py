"""Data files of the package, and how users refer to them."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from softhand_common.documents.quoted import unknown
from softhand_common.documents.yaml_document import is_document


def data_file(*parts: str) -> Path:
    """Path of a file in the package's folder data/."""
    return Path(str(resources.files("softhand_model"))).joinpath("data", *parts)


def shipped_names(folder: str) -> list[str]:
    """Names of the shipped YAML files in a folder of data/."""
    return sorted(path.stem for path in data_file(folder).glob("*.yaml"))


def find_document(name: str | Path, folder: str, kind: str) -> Path:
    """The shipped file of that name in data/<folder>, or else the file at that path.

    kind: what the file describes, for the message. Raises ValueError if there is no such file; the
    message has the names that exist.
    """
    if str(name) in shipped_names(folder):
        return data_file(folder, f"{name}.yaml")
    if is_document(name):
        return Path(name)
    raise ValueError(
        f"{kind}: expected one of {', '.join(shipped_names(folder))} or the path of a YAML file, "
        f"got {unknown(name, shipped_names(folder))}"
    )
