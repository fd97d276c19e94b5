"""The table of the springs on the simulator's page is the one that its command prints."""

from pathlib import Path

from bench.spring_axes import markdown

PAGE = Path(__file__).parents[2] / "docs" / "understand" / "simulator-springs.md"


def test_the_page_holds_the_table_of_today():
    assert markdown() in PAGE.read_text(encoding="utf-8")
