"""The model lab: compare the model with measurements, name what is missing, add it.

    >>> import model_lab as lab
    >>> data = lab.load("my_set")  # doctest: +SKIP
    >>> found = lab.diagnose(data, "base")  # doctest: +SKIP
    >>> model = lab.add(found.effects, data, "base")  # doctest: +SKIP
    >>> lab.compare(data, model).plot()  # doctest: +SKIP

Results print themselves, in a notebook with curves and tables. The module behind each name is
loaded when that name is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from model_lab.api.data import from_frames, import_files, load, synthesize
    from model_lab.api.model import add, load_model, predict
    from model_lab.api.questions import compare, diagnose, ladder, learn

_HOMES = {
    "load": "data",
    "from_frames": "data",
    "import_files": "data",
    "synthesize": "data",
    "load_model": "model",
    "add": "model",
    "predict": "model",
    "compare": "questions",
    "diagnose": "questions",
    "learn": "questions",
    "ladder": "questions",
}  # module of `model_lab.api` by name

__all__ = [
    "add",
    "compare",
    "diagnose",
    "from_frames",
    "import_files",
    "ladder",
    "learn",
    "load",
    "load_model",
    "predict",
    "synthesize",
]


def __getattr__(name: str) -> Any:
    """A name of the interface, loaded at its first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.api.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
