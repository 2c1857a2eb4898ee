"""Both reports in a real browser: nothing fetched, nothing on the console, accessible, usable on a phone and paper.

The ledger of the reproduction's report is searched, filtered and sorted.
"""

import itertools
from pathlib import Path
from urllib.parse import unquote

import pytest
from markdown_page import heading_anchors

pytestmark = pytest.mark.slow

WIDTHS = (390, 1280)
#: Removes rows with the elements, classes and parity of an earlier one of their table: they look alike.
REMOVE_ALIKE = """document.querySelectorAll('tbody').forEach(body => {
  const seen = new Set()
  for (const [k, row] of [...body.rows].entries()) {
    const look = [row, ...row.querySelectorAll('*')].map(part => part.tagName + part.className).join() + k % 2
    seen.has(look) ? row.remove() : seen.add(look)
  }
})"""


@pytest.fixture(scope="module", params=["reproduction", "identification"])
def report(request):
    return request.getfixturevalue(request.param)


def cut_off(page, selector):
    """Elements that reach beyond the right edge of the window."""
    beyond = "part.getBoundingClientRect().right > innerWidth + 1"
    parts = f"[...document.querySelectorAll('{selector}')].filter(part => {beyond})"
    return page.evaluate(f"{parts}.map(part => part.outerHTML.slice(0, 80))")


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
    assert cut_off(page, "main *:not(.unseen, .scroll, .scroll *)") == []
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
            file, _, heading = unquote(href).partition("#")
            assert (report.parent / file).is_file(), href
            assert not heading or heading in heading_anchors((report.parent / file).read_text(encoding="utf-8")), href


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
    page.evaluate(REMOVE_ALIKE)
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
        assert cut_off(page, "main .scroll > *") == []
    finally:
        page.send("Emulation.setEmulatedMedia", media="")


# --- The ledger ---------------------------------------------------------------------------------------------------

#: What an empty cell shows.
NOTHING = "\N{EN DASH}"
ROWS = "[...document.querySelectorAll('#ledger tbody tr:not([hidden])')]"
of_the_reproduction = pytest.mark.parametrize("report", ["reproduction"], indirect=True, scope="module")


def column(page, number):
    """Texts of a column of the ledger's visible rows."""
    return page.evaluate(f"{ROWS}.map(row => row.cells[{number}].dataset.value ?? row.cells[{number}].textContent)")


def data(page, name):
    """What the ledger's visible rows are filtered by."""
    return page.evaluate(f"{ROWS}.map(row => row.dataset[{name!r}])")


def wait(page, milliseconds):
    page.evaluate(f"new Promise(done => setTimeout(done, {milliseconds}))")


def enter(page, selector, value):
    """Type or choose a value."""
    event = "dispatchEvent(new Event('input', {bubbles: true}))"
    page.evaluate(f"(box => {{ box.value = {value!r}; box.{event}; }})(document.querySelector('{selector}'))")


@of_the_reproduction
def test_the_ledger_is_searched_and_filtered(page):
    assert not {"setting", "arithmetic"} & set(data(page, "basis"))  # what a reader comes for
    page.evaluate("document.querySelector('#filters [type=reset]').click()")
    wait(page, 50)
    everything = len(column(page, 0))
    assert "setting" in data(page, "basis")
    word = data(page, "place")[-1]
    enter(page, "#search", word.upper())
    assert 0 < len(column(page, 0)) < everything
    assert page.evaluate("document.getElementById('shown').textContent").startswith(f"{len(column(page, 0))} of ")
    page.evaluate("document.querySelector('#filters [type=reset]').click()")
    wait(page, 50)
    assert len(column(page, 0)) == everything
    for field in ("verdict", "place", "basis"):
        wanted = data(page, field)[-1]
        enter(page, f"[data-filter={field}]", wanted)
        assert set(data(page, field)) == {wanted}
        enter(page, f"[data-filter={field}]", "")
    page.evaluate("document.getElementById('asserted').click()")
    assert 0 < len(column(page, 0)) < everything
    assert all("asserted" in text for text in column(page, 0))
    shown = "[...document.querySelectorAll('#ledger tbody tr')].filter(row => row.getClientRects().length).length"
    for width in (390, 1280):  # rows, and cards on a narrow screen
        page.resize(width)
        assert page.evaluate(shown) == len(column(page, 0))


@of_the_reproduction
def test_the_ledger_is_sorted_by_the_buttons_in_its_header(page):
    press = "document.querySelectorAll('#ledger thead th button')[{}].click()"
    state = "[...document.querySelectorAll('#ledger thead th')].map(head => head.getAttribute('aria-sort'))"
    for place, (order, falling) in itertools.product((2, 3, 4, 5), (("ascending", False), ("descending", True))):
        page.evaluate(press.format(place))
        texts = column(page, place)
        numbers = [float(text) for text in texts if text != NOTHING]
        assert numbers == sorted(numbers, reverse=falling)
        assert NOTHING not in texts[: len(numbers)]
        assert {at: name for at, name in enumerate(page.evaluate(state)) if name} == {place: order}
    page.evaluate(press.format(1))
    assert column(page, 1) == sorted(column(page, 1))


@of_the_reproduction
def test_a_link_to_a_hidden_row_shows_it(page):
    claim = page.evaluate("document.querySelector('#ledger tbody tr:last-child').id")
    hidden = f"document.getElementById({claim!r}).hidden"
    enter(page, "#search", "zzz")
    assert page.evaluate(hidden)
    page.evaluate(f"location.hash = '#' + {claim!r}")
    wait(page, 200)
    assert not page.evaluate(hidden)


@of_the_reproduction
def test_a_command_is_copied_or_at_least_selected(page):
    page.evaluate("document.querySelector('.command button').click()")
    wait(page, 200)
    assert page.evaluate("document.querySelector('.command button').textContent") in ("Copied", "Selected")


@of_the_reproduction
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
