"""A standard output that cannot be written: one line on the standard error, never a traceback."""

import subprocess
import sys
from pathlib import Path

import pytest

from softhand_common.standard_output import DONE, LOST

MAIN = """import sys
from softhand_common.standard_output import with_checked_output

@with_checked_output("own")
def main(arguments=None):
    {}

sys.exit(main())
"""
SAID = "own: standard output: expected a place to write to, got No space left on device\n"
WAYS = {
    "little, which is written at the end": "print(1); return 0",
    "much, which is written at once": "print('x' * 10**6); return 0",
    "flushed": "print(1, flush=True); return 0",
    "with an error of its own": "print(1); return 2",
    "by an exit, as of --help": "print(1); sys.exit(0)",
    "where errors of files are caught": """
    try:
        print("x" * 10**6)
    except (OSError, ValueError) as reason:
        print(reason, file=sys.stderr)
        return 2
""",
}


def run(words, output):
    return subprocess.run(words, stdout=output, stderr=subprocess.PIPE, text=True)


@pytest.fixture
def full():
    with Path("/dev/full").open("w") as file:
        yield file


@pytest.mark.parametrize("body", WAYS.values(), ids=WAYS)
def test_a_full_disk_is_said_in_one_line(full, body):
    done = run([sys.executable, "-c", MAIN.format(body)], full)
    assert (done.returncode, done.stderr) == (LOST, SAID)


def test_a_reader_that_has_seen_enough_is_no_error():
    head = subprocess.Popen(["head", "-c", "1"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
    with head:
        body = "[print('x' * 10**5) for _ in range(100)]; return 0"
        done = run([sys.executable, "-c", MAIN.format(body)], head.stdin)
    assert (done.returncode, done.stderr) == (DONE, "")


def test_an_output_that_was_closed_from_the_start_is_no_error():
    script = f'exec {sys.executable} -c "$0" >&-'
    done = run(["sh", "-c", script, MAIN.format("print(1); return 3")], subprocess.DEVNULL)
    assert (done.returncode, done.stderr) == (3, "")


def test_what_is_written_and_returned_is_that_of_the_command(tmp_path):
    with (tmp_path / "said").open("w") as file:
        done = run([sys.executable, "-c", MAIN.format("print(1); return 3")], file)
    assert (done.returncode, (tmp_path / "said").read_text()) == (3, "1\n")


@pytest.mark.parametrize(
    "words", [["--help"], ["objects"], ["materials", "--help"], ["lab", "compare", "--help"]]
)
def test_commands_say_it(full, words):
    done = run([sys.executable, "-m", "softhand_bringup.command", *words], full)
    assert done.returncode == LOST
    *others, line = done.stderr.splitlines()
    assert all("pybullet build time" in other for other in others)
    assert ": standard output: expected a place to write to, got No space left" in line
