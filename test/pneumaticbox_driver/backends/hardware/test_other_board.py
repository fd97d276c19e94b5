"""The board of one's own of docs/use/hardware.md: its text is run, against a microcontroller."""

import socketserver
import textwrap
import threading
from pathlib import Path

import numpy as np
import pytest

from pneumaticbox_driver.backends.hardware.opening import open_bench

PAGE = Path(__file__).parents[4] / "docs" / "use" / "hardware.md"


def shown(first_line):
    """The indented text of the page that begins with this line."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(f"    {first_line}"))
    end = next(i for i in range(start, len(lines)) if lines[i] and not lines[i].startswith(" "))
    return textwrap.dedent("\n".join(lines[start:end]))


class Microcontroller(socketserver.StreamRequestHandler):
    def handle(self):
        for line in self.rfile:
            words = line.decode().split()
            if words[0] == "valves":
                self.server.told.append(words[1:])
                answer = self.server.answer
            else:
                answer = "1000 2000 3000 300000"
            self.wfile.write(f"{answer}\n".encode())


@pytest.fixture
def controller():
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Microcontroller) as server:
        server.told, server.answer, server.daemon_threads = [], "ok", True
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        yield server
        server.shutdown()
        thread.join()


@pytest.fixture
def path(tmp_path, monkeypatch, controller):
    patient = shown('"""my_board.py').replace("timeout=0.1", "timeout=10.0")  # on a busy machine
    (tmp_path / "my_board.py").write_text(patient)
    monkeypatch.syspath_prepend(tmp_path)
    text = shown("format: pneumaticbox-hardware/1")
    text = text.replace("192.168.7.2", "127.0.0.1").replace("2.0", "0.0")
    path = tmp_path / "hardware.yaml"
    path.write_text(text.replace("4000", str(controller.server_address[1])))
    return path


def test_the_example_switches_reads_and_vents_at_the_end(path, controller):
    with open_bench(path, [3, 1], ambient=1e5, allow_board_module=True) as bench:
        bench.command([1, -1])
        np.testing.assert_allclose(bench.read(), [103e3, 101e3, 400e3])
        assert np.isfinite(bench.time)
    assert controller.told == [["3:+0", "1:+0"], ["3:+1", "1:-1"], ["3:-1", "1:-1"]]


def test_a_refusal_by_the_board_ends_in_an_error(path, controller):
    with open_bench(path, [1], allow_board_module=True) as bench:
        controller.answer = "busy"
        with pytest.raises(OSError, match="did not take the valves"):
            bench.command([1])
        controller.answer = "ok"
