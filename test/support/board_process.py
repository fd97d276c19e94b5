"""Starts the simulated board of valve_board.py and hears what it tells."""

import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import yaml

SUPPORT = Path(__file__).parent
EXAMPLES = SUPPORT.parents[1] / "examples" / "valve_boards"
LINKS = ("TCP", "serial")


@dataclass(frozen=True)
class Event:
    """What the board tells: monotonic time [s], name and words."""

    time: float
    name: str
    words: tuple[str, ...]


class BoardProcess:
    """The simulated board behind TCP or a serial line, and a hardware file for it.

    A context manager, at whose end the process has ended. `events` grows.

    Args:
        link: of LINKS.
        folder: for hardware file and serial line.
        vent_time: of the hardware file [s].
        options: further arguments of valve_board.py.
    """

    def __init__(self, link, folder, vent_time=0.2, options=()):
        self.events = []
        serial = ["--serial", str(folder / "tty")] if link == "serial" else []
        self._process = subprocess.Popen(
            [sys.executable, str(SUPPORT / "valve_board.py"), *serial, *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.address = self._process.stdout.readline().split()[1]
        self.settings = (
            {"path": self.address} if serial else {"host": "127.0.0.1", "port": int(self.address)}
        )
        self._reader = threading.Thread(target=self._hear)
        self._reader.start()
        kind = "SerialBoard" if serial else "NetworkBoard"
        self.hardware_file = folder / "hardware.yaml"
        document = {"format": "pneumaticbox-hardware/1", "board": f"text_board:{kind}"}
        document |= {"settings": self.settings, "vent_time": vent_time}
        self.hardware_file.write_text(yaml.safe_dump(document))

    def _hear(self):
        for line in self._process.stdout:
            time_told, name, *words = line.split()
            self.events.append(Event(float(time_told), name, tuple(words)))

    def switch(self, fault):
        """Switch to a fault, or to `none`; returns when the board has done so, with its time."""
        seen = len(self.events)
        self._process.stdin.write(f"{fault}\n")
        self._process.stdin.flush()
        return self.wait("fault", (fault,), seen).time

    def wait(self, name, words, seen=0):
        """The first event of this name with these words, after `seen` events, when it comes."""
        end = time.monotonic() + 10.0
        while time.monotonic() < end:
            for event in self.events[seen:]:
                if event.name == name and event.words == words:
                    return event
            time.sleep(0.001)
        raise RuntimeError(f"expected of the board {name} {words}, got {self.events[-5:]}")

    def last(self, name, after=0.0):
        """The last event of a name after a monotonic time [s], or None."""
        return next((e for e in reversed(self.events) if e.name == name and e.time > after), None)

    @property
    def inflating(self):
        """Whether the valves that it was told last inflate a channel."""
        told = self.last("told")
        return told is not None and any(word.endswith(":1") for word in told.words)

    def inflated_since(self, begun):
        """Whether it was told to inflate a channel after a monotonic time [s]."""
        return any(
            event.name == "told"
            and event.time > begun
            and any(w.endswith(":1") for w in event.words)
            for event in list(self.events)
        )

    @property
    def opened(self):
        """Monotonic time [s] since which the valves that it was told open all outlets; or None."""
        told = self.last("told")
        is_open = told is not None and all(word.endswith(":-1") for word in told.words)
        return told.time if is_open else None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.stdin.close()
        self._process.wait(10.0)
        self._reader.join()
        self._process.stdout.close()
