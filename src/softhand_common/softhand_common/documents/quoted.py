"""Values from outside, shortened so that they fit into a message or a log line."""

from __future__ import annotations

import reprlib
from collections.abc import Iterable
from difflib import get_close_matches
from itertools import islice

LONGEST_QUOTE = 200  # characters
SUGGESTION_CUTOFF = 0.4  # similarity by difflib from which on a name is suggested
_CUT = " ..."

_SHORT = reprlib.Repr()  # visits only the entries that it shows, also in nested lists
_SHORT.maxlevel = 3
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxdict = _SHORT.maxset = _SHORT.maxarray = 12
_SHORT.maxstring = _SHORT.maxlong = _SHORT.maxother = LONGEST_QUOTE


def quoted(value: object) -> str:
    """The `repr` of a value, shortened to LONGEST_QUOTE characters.

    >>> quoted("effort"), len(quoted("x" * 10_000_000))
    ("'effort'", 200)
    """
    return shortened(_SHORT.repr(value))


def listed(names: Iterable[object]) -> str:
    """Names separated by commas, shortened to LONGEST_QUOTE characters; `none` for no names.

    >>> listed(["a", "b"])
    'a, b'
    """
    entries = (shortened(str(name)) for name in islice(names, LONGEST_QUOTE))
    return shortened(", ".join(entries)) or "none"


def unknown(name: object, known: Iterable[str]) -> str:
    """An unknown name, quoted, with the most similar known name if one is similar.

    >>> unknown("rbo_hand", ["rbo_hand_2", "single_finger"])
    "'rbo_hand'; did you mean rbo_hand_2?"
    """
    near = get_close_matches(str(name)[:LONGEST_QUOTE], list(known), n=1, cutoff=SUGGESTION_CUTOFF)
    return quoted(str(name)) + (f"; did you mean {near[0]}?" if near else "")


def shortened(text: str) -> str:
    r"""Text as one line of at most LONGEST_QUOTE characters.

    >>> shortened("two\nlines")
    'two\\nlines'
    """
    start = text[: LONGEST_QUOTE + 1]
    line = "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in start)
    return line if len(line) <= LONGEST_QUOTE else line[: LONGEST_QUOTE - len(_CUT)] + _CUT
