"""The ledger of the reproduction's report in a real browser; without Chromium these tests are skipped and say so."""

import pytest
from chromium import find_chromium

#: What an empty cell of the ledger shows.
NOTHING = "\N{EN DASH}"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not find_chromium(), reason="no Chromium on this machine (Debian: chromium)"),
]


@pytest.fixture(scope="module")
def report(reproduction):
    return reproduction


def column(page, number):
    """Texts of a column of the ledger's visible rows."""
    rows = "[...document.querySelectorAll('#ledger tbody tr:not([hidden])')]"
    return page.evaluate(f"{rows}.map(row => row.cells[{number}].dataset.value ?? row.cells[{number}].textContent)")


def data(page, name):
    """What the ledger's visible rows are filtered by."""
    rows = "[...document.querySelectorAll('#ledger tbody tr:not([hidden])')]"
    return page.evaluate(f"{rows}.map(row => row.dataset[{name!r}])")


def numbers(texts):
    return [float(text) for text in texts if text != NOTHING]


def test_the_ledger_is_searched_and_filtered(page):
    everything = len(column(page, 0))
    word = data(page, "place")[-1]
    page.evaluate(
        f"(box => {{ box.value = {word.upper()!r}; box.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
        "(document.getElementById('search'))"
    )
    assert 0 < len(column(page, 0)) < everything
    assert page.evaluate("document.getElementById('shown').textContent").startswith(f"{len(column(page, 0))} of ")
    page.evaluate("document.querySelector('#filters [type=reset]').click()")
    page.evaluate("new Promise(done => setTimeout(done, 50))")
    assert len(column(page, 0)) == everything
    for field in ("verdict", "place", "basis"):
        wanted = data(page, field)[-1]
        choose = "(box => {{ box.value = {!r}; box.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
        box = f"(document.querySelector('[data-filter={field}]'))"
        page.evaluate(choose.format(wanted) + box)
        assert set(data(page, field)) == {wanted}
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
