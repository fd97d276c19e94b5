"""Writing of model files, which simulator, monitor and lab load."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import yaml

from model_lab.new_file import check_new, plain, write_new
from softhand_model.effects import Effect
from softhand_model.model_file import FORMAT, Model
from softhand_model.spring_model import THESIS

NOT_PHYSICS = "a generic term, not physics"


def write_model(path: Path, model: Model, comment: str = "", force: bool = False) -> None:
    """Write a model file that `softhand_model.model_file.load_model` reads back equal.

    Files of effects that are not built in (`model.files`) are named relative to the model file, so
    that both can move together.

    Args:
        path: the model file, `.yaml` or `.yml`.
        model: what it holds.
        comment: its first lines, each behind a #.
        force: whether a file there may be overwritten.

    Raises:
        ValueError: the file exists and `force` is false, its name is no YAML file's, it cannot be
            written.
    """
    check_model_file(path, force)
    write_new(path, model_text(model, path.parent, comment), force)


def check_model_file(path: Path, force: bool = False) -> None:
    """Raise ValueError if a model file of that name could not be written or not be loaded."""
    if path.suffix not in (".yaml", ".yml"):
        raise ValueError(
            f"{path}: expected the name of a YAML file, got {path.suffix or 'no'} suffix"
        )
    check_new(path, force)


def model_text(model: Model, folder: Path, comment: str = "") -> str:
    """The text of a model file that lies in a folder."""
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    lines += [f"format: {FORMAT}", f"base: {model.base}"]
    if model.calibration:
        lines.append(f"calibration: {_in_one_line(model.calibration)}")
    if model.springs != THESIS:
        lines.append(f"springs: {_in_one_line(asdict(model.springs))}")
    if model.effects:
        lines.append("effects:")
        lines += [
            f"  - {_in_one_line(_entry(model, effect, folder))}{_remark(effect)}"
            for effect in model.effects
        ]
    return "\n".join(lines) + "\n"


def _entry(model: Model, effect: Effect, folder: Path) -> dict[str, Any]:
    entry: dict[str, Any] = {"name": effect.name}
    if effect.name in model.files:
        file = os.path.relpath(model.files[effect.name].resolve(), folder.resolve())
        entry["file"] = Path(file).as_posix()
    if effect.values:
        entry["parameters"] = dict(effect.values)
    std = plain(dict(model.std.get(effect.name, {})))
    known = {name: value for name, value in std.items() if value is not None}
    return entry | ({"std": known} if known else {})


def _remark(effect: Effect) -> str:
    return "" if effect.physical else f"  # {NOT_PHYSICS}"


def _in_one_line(value: Mapping[str, Any]) -> str:
    text = yaml.safe_dump(
        plain(_as_dict(value)),
        default_flow_style=True,
        sort_keys=False,
        allow_unicode=True,
        width=float("inf"),
    )
    return str(text).strip()


def _as_dict(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _as_dict(entry) for key, entry in value.items()}
    return value
