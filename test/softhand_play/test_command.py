"""Options of `softhand-play` that cannot be used."""

import socket

import pytest

from softhand_play.command import main


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--port", "99999"], "expected 0 to 65535, got '99999'"),
        (["--hand", "nohand"], "hand: expected one of"),
        (["--hand", "rbo_hand"], "did you mean rbo_hand_"),
        (["--object", "cylindr"], "did you mean cylinder?"),
        (["--scene", "tabel"], "did you mean table?"),
        (["--strategy", "surface_constrain"], "did you mean surface_constrained?"),
        (["--strategy", "none.yaml"], "none.yaml: expected a readable file"),
        (["--files", "/no/such/folder"], "expected a folder"),
        (["--host", "no.such.host.invalid"], "host: expected an address"),
    ],
)
def test_an_option_that_cannot_be_used_ends_in_one_line(options, said, capsys):
    assert ended(options) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("softhand-play: ")
    assert said in line


def test_a_port_in_use_ends_in_one_line(capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert ended(["--port", str(port)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"expected a free port, got {port}" in line


def ended(options):
    try:
        return main(options)
    except SystemExit as end:
        return end.code
