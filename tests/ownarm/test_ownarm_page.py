"""The report of `repro identify`: what stands in it, in its figures and in its tables."""

import base64
import hashlib
import io
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from html_page import Page
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from ownarm_example import BETA, ERRORS, LOGS, VERDICTS, example_curves, example_result, method, parameters, score
from PIL import Image

from repro.exhibits import style
from repro.model.parameters import NAMES, UNITS
from repro.ownarm import figures as figures_module
from repro.ownarm.figures import (
    MOST_LOGS,
    draw_cutoff,
    draw_overlay,
    draw_parameters,
    draw_spectra,
    figures_of,
    ordered_titles,
)
from repro.ownarm.outputs import render_page
from repro.ownarm.result import Curves, Parameter
from repro.ownarm.tables import PARAMETER_COLUMNS, SCORE_COLUMNS, parameters_table, predictions, rounded, scores_table

pytestmark = pytest.mark.slow
TIMES = style.TIMES
HOSTILE = '<script>alert(1)</script>&".csv'


@pytest.fixture(scope="module")
def figures():
    """A small picture for each, none like another: what is drawn is another test's concern."""
    names = ["parameters", "cutoff", *(f"{kind}-{k}" for k in range(3) for kind in ("overlay", "spectra"))]
    return {name: figures_png(10 + k) for k, name in enumerate(names)}


@pytest.fixture(scope="module")
def text(figures):
    return render_page(example_result(), example_curves(), figures)


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_the_recommended_parameters_stand_each_in_its_row(page):
    rows = page.rows("recommended")[1:]
    assert [row[0] for row in rows] == list(NAMES)
    for row, value, error, verdict in zip(rows, BETA, ERRORS, VERDICTS, strict=True):
        low, high = row[4].split(" to ")
        for shown, true in ((row[1], value), (low, value - 1.96 * error), (high, value + 1.96 * error)):
            assert float(shown) == pytest.approx(true, abs=0.05 * error)
        assert float(row[5]) == pytest.approx(error, rel=0.05)
        assert row[3] == verdict
    assert "5.1 ms: it acts later than recorded" in page.one("preparation")["text"]
    assert [row[2] for row in rows] == ["kg·m²"] * 3 + ["N·m"] * 2 + ["N·m·s/rad"] * 2 + ["N·m"] * 2


def test_every_method_has_its_estimates_in_its_column(page):
    header, *rows = page.rows("parameters")
    result = example_result()
    ordered = sorted(result.methods, key=lambda m: m.method != result.recommended)
    for place, known in enumerate(ordered, start=1):
        assert known.title in header[place]
        assert ("recommended" in header[place]) == (known.method == "consistent")
        assert ("not physically consistent" in header[place]) == (not known.consistent)
        for row, parameter in zip(rows, known.parameters, strict=True):
            value, _, spread = row[place].partition(" ± ")
            assert row[0].startswith(parameter.name)
            assert float(value) == pytest.approx(
                parameter.estimate, rel=5e-4, abs=0.05 * (parameter.standard_error or 0)
            )
            assert bool(spread) == known.claims_intervals
    assert "b2 is negative: friction would drive the arm" in page.one("methods")["text"]


def test_scores_are_in_percent_and_the_best_prediction_is_marked(page):
    table, shown = page.tables["scores"], page.rows("scores")
    headings = [row[0] for row in shown if len(row) == 1]
    assert headings[0] == f"Fitted: {LOGS[0]}"
    assert [heading for heading in headings if "Validation" in heading] == [
        f"Validation: {name}, not used for the fit" for name in LOGS[1:]
    ]
    start = shown.index([f"Validation: {LOGS[1]}, not used for the fit"])
    block = shown[start + 1 : start + 4]
    assert [row[1:3] for row in block] == [["9.4", "17.1"], ["11.4", "20.7"], ["10.3", "18.8"]]
    assert [row[5] for row in block] == ["0.0310", style.DASH, "0.0360"]
    assert [[cell.get("best", False) for cell in row][1:] for row in table[start + 1 : start + 4]] == [
        [True] * 6, [False] * 6, [False] * 6,
    ]  # fmt: skip
    fitted = table[shown.index([headings[0]]) + 1 :][:3]
    assert not any(cell.get("best") for row in fitted for cell in row)


