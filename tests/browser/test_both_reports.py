"""Both reports in a real browser: nothing fetched, nothing on the console, accessible, usable on a phone and paper."""

from pathlib import Path
from urllib.parse import unquote

import pytest

pytestmark = pytest.mark.slow

WIDTHS = (390, 1280)


@pytest.fixture(scope="module", params=["reproduction", "identification"])
def report(request):
    return request.getfixturevalue(request.param)


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
    wide = page.evaluate(
        "[...document.querySelectorAll('.scroll:has(> table)')].filter(part => part.scrollWidth > part.clientWidth + 1)"
        ".map(part => part.getAttribute('aria-label'))"
    )
    assert wide == []


def test_every_link_leads_somewhere_and_every_anchor_is_there_once(page, report):
    anchors = page.evaluate("[...document.querySelectorAll('[id]')].map(part => part.id)")
    assert len(anchors) == len(set(anchors))
    links = page.evaluate("[...document.links].map(link => [link.getAttribute('href'), link.download])")
    assert len(links) > 10
    for href, download in links:
        if href.startswith("#"):
            assert unquote(href[1:]) in anchors, href
        elif href.startswith("data:"):
            assert download, href[:60]
        else:
            assert (report.parent / unquote(href)).is_file(), href


def test_the_keyboard_reaches_the_report_first_and_every_scrolling_part(page):
    page.send("Input.dispatchKeyEvent", type="keyDown", key="Tab", code="Tab", windowsVirtualKeyCode=9)
    assert page.evaluate("document.activeElement.getAttribute('href')") == "#main"
    scrolling = page.evaluate("[...document.querySelectorAll('.scroll')].map(part => [part.tabIndex, part.ariaLabel])")
    assert all(index == 0 and label for index, label in scrolling)
    assert len({label for _, label in scrolling}) == len(scrolling)


@pytest.mark.parametrize(("width", "scheme"), [*zip(WIDTHS, ("light", "dark"), strict=True)])
def test_axe_core_finds_no_violation(page, width, scheme):
    page.resize(width)
    page.colours(scheme)
    page.evaluate("document.querySelectorAll('details').forEach(part => part.open = true)")
    page.evaluate("document.querySelector('#ledger thead button')?.click()")
    axe = Path(pytest.importorskip("axe_core_python").__file__).parent / "axe.min.js"
    page.evaluate(axe.read_text(encoding="utf-8"))
    found = page.evaluate(
        "axe.run(document, {resultTypes: ['violations']}).then(result => result.violations.map("
        "rule => rule.id + ': ' + rule.help + ' ' + rule.nodes.slice(0, 3).map(node => node.html).join(' ')))"
    )
    assert found == []


@pytest.mark.parametrize("report", ["identification"], indirect=True, scope="module")
def test_every_picture_is_there_and_nothing_is_cut_off_on_paper(page):
    assert page.evaluate("[...document.images].every(image => image.complete && image.naturalWidth > 0)")
    page.send("Emulation.setEmulatedMedia", media="print")
    page.resize(702)  # A4 less its margins
    try:
        wide = page.evaluate(
            "[...document.querySelectorAll('main .scroll > *')]"
            ".filter(part => part.getBoundingClientRect().right > innerWidth + 1)"
            ".map(part => part.outerHTML.slice(0, 80))"
        )
    finally:
        page.send("Emulation.setEmulatedMedia", media="")
    assert wide == []
