"""The report in a real browser: nothing fetched, nothing on the console, accessible, usable on a phone.

Needs Chromium and axe-core; without them these tests are skipped and say so. ``REPORT_PAGE`` names a report to drive
in place of the example, and ``AXE_CORE`` an ``axe.min.js`` in place of the one of the package axe-core-python.
"""

import importlib.util
import os
from pathlib import Path
from urllib.parse import unquote

import pytest
from chromium import find_chromium
from report_example import make_example

from repro.report.page import write_report

WIDTHS = (390, 1400)
#: What an empty cell of the ledger shows.
NOTHING = "\N{EN DASH}"


def find_axe():
    """Path of axe-core's script, or None."""
    if "AXE_CORE" in os.environ:
        return Path(os.environ["AXE_CORE"])
    package = importlib.util.find_spec("axe_core_python")
    return Path(package.submodule_search_locations[0]) / "axe.min.js" if package else None


pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not find_chromium(), reason="no Chromium on this machine (Debian: chromium)"),
]


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A report that lies where its links to files beside it lead."""
    if "REPORT_PAGE" in os.environ:
        return Path(os.environ["REPORT_PAGE"]).resolve()
    inputs = make_example(tmp_path_factory.mktemp("project"))
    write_report(inputs)
    return inputs.page


def column(page, number):
    """Texts of a column of the ledger's visible rows."""
    rows = "[...document.querySelectorAll('#ledger tbody tr:not([hidden])')]"
    return page.evaluate(f"{rows}.map(row => row.cells[{number}].dataset.value ?? row.cells[{number}].textContent)")


def numbers(texts):
    return [float(text) for text in texts if text != NOTHING]


def test_nothing_is_fetched_and_nothing_is_said_on_the_console(page, report):
    page.evaluate("new Promise(done => setTimeout(done, 300))")
    urls = {request["request"]["url"] for request in page.seen("Network.requestWillBeSent")}
    assert report.as_uri() in urls
    assert {url for url in urls if not url.startswith("data:")} == {report.as_uri()}
    assert not page.seen("Runtime.exceptionThrown")
    assert not page.seen("Runtime.consoleAPICalled")
    assert not page.seen("Log.entryAdded")


def test_the_policy_of_the_page_forbids_every_request(page):
    assert page.evaluate("fetch('https://example.org/').then(() => 'fetched', () => 'refused')") == "refused"
    assert "connect-src" in page.seen("Log.entryAdded")[0]["entry"]["text"]


@pytest.mark.parametrize("width", WIDTHS)
def test_the_page_does_not_scroll_sideways(page, width):
    page.resize(width)
    page.evaluate("document.querySelectorAll('details').forEach(part => part.open = true)")
    sizes = page.evaluate("[document.documentElement.scrollWidth, document.body.scrollWidth, innerWidth]")
    assert max(sizes[:2]) <= sizes[2] == width
    outside = page.evaluate(
        "[...document.querySelectorAll('main *:not(.unseen)')].filter(part => !part.closest('.scroll')"
        " && part.getBoundingClientRect().right > innerWidth + 1).map(part => part.outerHTML.slice(0, 80))"
    )
    assert outside == []


def test_every_link_leads_somewhere_and_every_anchor_is_there_once(page, report):
    anchors = page.evaluate("[...document.querySelectorAll('[id]')].map(part => part.id)")
    assert len(anchors) == len(set(anchors))
    links = page.evaluate("[...document.links].map(link => [link.getAttribute('href'), link.download])")
    assert len(links) > 100
    for href, download in links:
        if href.startswith("#"):
            assert unquote(href[1:]) in anchors, href
        elif href.startswith("data:"):
            assert download, href[:60]
        else:
            assert (report.parent / unquote(href)).is_file(), href


def test_the_ledger_is_searched_and_filtered(page):
    everything = len(column(page, 0))
    word = column(page, 6)[-1]
    page.evaluate(
        f"(box => {{ box.value = {word.upper()!r}; box.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
        "(document.getElementById('search'))"
    )
    assert 0 < len(column(page, 0)) < everything
    assert page.evaluate("document.getElementById('shown').textContent").startswith(f"{len(column(page, 0))} of ")
    page.evaluate("document.querySelector('#filters [type=reset]').click()")
    page.evaluate("new Promise(done => setTimeout(done, 50))")
    assert len(column(page, 0)) == everything
    for field, place in (("verdict", 1), ("place", 6), ("basis", 7)):
        wanted = column(page, place)[-1]
        choose = "(box => {{ box.value = {!r}; box.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
        box = f"(document.querySelector('[data-filter={field}]'))"
        page.evaluate(choose.format(wanted) + box)
        assert set(column(page, place)) == {wanted}
        page.evaluate(choose.format("") + box)
    page.evaluate("document.getElementById('asserted').click()")
    assert 0 < len(column(page, 0)) < everything
    assert all("asserted" in text for text in column(page, 0))


