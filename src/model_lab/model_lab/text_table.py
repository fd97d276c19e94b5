"""Tables of text with aligned columns."""

from __future__ import annotations

from collections.abc import Sequence


def text_table(rows: Sequence[Sequence[str]], indent: str = "  ") -> str:
    """Rows of cells, the first a header; columns of numbers are aligned to the right.

    >>> print(text_table([["run", "error"], ["a", "1.5"], ["b", "10"]]))
      run  error
      a      1.5
      b       10
    """
    columns = [[row[place] for row in rows] for place in range(len(rows[0]))]
    padded = [_padded(column) for column in columns]
    return "\n".join(indent + "  ".join(cells).rstrip() for cells in zip(*padded, strict=True))


def _padded(column: Sequence[str]) -> list[str]:
    width = max(len(cell) for cell in column)
    numbers = all(_is_number(cell) for cell in column[1:]) and len(column) > 1
    return [cell.rjust(width) if numbers else cell.ljust(width) for cell in column]


def _is_number(cell: str) -> bool:
    text = cell.removesuffix("%").strip()
    return (
        not text or text.lstrip("-").replace(".", "", 1).replace("e-", "").isdigit() or text == "-"
    )
