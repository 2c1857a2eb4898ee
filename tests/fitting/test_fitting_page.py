"""The report of `repro identify`: what stands in it, in its figures and in its tables."""

import base64
import hashlib
import io
import re
from dataclasses import replace

import numpy as np
import pytest
from fitting_example import LOGS, example_curves, example_result, method, parameters, png, score
from html_page import Page
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from repro.drawing import style
from repro.fitting.figures import MAX_DRAWN_LOGS, figures_of
from repro.fitting.outputs import render_page
from repro.fitting.result import Curves, Parameter
from repro.fitting.tables import rounded
from repro.model.parameters import UNITS

pytestmark = pytest.mark.slow
TIMES = style.TIMES
HOSTILE = '<script>alert(1)</script>&".csv'
#: A small picture for each, none like another: what is drawn is another test's concern.
PICTURES = {name: png(10 + k) for k, name in enumerate(("parameters", "cutoff", "overlay-1", "spectra-1"))}


@pytest.fixture(scope="module")
def text():
    return render_page(example_result(), example_curves(), PICTURES)


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_a_hostile_name_is_text():
    result = example_result(arm=HOSTILE, reason=HOSTILE, warnings=(HOSTILE,))
    logs = replace(result.log, name=HOSTILE, facts=((HOSTILE, HOSTILE),), notes=(HOSTILE,), warnings=(HOSTILE,))
    hostile = method("ols", HOSTILE, notes=(HOSTILE,), citation=HOSTILE, fit=score(HOSTILE, 0.1, 0.2))
    result = replace(result, log=logs, methods=(hostile,), recommended="ols")
    curves = Curves((replace(example_curves().signals[0], name=HOSTILE),))
    page = Page(render_page(result, curves, {"overlay-0": png(), "spectra-0": png()}, [HOSTILE]))
    assert not page.all("script")
    assert HOSTILE in page.all("h1")[0]["text"]
    assert HOSTILE in page.all("img")[0]["alt"]


def test_nothing_is_loaded_and_the_policy_allows_what_is_there(page, text):
    assert not re.search("https?:", text)
    (style_element,) = page.all("style")
    assert not re.search(r"@import|url\(", style_element["text"])
    assert not page.all("script")
    digest = base64.b64encode(hashlib.sha256(style_element["text"].encode()).digest()).decode()
    policy = next(meta["content"] for meta in page.all("meta") if "http-equiv" in meta)
    assert policy.startswith("default-src 'none';")
    assert f"style-src 'sha256-{digest}'" in policy
    for element in page.elements:
        assert not any(name.startswith("on") or name == "style" for name in element), "the policy would block it"
    held = [base64.b64decode(image["src"].partition(";base64,")[2]) for image in page.all("img") if image["alt"]]
    assert sorted(held) == sorted(PICTURES.values())


def test_what_is_infinite_or_silent_is_shown_all_the_same():
    result, curves = example_result(), example_curves()
    tiny = method("tiny", "Tiny", parameters=(parameter(1.234e-7, 2.2e-9), *parameters(1.0)[1:]))
    row = Page(render_page(replace(result, methods=(tiny,), recommended="tiny"), curves, {})).rows("recommended")[1]
    assert (row[1], row[5]) == (f"1.234{TIMES}10⁻⁷", f"0.022{TIMES}10⁻⁷")
    wild = method("wild", "Wild", parameters=parameters(np.inf, np.inf), fit=score(LOGS[0], np.inf, np.nan))
    excitation = replace(result.excitation, rank=8, condition=np.inf)
    result = replace(result, methods=(*result.methods, wild), excitation=excitation)
    first = curves.signals[0]
    silent = replace(first, tau=0.0 * first.tau, tau_spectrum=0.0 * first.tau_spectrum)
    page = Page(render_page(result, curves, figures_of(result, Curves((silent,)))))
    assert "inf" in page.one("excitation")["text"]
    assert all(row[4].startswith("inf ± ") for row in page.rows("parameters")[1:])


@pytest.mark.parametrize("warned", ["nothing", "the log", "the result"])
def test_parameters_are_recommended_with_care_where_anything_is_warned_of(warned):
    result = example_result(warnings=("slow",) if warned == "the result" else ())
    logs = [replace(log, warnings=()) for log in (result.log, *result.validation_logs)]
    result = replace(result, log=replace(logs[0], warnings=("spikes",) * (warned == "the log")))
    result = replace(result, validation_logs=tuple(logs[1:]))
    said = Page(render_page(result, example_curves(), {})).one("verdict")["text"]
    assert ("With care" in said) == (warned != "nothing")


def parameter(estimate, error=None):
    ends = (None, None) if error is None else (estimate - 2 * error, estimate + 2 * error)
    return Parameter("I1", UNITS[0], "", estimate, error, *ends, "")


@pytest.mark.parametrize(
    ("estimate", "error", "both"),
    [
        (3.235, 0.021, "3.235 ± 0.021"),
        (-0.0004, 0.02, "0.000 ± 0.020"),
        (12.5, 4321.0, "12 ± 4321"),
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


@pytest.mark.parametrize("name", ["overlay-0", "spectra-0", "cutoff", "parameters"])
def test_figures_look_as_they_did(monkeypatch, image_regression, name):
    monkeypatch.setattr("repro.fitting.figures._png", lambda figure: figure)
    curves, file = example_curves(), io.BytesIO()
    figures = figures_of(example_result(simulated=True), replace(curves, signals=curves.signals[:1]))
    with style.house_style():
        figures[name].savefig(file, format="png", dpi=75)
    # Percent of all brightness: rounding moves a few pixels by a level; a line a tenth wider moves hundreds by tens.
    image_regression.check(file.getvalue(), diff_threshold=2e-3, basename=f"look-{name.removesuffix('-0')}")


def test_as_many_long_logs_as_are_drawn_make_a_light_page():
    rng = np.random.default_rng(0)
    t = np.arange(22_500) / 300.0
    tau = np.sin(2 * t) + 0.1 * rng.normal(size=(2, t.size))
    first = example_curves().signals[0]
    curves = Curves((replace(first, t=t, tau=tau, rebuilt=dict.fromkeys(first.rebuilt, 0.9 * tau)),))
    figures = figures_of(example_result(), curves)
    assert set(figures) == {"parameters", "overlay-0", "spectra-0"}
    size = len(render_page(example_result(), curves, figures).encode())
    added = 4 / 3 * sum(len(figures[name]) for name in ("overlay-0", "spectra-0"))
    assert size + (MAX_DRAWN_LOGS - 1) * added < 3e6
    assert Image.open(io.BytesIO(figures["overlay-0"])).width == round(200 * style.PAGE)