def test_a_hostile_name_is_text():
    result = example_result(arm=HOSTILE, reason=HOSTILE, warnings=(HOSTILE,))
    logs = replace(result.log, name=HOSTILE, facts=((HOSTILE, HOSTILE),), notes=(HOSTILE,), warnings=(HOSTILE,))
    hostile = method("ols", HOSTILE, notes=(HOSTILE,), citation=HOSTILE, fit=score(HOSTILE, 0.1, 0.2))
    result = replace(result, log=logs, methods=(hostile,), recommended="ols")
    curves = Curves((replace(example_curves().signals[0], name=HOSTILE),))
    text = render_page(result, curves, {"overlay-0": figures_png()}, [HOSTILE])
    assert "<script" not in text
    page = Page(text)
    assert not page.all("script")
    assert HOSTILE in page.all("h1")[0]["text"]
    assert HOSTILE in page.all("img")[0]["alt"]


def figures_png(height=10):
    """A small PNG file."""
    file = io.BytesIO()
    Image.new("RGB", (20, height)).save(file, "PNG")
    return file.getvalue()


def test_nothing_is_loaded_and_the_policy_allows_what_is_there(page, text, figures):
    assert "http:" not in text
    assert "https:" not in text
    (style_element,) = page.all("style")
    assert not re.search(r"@import|url\(", style_element["text"])
    assert not page.all("script")
    digest = base64.b64encode(hashlib.sha256(style_element["text"].encode()).digest()).decode()
    policy = next(meta["content"] for meta in page.all("meta") if "http-equiv" in meta)
    assert policy.startswith("default-src 'none';")
    assert f"style-src 'sha256-{digest}'" in policy
    for element in page.elements:
        assert not any(name.startswith("on") or name == "style" for name in element), "the policy would block it"
    held = [base64.b64decode(image["src"].partition(";base64,")[2]) for image in page.all("img")]
    assert sorted(held) == sorted(figures.values())
    assert all(image["alt"] for image in page.all("img"))


def test_what_is_infinite_or_silent_is_shown_all_the_same():
    result, curves = example_result(), example_curves()
    tiny = method("tiny", "Tiny", parameters=(parameter(1.234e-7, 2.2e-9), *parameters(1.0)[1:]))
    row = Page(render_page(replace(result, methods=(tiny,), recommended="tiny"), curves, {})).rows("recommended")[1]
    assert (row[1], row[5]) == (f"1.234{TIMES}10⁻⁷", f"0.022{TIMES}10⁻⁷")
    wild = method("wild", "Wild", parameters=parameters(np.inf), fit=score(LOGS[0], np.inf, np.nan))
    result = replace(
        result, methods=(*result.methods, wild), excitation=replace(result.excitation, rank=8, condition=np.inf)
    )
    first = curves.signals[0]
    silent = replace(first, tau=0.0 * first.tau, tau_spectrum=0.0 * first.tau_spectrum)
    figures = figures_of(replace(result, validation_logs=()), Curves((silent,)))
    page = Page(render_page(result, curves, figures))
    assert "inf" in page.one("excitation")["text"]
    assert all(row[4].startswith("inf ± ") for row in page.rows("parameters")[1:])


# Numbers in print


def parameter(estimate, error=None):
    ends = (None, None) if error is None else (estimate - 2 * error, estimate + 2 * error)
    return Parameter("I1", UNITS[0], "", estimate, error, *ends, "")


@pytest.mark.parametrize(
    ("estimate", "error", "both"),
    [
        (0.1213, 0.0019, "0.1213 ± 0.0019"),
        (3.235, 0.021, "3.235 ± 0.021"),
        (-0.0004, 0.02, "0.000 ± 0.020"),
        (12.5, 4321.0, "12 ± 4321"),
        (0.121345, None, "0.1213"),
        (0.0, None, "0"),
        (0.0, 0.0, "0 ± 0"),
        (1e-3, 0.0, "0.001000 ± 0"),
        (1.234e-7, 2.2e-9, f"(1.234 ± 0.022){TIMES}10⁻⁷"),
        (-5.4321e-9, None, f"-5.432{TIMES}10⁻⁹"),
        (4.2e7, 1.1e5, f"(4.200 ± 0.011){TIMES}10⁷"),
    ],
)
def test_numbers_have_the_digits_that_their_error_deserves(estimate, error, both):
    assert rounded(parameter(estimate, error)).with_error == both


