"""Damage to files: bytes that change, and values that a person or a program should not write."""

from __future__ import annotations

import json
import random
import re
from typing import Any

import yaml

TOKEN = "REPLACED-BY-RAW-TEXT"
LAUGHS = (
    "[&a [x, x, x, x, x, x, x, x, x, x], "
    + ", ".join(
        f"&{name} [{', '.join([f'*{before}'] * 10)}]"
        for before, name in zip("abcdefgh", "bcdefghi", strict=True)
    )
    + "]"
)
RAW_VALUES = (
    *(
        "",
        "null",
        "text",
        "''",
        "[]",
        "{}",
        "true",
        "no",
        "-1",
        "0",
        "1",
        "2.5",
        "[1, 2]",
        "[a, a]",
    ),
    *(".nan", ".inf", "-.inf", "1e308", "-1e308", "1e-320", "1e30", "-0.001", "1e7", "1e999"),
    *("9" * 400, "9" * 5000, "0x" + "f" * 500, "1" + ":59" * 2000, "0x_", "1_0", "0o17", "1:30"),
    *("[" * 5000, "[" * 100 + "]" * 100, "{a: " * 60 + "1" + "}" * 60, "&a [*a]", "*nowhere"),
    *("!!bool abc", "!!timestamp abc", "!!binary x", "!!python/name:os.system", "!own 1", "! 1"),
    *("2024-13-45", "2024-01-05", "2024-01-05T10:00:00Z", "12:30:45", "<<", "=", "? [1]", "| x"),
    *('"\\ud800"', '"\\0"', '"\\u202e"', "x" * 100_000, '"' + "ä" * 5000 + '"', "../" * 50 + "x"),
    *("/dev/zero", "/etc/passwd", "x" * 300 + ".yaml", "{self: 1}", "{'': 1}", "{1: 2}", LAUGHS),
    *("[" + "1, " * 30_000 + "1]", "km**999", "9**9**9", "m**9**9", "effort[999999]", "a.b.c.d"),
)
RAW_JSON = (
    *("", "null", "true", '""', '"text"', "[]", "{}", "-1", "0", "1", "2.5", "[1, 2]", '["a"]'),
    *("NaN", "Infinity", "1e999", "1e308", "-1e308", "1e-320", "1e7", "0.5", "-0.0", "[[0, 0]]"),
    *("9" * 400, "9" * 5000, "[" * 5000, "[" * 100_000, "[" * 100 + "]" * 100, "[NaN, NaN]"),
    *('"' + "x" * 100_000 + '"', '"\\ud800"', '"\\u0000"', '"\\u202e"', '{"": 1}', '{"a": {}}'),
    *("[" + "1, " * 30_000 + "1]", '"/etc/passwd"', '"' + "/" * 600 + '"', '"a\\nb"', "'x'"),
    *('["a", "a"]', "-Infinity", '"a/b"', '"../../x"', "[[[]]]", "{", "'"),
)
CELLS = (
    *(
        "",
        "nan",
        "inf",
        "-inf",
        "1e308",
        "-1e308",
        "1e400",
        "abc",
        '"',
        '"1',
        "1_0",
        "\uff11",
        "\0",
    ),
    *(
        "9" * 400,
        "9" * 200_000,
        "x" * 200_000,
        "1;2",
        "1,2",
        "-1",
        "0",
        "1e-320",
        "\n",
        "\r",
        "true",
    ),
)


def damaged(content: bytes, chance: random.Random) -> bytes:
    """Content with bytes changed, cut off, left out, put in or repeated."""
    data = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 5, 30))):
        start = chance.randrange(len(data) + 1)
        stop = min(len(data), start + chance.choice((1, 4, 60, 1000)))
        kind = chance.randrange(6)
        if kind == 0 and start < len(data):
            data[start] ^= 1 << chance.randrange(8)
        elif kind == 1:
            data[start:stop] = chance.randbytes(stop - start)
        elif kind == 2 and chance.random() < 0.5:
            del data[start:]
        elif kind == 3:
            del data[start:stop]
        elif kind == 4:
            data[start:start] = chance.randbytes(chance.choice((1, 8, 100)))
        elif kind == 5:
            data[start:start] = data[start:stop]
    return bytes(data)


