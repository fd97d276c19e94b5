"""Parts of a run that are kept in its folder, so that a stopped run continues."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from softhand_common.documents.output_file import write_json


def kept(path: Path, compute: Callable[[], Any]) -> Any:
    """What a JSON file has; computed and written first where there is no such file. Its name has to
    tell all parameters it depends on.
    """
    if not path.exists():
        write_json(path, {"found": compute()})
    return json.loads(path.read_text(encoding="utf-8"))["found"]
