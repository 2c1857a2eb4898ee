"""The two reports, and a browser for each file of tests; its fixture `report` says which page it opens.

``REPORT_PAGE`` and ``IDENTIFY_PAGE`` name pages to open in place of the examples.
"""

import os
from pathlib import Path

import pytest
from chromium import Chromium, find_chromium
from fitting_example import example_curves, example_result
from report_example import make_example

from repro.files import write_text
from repro.fitting.figures import figures_of
from repro.fitting.outputs import FILES, render_page
from repro.report.page import build_report


@pytest.fixture(scope="module")
def reproduction(tmp_path_factory):
    """The report of a run, with the files that it links to."""
    if "REPORT_PAGE" in os.environ:
        return Path(os.environ["REPORT_PAGE"]).resolve()
    inputs = make_example(tmp_path_factory.mktemp("project"))
    write_text(inputs.page, build_report(inputs))
    return inputs.page


@pytest.fixture(scope="module")
def identification(tmp_path_factory):
    """The report of `repro identify`, with the files that it links to."""
    if "IDENTIFY_PAGE" in os.environ:
        return Path(os.environ["IDENTIFY_PAGE"]).resolve()
    folder = tmp_path_factory.mktemp("report")
    for name in FILES:
        (folder / name).write_text("", encoding="utf-8")
    result, curves = example_result(simulated=True), example_curves()
    (folder / "report.html").write_text(render_page(result, curves, figures_of(result, curves)), encoding="utf-8")
    return folder / "report.html"


@pytest.fixture(scope="module")
def browser():
    if not find_chromium():
        pytest.skip("no Chromium on this machine (Debian: chromium)")
    with Chromium() as chromium:
        yield chromium


@pytest.fixture
def page(browser, report):
    browser.events.clear()
    browser.resize(1400)
    browser.open(report)
    return browser
