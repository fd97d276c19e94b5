"""The site that `make site` builds: no warnings, no dead links, nothing from the network."""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
PAGES = sorted(path.relative_to(ROOT / "docs") for path in (ROOT / "docs").rglob("*.md"))


class Page(HTMLParser):
    """Anchors, links and loaded files of a page, and how many list items and cells it shows."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loaded, self.shown = set(), set(), set(), []
        self.in_text = False
        self.feed(path.read_text())

    def handle_starttag(self, tag, attrs):
        of = dict(attrs)
        self.anchors |= {of[key] for key in ("id", "name") if of.get(key)}
        if tag == "a" and of.get("href"):
            self.links.add(of["href"])
        elif tag in ("link", "script", "img"):
            self.loaded |= {of[key] for key in ("href", "src") if of.get(key)}
        self.in_text = self.in_text or tag == "article"
        if self.in_text and tag in ("li", "td", "img"):
            self.shown.append(tag)

    def handle_endtag(self, tag):
        self.in_text = self.in_text and tag != "article"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Folder of the site, built of a copy."""
    folder = tmp_path_factory.mktemp("project")
    shutil.copytree(ROOT / "docs", folder / "docs")
    shutil.copy(ROOT / "zensical.toml", folder)
    done = subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--clean", "--strict"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    printed = done.stdout + done.stderr
    assert done.returncode == 0, printed
    assert "WARNING" not in printed
    return folder / "site"


@pytest.fixture(scope="module")
def pages(site):
    return {path: Page(path) for path in site.rglob("*.html") if path.name != "404.html"}


def test_each_page_of_the_docs_is_in_the_site_and_its_navigation(site, pages):
    index = site / "index.html"
    assert set(pages) == {site / path.with_suffix(".html") for path in PAGES}
    reached, fresh = set(), {index}
    while fresh:
        reached |= fresh
        fresh = {target for path in fresh for target, _ in internal(path, pages[path].links)}
        fresh = (fresh & set(pages)) - reached
    assert reached == set(pages)


def internal(path, links):
    """File and anchor of each link that stays in the site."""
    for link in links:
        to = urlsplit(link)
        if not to.scheme:
            yield (path.parent / unquote(to.path)).resolve() if to.path else path, to.fragment


def test_each_link_leads_to_a_file_and_an_anchor_of_the_site(site, pages):
    dead = [
        (path.name, str(target), anchor)
        for path, page in pages.items()
        for target, anchor in internal(path, page.links | page.loaded)
        if not target.is_relative_to(site)
        or not target.exists()
        or (anchor and anchor not in pages[target].anchors)
    ]
    assert dead == []


def test_a_page_loads_nothing_from_the_network(pages):
    loaded = {name for page in pages.values() for name in page.loaded}
    assert [name for name in loaded if urlsplit(name).scheme or name.startswith("//")] == []


@pytest.mark.parametrize("name", PAGES, ids=str)
def test_the_site_shows_the_lists_tables_and_pictures_that_the_forge_shows(name, site, pages):
    text = (ROOT / "docs" / name).read_text()
    if "\n::: " in text:
        pytest.skip("its text stands in the docstrings")
    forge = MarkdownIt("commonmark").enable("table").render(text)
    assert pages[site / name.with_suffix(".html")].shown == re.findall(r"<(li|td|img)\b", forge)


def test_products_in_docstrings_keep_their_asterisks(site):
    for name in ("effects", "python/effects"):
        text = re.sub(r"<[^>]+>", "", (site / f"reference/{name}.html").read_text())
        assert "s*(1 + gain*r**n/(1 + r**n))" in text  # ballooning
