"""The ledger of the reproduction's report in a real browser."""

import itertools

import pytest

#: What an empty cell of the ledger shows.
NOTHING = "\N{EN DASH}"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(reproduction):
    return reproduction


ROWS = "[...document.querySelectorAll('#ledger tbody tr:not([hidden])')]"


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


def test_the_ledger_is_searched_and_filtered(page):
    everything = len(column(page, 0))
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


def test_a_link_to_a_hidden_row_shows_it(page):
    claim = page.evaluate("document.querySelector('#ledger tbody tr:last-child').id")
    hidden = f"document.getElementById({claim!r}).hidden"
    enter(page, "#search", "zzz")
    assert page.evaluate(hidden)
    page.evaluate(f"location.hash = '#' + {claim!r}")
    wait(page, 200)
    assert not page.evaluate(hidden)


def test_a_command_is_copied_or_at_least_selected(page):
    page.evaluate("document.querySelector('.command button').click()")
    wait(page, 200)
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
