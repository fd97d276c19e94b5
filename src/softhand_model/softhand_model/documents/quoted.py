"""What came from outside, cut so that it can stand in a message or a log line."""

from __future__ import annotations

import reprlib
from collections.abc import Iterable
from itertools import islice

LONGEST = 200  # characters of what is quoted
_CUT = " ..."

_SHORT = reprlib.Repr()  # looks at no more than it shows, also of lists in lists
_SHORT.maxlevel = 3
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxdict = _SHORT.maxset = _SHORT.maxarray = 12
_SHORT.maxstring = _SHORT.maxlong = _SHORT.maxother = LONGEST


def quoted(value: object) -> str:
    """A value as Python writes it, of at most LONGEST characters.

    >>> quoted("effort"), len(quoted("x" * 10_000_000))
    ("'effort'", 200)
    """
    return shortened(_SHORT.repr(value))


def listed(names: Iterable[object]) -> str:
    """Names with commas between them, of at most LONGEST characters; `none` when there are none.

    >>> listed(["a", "b"])
    'a, b'
    """
    return shortened(", ".join(shortened(str(name)) for name in islice(names, LONGEST))) or "none"


def shortened(text: str) -> str:
    r"""Text in one line of at most LONGEST characters.

    >>> shortened("two\nlines")
    'two\\nlines'
    """
    line = "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in text[: LONGEST + 1])
    return line if len(line) <= LONGEST else line[: LONGEST - len(_CUT)] + _CUT
