"""A command of `model-lab` in a process of its own, so that the page stays responsive."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence

Done = Callable[[int, str], None]


class LabProcess:
    """Runs commands of `model-lab`, one at a time.

    Args:
        tell: called with each line of progress.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._process: subprocess.Popen[str] | None = None
        self._thread: threading.Thread | None = None

    @property
    def is_running(self) -> bool:
        """Whether a command runs."""
        return self._process is not None

    def start(self, words: Sequence[str], done: Done) -> None:
        """Start `model-lab` with these words. `done` is called with its return code and its output
        or error message, but not after `cancel`.

        Raises ValueError while another command runs.
        """
        if self.is_running:
            raise ValueError("lab: an earlier command still runs; wait until it ends, or cancel it")
        output = tempfile.TemporaryFile("w+")  # noqa: SIM115 (closed by the thread)
        self._process = process = subprocess.Popen(
            [sys.executable, "-m", "model_lab", *words],
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.PIPE,
            text=True,
        )

        def follow() -> None:
            last = ""
            with output, process:
                for line in process.stderr or ():
                    last = line.strip() or last
                    self._tell(last)
                code = process.wait()
                output.seek(0)
                text = output.read() if code == 0 else last
            if self._process is process:
                self._process = None
                done(code, text)

        self._thread = threading.Thread(target=follow, name="model-lab")
        self._thread.start()

    def cancel(self) -> None:
        """End the running command, if any, and wait for its end."""
        process, self._process = self._process, None
        if process is not None:
            process.terminate()
        if self._thread is not None:
            self._thread.join()
