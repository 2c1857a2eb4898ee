"""A browser for each file of tests; the file says by its fixture `report` which page it opens."""

import pytest
from chromium import Chromium


@pytest.fixture(scope="module")
def browser():
    with Chromium() as chromium:
        yield chromium


@pytest.fixture
def page(browser, report):
    browser.events.clear()
    browser.resize(1400)
    browser.open(report)
    return browser