@given(st.floats(-1e12, 1e12), st.floats(1e-12, 1e12))
def test_print_is_within_a_tenth_of_the_standard_error(estimate, error):
    shown = rounded(parameter(estimate, error))
    power = float(shown.power.replace(f"{TIMES}10", "1e").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or 1.0)
    if abs(estimate) < 1e9 * error:  # a dozen decimals at most are shown
        assert float(shown.estimate) * power == pytest.approx(estimate, abs=0.1 * error, rel=1e-12)
        assert float(shown.low) * power == pytest.approx(estimate - 2 * error, abs=0.1 * error, rel=1e-12)
    assert not re.fullmatch(r"-0(\.0*)?", shown.estimate)


# Tables


def test_tables_are_tidy_and_hold_every_number():
    result = example_result()
    table = parameters_table(result)
    assert tuple(table.columns) == PARAMETER_COLUMNS
    assert len(table) == 9 * len(result.methods)
    row = table.query("method == 'consistent' and parameter == 'g1'").iloc[0]
    assert (row["estimate"], row["standard_error"], row["unit"]) == (3.235, 0.021, "N m")
    assert table[table["method"] == "cnn"][["standard_error", "low", "high"]].isna().all(axis=None)
    scores = scores_table(result)
    assert tuple(scores.columns) == SCORE_COLUMNS
    shown = [heading.partition(":")[0] for heading, _ in predictions(result.best)]
    assert shown == ["Validation", "Validation", "Half on half", "Half on half", "Fitted"]  # unseen logs first
    assert scores.groupby("method", sort=False).size().to_dict() == {"ols": 10, "consistent": 10, "cnn": 6}
    assert set(scores["part"]) == {"fit", "half", "validation"}
    row = scores.query("method == 'cnn' and log == 'ramp_2.csv' and joint == 2").iloc[0]
    assert row["relative_rms"] == pytest.approx(0.183 * 1.1)
    assert row["position_rms"] == 0.09
    assert scores.query("method == 'ols' and part == 'validation'")["position_rms"].isna().all()
    for frame in (table, scores):
        back = pd.read_csv(io.StringIO(frame.to_csv(index=False)))
        pd.testing.assert_frame_equal(back, frame, check_dtype=False)


# Figures


def drawn(make, *arguments, **options) -> Figure:
    with style.house_style():
        return make(*arguments, **options)


def every_figure(simulated=False):
    result, curves = example_result(simulated=simulated), example_curves()
    titles = ordered_titles(result)
    return {
        "overlay": drawn(draw_overlay, curves.signals[0], titles, simulated),
        "spectra": drawn(draw_spectra, curves.signals[0], titles, simulated),
        "cutoff": drawn(draw_cutoff, curves.cutoff, simulated),
        "parameters": drawn(draw_parameters, result),
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", ["overlay", "spectra", "cutoff", "parameters"])
def test_figures_look_as_they_did(name, image_regression):
    picture = io.BytesIO()
    with style.house_style():
        every_figure(simulated=True)[name].savefig(picture, format="png", dpi=75)
    # Percent of all brightness: rounding moves a few pixels by a level; a line a tenth wider moves hundreds by tens.
    image_regression.check(picture.getvalue(), diff_threshold=2e-3, basename=f"look-{name}")


def test_long_logs_and_many_logs_stay_light(monkeypatch):
    rng = np.random.default_rng(0)
    t = np.arange(22_500) / 300.0
    tau = np.sin(2 * t) + 0.1 * rng.normal(size=(2, t.size))
    first = example_curves().signals[0]
    long = replace(first, t=t, tau=tau, rebuilt=dict.fromkeys(first.rebuilt, 0.9 * tau))
    result, curves = example_result(), Curves((long, *example_curves().signals[1:]))
    monkeypatch.setattr(figures_module, "MOST_LOGS", 2)
    figures = figures_of(result, curves)
    assert set(figures) == {"parameters", "overlay-0", "spectra-0", "overlay-1", "spectra-1"}
    text = render_page(result, curves, figures)
    assert "Drawn for 2 of 3 logs" in text
    size = len(text.encode())
    added = 4 / 3 * sum(len(figures[name]) for name in ("overlay-0", "spectra-0"))
    assert size + (MOST_LOGS - 2) * added < 3e6, "as many such logs as are drawn"
    assert Image.open(io.BytesIO(figures["overlay-0"])).width == round(200 * style.PAGE)
