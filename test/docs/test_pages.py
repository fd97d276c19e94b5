"""README and documentation: links lead somewhere, and pages made from the code are current."""

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
GUIDES = [page for page in PAGES if page.parent.name in ("start", "use")]
MOST_WORDS, LONGEST_CELL, LONGEST_ITEM = 1200, 150, 60  # of a guide; a cell in characters


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_and_picture_of_a_page_exists(page):
    targets = re.findall(r"\]\(([^)#]+)", page.read_text())
    missing = [t for t in targets if "://" not in t and not (page.parent / t).exists()]
    assert not missing


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_no_mark_of_a_merge_is_left_in_a_page(page):
    assert not re.findall(r"^(?:<{7}|={7}|>{7})(?: .*)?$", page.read_text(), re.MULTILINE)


def own_words(page):
    """Text of a page without the parts that commands print."""
    return re.sub(r"<!-- printed by.*?<!-- end.*?-->", "", page.read_text(), flags=re.S)


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.name)
def test_a_guide_begins_with_its_question_and_is_short(page):
    title, _, question, *_ = page.read_text().splitlines()
    assert title.startswith("# ")
    assert question.endswith("?")
    assert len([word for word in page.read_text().split() if word != "|"]) <= MOST_WORDS


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.name)
def test_table_cells_and_list_items_of_a_guide_are_short(page):
    text = own_words(page)
    rows = [line for line in text.splitlines() if line.startswith("|")]
    cells = [cell.strip() for row in rows for cell in row.strip("|").split("|")]
    assert [cell for cell in cells if len(cell) > LONGEST_CELL] == []
    items = re.findall(r"^(?:\* |\d+\. ).+(?:\n {2,}\S.*)*", text, re.MULTILINE)
    assert [item for item in items if len(item.split()) > LONGEST_ITEM] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_file_of_the_repository_that_a_page_names_exists(page):
    named = re.findall(
        r"[`\s]((?:src|docs|scripts|requirements|test|bench)/[\w./-]+\w)", page.read_text()
    )
    assert not [name for name in named if not (ROOT / name).exists()]


def test_every_page_is_reached_from_the_readme():
    reached, fresh = set(), {ROOT / "README.md"}
    while fresh:
        reached |= fresh
        targets = {
            (page.parent / target).resolve()
            for page in fresh
            for target in re.findall(r"\(([\w./-]+\.md)\)", page.read_text())
        }
        fresh = targets - reached
    assert set(PAGES) <= reached


@pytest.mark.parametrize("name", ["errata", "effects"])
def test_a_page_that_is_made_from_docstrings_is_what_they_say(name):
    made = runpy.run_path(str(ROOT / f"scripts/list_{name}.py"))["page"]()
    assert (ROOT / f"docs/reference/{name}.md").read_text() == made, "run `make docs`"


def test_the_documented_parameters_are_those_of_the_nodes():
    tables = runpy.run_path(str(ROOT / "scripts" / "list_parameters.py"))["tables"]()
    assert tables in (ROOT / "docs" / "reference" / "topics-and-services.md").read_text()
