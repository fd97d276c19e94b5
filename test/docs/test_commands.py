"""Each command line of README and documentation is understood by the parser of its command."""

import argparse
import re
import shlex
from importlib.util import find_spec
from pathlib import Path

import pytest

from model_lab.cli.main import main as model_lab
from softhand_bringup.command import NODES
from softhand_bringup.command import main as softhand
from thesis import frame
from thesis.__main__ import main as thesis
from thesis.__main__ import parser_of

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
COMMAND = re.compile(r"^ *(?:\.venv/bin/)?(softhand|model-lab|python|make) (.+)$")
MAINS = {"softhand": softhand, "model-lab": model_lab, "thesis": thesis}
TARGETS = set(re.findall(r"^([a-z-]+):.*##", (ROOT / "Makefile").read_text(), re.MULTILINE))


class Parsed(Exception):
    """The arguments were understood."""


def code_of(page):
    """Lines of the page's code blocks, continued lines joined."""
    text = re.sub(r"\\\n\s*", "", page.read_text())
    fenced = re.findall(r"^ *```\w*\n(.*?)^ *```", text, re.MULTILINE | re.DOTALL)
    indented = re.findall(r"^ {4,}\S.*$", text, re.MULTILINE)
    return [*indented, *(line for block in fenced for line in block.splitlines())]


def commands_of(page):
    """Name and words of each command, without comments and what follows in a pipe."""
    for found in filter(None, map(COMMAND.match, code_of(page))):
        words = shlex.split(found[2].partition("&&")[0], comments=True)
        end = next((words.index(mark) for mark in ("|", "&") if mark in words), None)
        if found[1] == "python" and words[:2] == ["-m", "thesis"]:
            yield "thesis", tuple(words[2:end])
        elif words[0] != "-":
            yield found[1], tuple(words[:end])


COMMANDS = sorted({(page.name, *command) for page in PAGES for command in commands_of(page)})


def test_the_pages_have_commands_to_check():
    assert {name for _, name, _ in COMMANDS} == {*MAINS, "python", "make"}


@pytest.fixture
def only_parse(monkeypatch):
    parse = argparse.ArgumentParser.parse_args

    def parsed(parser, arguments=None, namespace=None):
        parse(parser, arguments, namespace)
        raise Parsed

    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parsed)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda it: " ".join([it[0], it[1], *it[2]]))
def test_a_command_is_understood(command, only_parse):
    _, name, words = command
    if name == "make":
        assert {word for word in words if "=" not in word} <= TARGETS
    elif name == "python":
        assert find_spec(words[1]) if words[0] == "-m" else (ROOT / words[0]).exists()
    elif words[0] == "run" and name == "softhand":
        assert words[1] in NODES
        assert words[2:3] in ((), ("--ros-args",), ("--help",))
    elif words == ("--help",):
        assert name in MAINS
    else:
        with pytest.raises(Parsed):
            MAINS[name](list(words))
        if name == "thesis" and words[0] == "run":
            with pytest.raises(Parsed):
                parser_of(frame.experiment(words[1])).parse_args(list(words[2:]))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_python_of_a_page_is_python(page):
    for code in re.findall(r"^```python\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL):
        compile(code, page.name, "exec")
