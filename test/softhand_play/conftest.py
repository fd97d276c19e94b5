"""The machine's browser, and pages in it."""

import pytest
from browser import find_browser
from play_page import SELDOM, SOFTWARE, WINDOW, Window


@pytest.fixture(scope="session")
def chromium():
    """The machine's browser, driven by Playwright."""
    path = find_browser()
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=SOFTWARE)
        yield browser
        browser.close()


@pytest.fixture
def open_window(chromium):
    """Opens pages in windows that are closed after the test."""
    contexts = []

    def open_one(page):
        contexts.append(chromium.new_context(viewport=WINDOW))
        contexts[-1].add_init_script(SELDOM)
        return Window(contexts[-1].new_page(), page.server.address)

    yield open_one
    for context in contexts:
        context.close()