def test_the_ledger_is_sorted_by_the_buttons_in_its_header(page):
    press = "document.querySelectorAll('#ledger thead th button')[{}].click()"
    state = "[...document.querySelectorAll('#ledger thead th')].map(head => head.getAttribute('aria-sort'))"
    for place in (2, 3, 4, 5):
        page.evaluate(press.format(place))
        rising = column(page, place)
        assert numbers(rising) == sorted(numbers(rising))
        assert NOTHING not in rising[: len(numbers(rising))]
        assert [name for name in page.evaluate(state) if name] == ["ascending"]
        assert page.evaluate(state)[place] == "ascending"
        page.evaluate(press.format(place))
        falling = column(page, place)
        assert numbers(falling) == sorted(numbers(falling), reverse=True)
        assert NOTHING not in falling[: len(numbers(falling))]
        assert page.evaluate(state)[place] == "descending"
    page.evaluate(press.format(1))
    assert column(page, 1) == sorted(column(page, 1))


def test_a_link_to_a_hidden_row_shows_it(page):
    claim = page.evaluate("document.querySelector('#ledger tbody tr:last-child').id")
    hidden = f"document.getElementById({claim!r}).hidden"
    page.evaluate(
        "(box => { box.value = 'zzz'; box.dispatchEvent(new Event('input', {bubbles: true})); })"
        "(document.getElementById('search'))"
    )
    assert page.evaluate(hidden)
    page.evaluate(f"location.hash = '#' + {claim!r}")
    page.evaluate("new Promise(done => setTimeout(done, 200))")
    assert not page.evaluate(hidden)


def test_the_keyboard_reaches_the_report_first_and_every_scrolling_part(page):
    page.send("Input.dispatchKeyEvent", type="keyDown", key="Tab", code="Tab", windowsVirtualKeyCode=9)
    assert page.evaluate("document.activeElement.getAttribute('href')") == "#main"
    scrolling = page.evaluate("[...document.querySelectorAll('.scroll')].map(part => [part.tabIndex, part.ariaLabel])")
    assert all(index == 0 and label for index, label in scrolling)
    assert len({label for _, label in scrolling}) == len(scrolling)


def test_a_command_is_copied_or_at_least_selected(page):
    page.evaluate("document.querySelector('.command button').click()")
    page.evaluate("new Promise(done => setTimeout(done, 200))")
    assert page.evaluate("document.querySelector('.command button').textContent") in ("Copied", "Selected")


def test_the_ledger_can_be_read_without_scripts(browser, report):
    browser.send("Emulation.setScriptExecutionDisabled", value=True)
    try:
        browser.open(report)
        root = browser.send("DOM.getDocument")["root"]["nodeId"]
        rows = browser.send("DOM.querySelectorAll", nodeId=root, selector="#ledger tbody tr:not([hidden])")["nodeIds"]
        buttons = browser.send("DOM.querySelectorAll", nodeId=root, selector="#ledger button")["nodeIds"]
        assert len(rows) >= 50
        assert not buttons
    finally:
        browser.send("Emulation.setScriptExecutionDisabled", value=False)


@pytest.mark.skipif(not find_axe(), reason="no axe-core (pip: axe-core-python; or AXE_CORE=axe.min.js)")
@pytest.mark.parametrize(("width", "scheme"), [*zip(WIDTHS, ("light", "dark"), strict=True)])
def test_axe_core_finds_no_violation(page, width, scheme):
    page.resize(width)
    page.colours(scheme)
    page.evaluate("document.querySelectorAll('details').forEach(part => part.open = true)")
    page.evaluate("document.querySelector('#ledger thead button').click()")
    page.evaluate(find_axe().read_text(encoding="utf-8"))
    found = page.evaluate(
        "axe.run(document, {resultTypes: ['violations']}).then(result => result.violations.map("
        "rule => rule.id + ': ' + rule.help + ' ' + rule.nodes.slice(0, 3).map(node => node.html).join(' ')))"
    )
    assert found == []