def damaged_yaml(content: bytes, chance: random.Random) -> bytes:
    """A document with one place that holds what it should not, or a key too few or too many."""
    document = yaml.safe_load(content)
    kind = chance.randrange(10)
    if kind == 0:
        return _many_keys(content, chance)
    _change(document, kind, chance)
    text = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, allow_unicode=True)
    return text.replace(TOKEN, chance.choice(RAW_VALUES)).encode("utf-8", "surrogatepass")


def damaged_json(content: bytes, chance: random.Random) -> bytes:
    """Lines of JSON of which one is left out, doubled, or holds what it should not."""
    lines = content.decode().splitlines()
    number, kind = chance.randrange(len(lines)), chance.randrange(10)
    if kind == 0 and len(lines) > 1:
        lines[number : number + 1] = chance.choice(([], [lines[number]] * 2, ["[]"], [""]))
    else:
        document = json.loads(lines[number])
        _change(document, kind, chance)
        text = json.dumps(document, default=str)
        lines[number] = text.replace(f'"{TOKEN}"', chance.choice(RAW_JSON))
    return ("\n".join(lines) + "\n").encode("utf-8", "surrogatepass")


def _change(document: Any, kind: int, chance: random.Random) -> None:
    """Change one place of a document."""
    holder, key = chance.choice(list(_places(document)))
    if kind == 1:
        del holder[key]
    elif kind == 2 and isinstance(holder, dict):
        holder[f"{key}{chance.choice('sx_1')}"] = holder.pop(key)
    elif kind == 3 and isinstance(holder, dict):
        holder[chance.choice(("unknown", "x" * 150, "a.b", "é", 1, True, None))] = 1
    elif kind == 4 and isinstance(holder, list):
        holder.append(holder[key])
    elif kind == 5:
        other, its_key = chance.choice(list(_places(document)))
        holder[key] = yaml.safe_load(yaml.safe_dump(other[its_key]))
    elif isinstance(holder[key], int | float) and chance.random() < 0.5:
        holder[key] = _other_number(float(holder[key]), chance)
    else:
        holder[key] = TOKEN


def _places(node: Any) -> Any:
    """All (container, key) of a document."""
    pairs = list(node.items()) if isinstance(node, dict) else list(enumerate(node))
    for key, value in pairs:
        yield node, key
        if isinstance(value, dict | list):
            yield from _places(value)


def _other_number(value: float, chance: random.Random) -> float:
    return chance.choice(
        (-value, 1e3 * value, 1e-3 * value, 1e6 * value, 1e-9 * value, 1e12 * value, value + 1.0)
    )


def _many_keys(content: bytes, chance: random.Random) -> bytes:
    text = content.decode()
    lines = text.splitlines()
    if chance.random() < 0.5:  # a line twice is a key twice, mostly
        place = chance.randrange(len(lines))
        return "\n".join([*lines[:place], lines[place], *lines[place:]]).encode()
    number = chance.choice((100, 20_000))
    return (text + "\n" + "".join(f"key{index}: 1\n" for index in range(number))).encode()


def damaged_csv(content: bytes, chance: random.Random) -> bytes:
    """A table in which a cell, a row or the header is not what it should be."""
    rows = [line.split(",") for line in content.decode().splitlines()]
    row = chance.choice((0, chance.randrange(len(rows))))
    column = chance.randrange(len(rows[row]))
    kind = chance.randrange(8)
    if kind == 0:
        del rows[row]
    elif kind == 1:
        rows.insert(row, rows[chance.randrange(len(rows))])
    elif kind == 2:
        del rows[row][column]
    elif kind == 3:
        rows[0][column] = chance.choice((*CELLS, "time", "pressure", "tip_angle"))
    elif kind == 4:
        rows = rows[:1]
    else:
        for _ in range(chance.choice((1, 1, 20))):
            rows[chance.randrange(1, len(rows))][column] = chance.choice(CELLS)
    return "\n".join(",".join(cells) for cells in rows).encode()


def is_refusal(message: str, file: str) -> bool:
    """Whether a message names a file and a place in it: a line, a key, a row, a column, a topic."""
    _, found, rest = message.partition(file)
    if not found or "\n" in message or len(message) > LONGEST_MESSAGE:
        return False
    return re.match(r"(/\S+)?(:\d+)?: \S", rest) is not None


LONGEST_MESSAGE = 1500  # characters, paths among them
