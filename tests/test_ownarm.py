"""From a log to the files of `repro identify`: judging, recommending, writing, and the whole on a known arm."""

import io
import json
import os
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from log_example import BETA, columns, log_of, motion, recording, text
from ownarm_example import LOGS, example_curves, example_result, method, parameters, score
from ownarm_log import H, exact, exciting, other_motion
from PIL import Image

from repro.errors import InputError
from repro.estimators.interface import Estimate, Method
from repro.estimators.methods import METHODS
from repro.export.bibtex import bibtex, entries
from repro.export.links import links_of
from repro.logs.armfile import Arm
from repro.logs.description import Description
from repro.model.dynamics import inverse_dynamics, mass_matrix
from repro.model.feasibility import is_positive_definite
from repro.model.parameters import DESCRIPTIONS, NAMES, UNITS
from repro.ownarm import outputs
from repro.ownarm.job import NETWORK_METHODS, assemble, resolve, solve_all
from repro.ownarm.judge import Found, find, judge, why_not_consistent
from repro.ownarm.outputs import check_folder, citations, write_all
from repro.ownarm.prepared import Problem, Told, make_problem, read
from repro.ownarm.recommend import prediction_error, recommend, warnings
from repro.ownarm.result import Excitation
from repro.ownarm.settings import Options
from repro.prediction.torque import relative_rms
from repro.regression.cutoff import Cutoff
from repro.regression.prepare import FilterSettings
from repro.trust.bootstrap import Spread
from repro.trust.excitation import torque_share

ROOT = Path(__file__).resolve().parent.parent
ARM = Arm(name="test arm")
FILES = ["arm.urdf", "arm.xml", "methods.bib", "parameters.csv", "parameters.json", "report.html"]
FILES += ["residuals.csv", "scores.csv"]
SOURCES = {"ols": "gautier1992exciting", "consistent": "sousa2014physical", "cnn": "leon2022cnn"}


def silent(*_):
    """A progress nobody looks at."""


def told(log):
    return Told(log, Description(log.name, (("samples", str(log.t.size)),)))


def problem_of(regression, others=(), moving=None, **settings):
    """A problem around a regression that no filter made; the arm never stands still unless `moving` says so."""
    nothing = np.zeros(0)
    cutoff = Cutoff(5.0, "made up", nothing, np.zeros((2, 0)), np.zeros((2, 0)), 10.0)
    chosen = FilterSettings(**settings)
    return Problem(
        fitted=told(log_of(recording())),
        regression=regression,
        moving=regression if moving is None else moving,
        as_good=(),
        others=tuple(others),
        settings=chosen,
        cutoff=cutoff,
    )


def noisy(beta, seed=0, size=0.02, n=1200):
    noise = size * np.random.default_rng(seed).normal(size=(2, n))
    return exact(motion(H * np.arange(n)), beta, noise)


def judged(name, regression, seed=1):
    problem = problem_of(regression)
    return judge(find(METHODS[name], problem, seed, True, silent), problem, (None,))


# Recommending


def test_a_consistent_method_is_preferred_to_one_that_predicts_better():
    methods = (method("a", "A", 1.0, consistent=False), method("b", "B", 1.5), method("c", "C", 1.2))
    name, reason = recommend(methods)
    assert name == "c"
    assert reason == "smallest mean torque error on the validation logs among the physically consistent methods"


def test_validation_logs_count_before_halves():
    # Halves say b, the logs not used say a; without such logs it is b.
    a = method("a", "A", 1.0, halves=(score("second half", 0.5, 0.5),))
    b = method("b", "B", 1.1, halves=(score("second half", 0.01, 0.01),))
    assert recommend((a, b))[0] == recommend((b, a))[0] == "a"
    name, reason = recommend([replace(m, validation=()) for m in (a, b)])
    assert name == "b"
    assert reason == "smallest mean torque error on each half from the other among the physically consistent methods"


def test_prediction_error_is_the_mean_over_logs_and_joints():
    a = method("a", "A", validation=(score("x", 0.1, 0.2), score("y", 0.3, 0.6)), halves=(score("h", 0.4, 0.0),))
    assert prediction_error(a) == pytest.approx(0.3)
    assert prediction_error(replace(a, validation=())) == pytest.approx(0.2)
    assert prediction_error(replace(a, validation=(), halves=())) == np.inf


def test_a_method_that_was_not_judged_is_not_preferred():
    slow = method("cnn", "CNN", 0.1, validation=(), halves=())
    judged_one = method("b", "B", 3.0, validation=())
    assert recommend((slow, judged_one))[0] == recommend((judged_one, slow))[0] == "b"


def test_a_single_method_is_the_only_one():
    assert recommend((method("a", "A", 9.0),)) == ("a", "the only method asked for")


def test_where_none_is_consistent_the_reason_says_so():
    methods = [method(name, name, worse, consistent=False) for name, worse in (("a", 2.0), ("b", 1.0))]
    name, reason = recommend(methods)
    assert name == "b"
    assert "no method asked for gives physically consistent parameters" in reason
    assert "no method asked for gives physically consistent parameters" in recommend(methods[:1])[1]


GOOD = method(
    "a",
    "A",
    fit=score("log.csv", 0.05, 0.06),
    validation=(score("x", 0.05, 0.119), score("y", 0.119, 0.1)),
    whiteness=(0.5, -0.5),
)
TELLING = Excitation(9, 100.0, (0.1,) * 9, (-0.9, 0.9), (), NAMES)
#: Each limit just passed: what is changed, and words of the one warning that it makes.
PASSED = [
    ({"rank": 8}, {}, {}, ("8 combinations",)),
    ({"rank": 7, "condition": 1e16}, {}, {}, ("7 combinations",)),
    ({"condition": 100.1}, {}, {}, ("condition number 100",)),
    ({"friction_correlation": (-0.901, 0.9)}, {}, {}, ("friction of joint 1", "-0.90")),
    ({"friction_correlation": (-0.9, 0.95)}, {}, {}, ("friction of joint 2", "0.95")),
    ({}, {"fit": score("log.csv", 0.301, 0.06)}, {}, ("30.1 %", "joint 1 unexplained")),
    ({}, {"fit": score("log.csv", 0.05, 0.42)}, {}, ("42 %", "joint 2 unexplained")),
    ({}, {"whiteness": (0.51, 0.1)}, {}, ("far from white", "0.51")),
    ({}, {"whiteness": (0.1, -0.7)}, {}, ("far from white", "-0.70")),
    ({}, {"validation": (score("x", 0.05, 0.121),)}, {}, ("12.1 %", "itself 6 %")),
    ({}, {}, {"delay": 0.02}, ("delay", "20 ms")),
    ({}, {}, {"delay": -0.02}, ("delay", "-20 ms")),
    ({}, {"consistent": False, "why_not_consistent": "b2 = -1"}, {}, ("not physically consistent: b2 = -1",)),
]


def warned(excitation, changes, settings, others=()):
    problem = problem_of(exciting(50), **{"delay": 0.0197, **settings})
    return warnings(problem, (*others, replace(GOOD, **changes)), "a", replace(TELLING, **excitation))


def test_at_its_limits_nothing_is_warned_of():
    assert warned({}, {}, {}) == ()
    assert warned({}, {"fit": score("log.csv", 0.3, 0.3)}, {}) == ()
    assert warned({}, {"validation": ()}, {}) == ()
    # A tenth is little, however small the error on the log itself.
    assert warned({}, {"fit": score("log.csv", 0.01, 0.01), "validation": (score("x", 0.1, 0.1),)}, {}) == ()
    # What another method does is not told.
    bad = method("b", "B", whiteness=(0.99, 0.99), consistent=False, fit=score("log.csv", 0.9, 0.9))
    assert warned({}, {}, {}, (bad,)) == ()


@pytest.mark.parametrize(("excitation", "changes", "settings", "words"), PASSED)
def test_each_limit_passed_makes_its_own_warning(excitation, changes, settings, words):
    (line,) = warned(excitation, changes, settings)
    assert all(word in line for word in words), line
    assert "\n" not in line


def test_all_that_may_spoil_a_result_is_told_at_once():
    changes = {key: value for _, part, _, _ in PASSED for key, value in part.items()}
    lines = warned({"rank": 8, "friction_correlation": (1.0, 1.0)}, changes, {"delay": 0.02})
    assert len(set(lines)) == len(lines) == 7


# Judging


@given(st.lists(st.floats(-1.0, 1.0), min_size=9, max_size=9))
def test_parameters_are_inconsistent_exactly_where_a_reason_is_given(beta):
    beta = np.array(beta)
    why = why_not_consistent(beta)
    assert (why == "") == bool(is_positive_definite(beta))
    for k, name in enumerate(NAMES):
        assert (f"{name} = {beta[k]:.3g} is negative" in why) == bool(k >= 5 and beta[k] < 0.0)
    poses = np.stack([np.zeros(181), np.linspace(0.0, np.pi, 181)], axis=-1)
    if np.linalg.eigvalsh(mass_matrix(poses, beta)).min() < -1e-9:
        assert "inertia matrix is not positive definite" in why


def test_the_reason_holds_the_numbers():
    beta = np.array([0.125, 0.2, 0.025, 3.3, 1.1, -0.07, 0.04, 0.2, -0.15])
    assert why_not_consistent(beta) == (
        "the inertia matrix is not positive definite: I3 (I1 - I3) = 0.0025 is not above I2^2 / 4 = 0.01; "
        "b1 = -0.07 is negative; k2 = -0.15 is negative"
    )


def test_a_method_on_a_clean_log_is_judged():
    m = judged("ordinary", noisy(BETA))
    assert m.consistent
    assert m.why_not_consistent == ""
    assert m.claims_intervals
    assert [(p.name, p.unit, p.description) for p in m.parameters] == list(zip(NAMES, UNITS, DESCRIPTIONS, strict=True))
    for p, true in zip(m.parameters, BETA, strict=True):
        assert p.low < true < p.high
        assert p.low < p.estimate < p.high
        assert p.verdict.startswith("known to")
    assert m.validation == ()
    assert (m.method, m.citation) == ("ordinary", "gautier1992exciting")


def test_parameters_that_the_motion_does_not_move_have_no_interval():
    q, dq, ddq = motion(H * np.arange(1200))
    q[1], dq[1], ddq[1] = 0.4, 0.0, 0.0
    r = exact((q, dq, ddq), noise=0.02 * np.random.default_rng(0).normal(size=(2, 1200)))
    for name in ("ordinary", "bounded"):
        p = dict(zip(NAMES, judged(name, r).parameters, strict=True))
        for unmoved in ("b2", "k2"):
            assert p[unmoved].verdict == "not excited by this motion"
            assert (p[unmoved].estimate, p[unmoved].standard_error, p[unmoved].low, p[unmoved].high) == (0, *[None] * 3)
        assert p["g1"].verdict.startswith("known to")
        assert p["g1"].low < BETA[3] < p["g1"].high


def test_parameters_held_at_zero_have_no_interval():
    beta = BETA.copy()
    beta[6] = -0.02
    p = dict(zip(NAMES, judged("bounded", noisy(beta)).parameters, strict=True))
    assert p["b2"].verdict == "held at zero: the log alone would make it negative"
    assert (p["b2"].estimate, p["b2"].standard_error, p["b2"].low, p["b2"].high) == (0.0, None, None, None)
    free = judged("ordinary", noisy(beta))
    assert free.parameters[6].low < -0.02 < free.parameters[6].high
    assert not free.consistent
    assert free.why_not_consistent == f"b2 = {free.parameters[6].estimate:.3g} is negative"


def test_a_parameter_that_moves_next_to_nothing_has_no_interval():
    r, beta = exciting(400), BETA.copy()
    # Just below and above a five-hundredth of the RMS torque of joint 2.
    column = np.sqrt(np.mean(r.y[1, :, 6] ** 2)) / np.sqrt(np.mean(r.tau[1] ** 2))
    for share, words in ((0.0019, "not excited by this motion"), (0.0021, "not told from zero")):
        beta[6] = share / column
        spread = Spread(np.full(9, 0.01), beta - 0.02, beta + 0.02)
        found = Found(METHODS["ordinary"], Estimate(beta.copy()), spread, ())
        b2 = judge(found, problem_of(r), (None,)).parameters[6]
        assert b2.verdict == words
        assert b2.estimate == beta[6]
        assert (b2.low is None) == (b2.high is None) == (b2.standard_error is None) == words.startswith("not excited")


def test_a_method_without_intervals_says_so():
    plain = Method("algorithm1", "A", "leon2022cnn", lambda _: Estimate(BETA, ("a note",)), claims_intervals=False)
    problem = problem_of(noisy(BETA))
    (found,) = solve_all(problem, [plain], 1, silent, silent)
    assert found.spread is None
    assert found.halves == ()  # each would train a network of its own
    m = judge(found, problem, ((0.1, 0.2),))
    assert not m.claims_intervals
    assert {p.verdict for p in m.parameters} == {"no interval claimed by this method"}
    assert {(p.standard_error, p.low, p.high) for p in m.parameters} == {(None, None, None)}
    assert m.notes == ("a note",)
    assert m.fit.position_rms == (0.1, 0.2)


def test_each_half_is_predicted_from_the_other():
    r = noisy(BETA, size=0.3, n=800)
    found = find(METHODS["ordinary"], problem_of(r), 1, True, silent)
    assert [s.log for s in found.halves] == ["second half", "first half"]
    first, second = (slice(0, 400), slice(400, 800))
    for s, fitted, predicted in zip(found.halves, (first, second), (second, first), strict=True):
        y, tau = r.y[:, fitted].reshape(-1, 9), r.tau[:, fitted].reshape(-1)
        error = r.tau[:, predicted] - r.y[:, predicted] @ np.linalg.lstsq(y, tau, rcond=None)[0]
        expected = np.linalg.norm(error, axis=1) / np.linalg.norm(r.tau[:, predicted], axis=1)
        assert s.relative_rms == pytest.approx(tuple(expected), rel=1e-9)
        assert s.position_rms is None


def test_standstill_is_left_out_of_the_fit_and_judged():
    # Where the arm stands still, static friction adds a torque that Eq. 1 does not hold.
    r = exciting(800)
    still = np.zeros((2, 800), dtype=bool)
    still[:, 100:140] = still[1, 500:530] = True
    held = replace(r, tau=r.tau + 0.3 * still)
    counts = ~still
    moving = replace(held, y=held.y * counts[..., np.newaxis], tau=held.tau * counts, moving=counts)
    problem = problem_of(held, moving=moving)
    found = find(METHODS["ordinary"], problem, 1, True, silent)
    assert found.estimate.beta == pytest.approx(BETA, rel=1e-6)
    assert found.spread.standard_error == pytest.approx(np.zeros(9), abs=1e-6)
    expected = 0.3 * np.sqrt(still.mean(1)) / np.sqrt(np.mean(held.tau**2, axis=1))
    assert judge(found, problem, (None,)).fit.relative_rms == pytest.approx(tuple(expected), rel=1e-6)
    # The first half, which holds most of the standstill, is predicted with it and fitted without it.
    second, first = found.halves
    late = 0.3 * np.sqrt(still[:, 400:].mean(1)) / np.sqrt(np.mean(held.tau[:, 400:] ** 2, axis=1))
    assert second.relative_rms == pytest.approx(tuple(late), rel=1e-6, abs=1e-9)
    assert min(first.relative_rms) > 0.01
    # A method that sees the log as signals is given all of it.
    seen = []
    plain = Method("a", "A", "", lambda x: seen.append(x) or Estimate(BETA), False, needs_all_samples=True)
    find(plain, problem, 1, False, silent)
    assert seen == [held]


def test_a_seed_gives_the_same_intervals_again():
    problem = problem_of(noisy(BETA, n=300))
    one, again, other = (find(METHODS["ordinary"], problem, seed, False, silent).spread for seed in (1, 1, 2))
    assert (one.low == again.low).all()
    assert (one.low != other.low).all()


def test_validation_logs_are_scored_under_their_names():
    r, faster = noisy(BETA), noisy(1.1 * BETA, 5, size=0.002)
    other = told(replace(log_of(recording()), name="other.csv"))
    problem = problem_of(r, [(other, faster)])
    found = Found(METHODS["ordinary"], Estimate(BETA), None, ())
    m = judge(found, problem, (None, (0.01, 0.02)))
    (s,) = m.validation
    assert s.log == "other.csv"
    assert s.position_rms == (0.01, 0.02)
    assert s.relative_rms == relative_rms(faster, BETA)
    assert s.relative_rms == pytest.approx((0.1 / 1.1,) * 2, rel=0.05)


# Files


def example(recommended="consistent", **changes):
    """The made-up result with sources that exist, and its curves."""
    result = example_result(recommended=recommended, **changes)
    result = replace(result, methods=tuple(replace(m, citation=SOURCES[m.method]) for m in result.methods))
    return result, example_curves(3.0)


@pytest.fixture
def small_figures(monkeypatch):
    """A dot for every figure: what is drawn is another test's concern."""
    dot = io.BytesIO()
    Image.new("P", (1, 1)).save(dot, "PNG")
    monkeypatch.setattr(outputs, "figures_of", lambda result, curves: {"parameters": dot.getvalue()})


def tree(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def everything(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


def refuse_constant(name):
    raise AssertionError(name)


@pytest.mark.usefixtures("small_figures")
def test_the_files_of_a_result(tmp_path):
    result, curves = example()
    assert write_all(tmp_path / "new" / "out", result, curves, ARM) == FILES
    assert everything(tmp_path) == ["new", "new/out", *(f"new/out/{name}" for name in FILES)]
    page = (tmp_path / "new" / "out" / "report.html").read_text(encoding="utf-8")
    assert all(f'href="{name}"' in page for name in FILES if name != "report.html")
    # As readable as what a program of the user's own writes.
    mask = os.umask(0)
    os.umask(mask)
    assert {(tmp_path / "new" / "out" / name).stat().st_mode & 0o777 for name in FILES} == {0o666 & ~mask}
    assert (tmp_path / "new" / "out").stat().st_mode & 0o777 == 0o777 & ~mask


@pytest.mark.usefixtures("small_figures")
def test_the_json_holds_the_result_and_no_nan(tmp_path):
    result, curves = example()
    endless = replace(result.methods[0], fit=score(LOGS[0], np.inf, 0.2), whiteness=(np.nan, 0.5))
    result = replace(
        result,
        methods=(endless, *result.methods[1:]),
        excitation=replace(result.excitation, condition=np.inf),
    )
    write_all(tmp_path / "out", result, curves, ARM)
    found = json.loads((tmp_path / "out" / "parameters.json").read_text(), parse_constant=refuse_constant)
    assert found["methods"][0]["fit"]["relative_rms"] == [None, 0.2]
    assert found["methods"][0]["whiteness"] == [None, 0.5]
    assert found["excitation"]["condition"] is None
    expected = json.loads(json.dumps(asdict(result)))  # tuples become lists
    for part in (found, expected):
        del part["methods"][0], part["excitation"]
    assert found == expected


@pytest.mark.usefixtures("small_figures")
def test_residuals_are_those_of_the_recommended_method(tmp_path):
    result, curves = example()
    write_all(tmp_path / "out", result, curves, ARM)
    table = pd.read_csv(tmp_path / "out" / "residuals.csv")
    assert list(table.columns) == ["log", "time_s", "joint", "torque_nm", "rebuilt_nm", "residual_nm"]
    assert len(table) == 2 * sum(s.t.size for s in curves.signals)
    assert list(dict.fromkeys(table["log"])) == list(LOGS)
    assert table["residual_nm"].to_numpy() == pytest.approx(table["torque_nm"] - table["rebuilt_nm"], abs=1e-8)
    for signals in curves.signals:
        for joint in (1, 2):
            rows = table[(table["log"] == signals.name) & (table["joint"] == joint)]
            assert rows["time_s"].to_numpy() == pytest.approx(signals.t, abs=1e-8)
            assert rows["torque_nm"].to_numpy() == pytest.approx(signals.tau[joint - 1], rel=1e-8)
            assert rows["rebuilt_nm"].to_numpy() == pytest.approx(signals.rebuilt["consistent"][joint - 1], rel=1e-8)


@pytest.mark.usefixtures("small_figures")
def test_a_second_write_gives_the_same_bytes(tmp_path):
    for name in ("one", "two"):
        write_all(tmp_path / name, *example(), ARM)
    assert tree(tmp_path / "one") == tree(tmp_path / "two")
    before = tree(tmp_path / "one")
    write_all(tmp_path / "one", *example(), ARM)
    assert tree(tmp_path / "one") == before


@pytest.mark.usefixtures("small_figures")
@pytest.mark.parametrize("writer", ["figures_of", "render_page", "bibtex", "scores_table", "mjcf", "residuals"])
@pytest.mark.parametrize("there", ["nothing", "a result"])
def test_a_writer_that_fails_leaves_everything_as_it_was(tmp_path, monkeypatch, writer, there):
    out = tmp_path / "out"
    if there == "a result":
        write_all(out, *example(recommended="cnn"), ARM)
        (out / "notes.txt").write_text("my own")
    names, files = everything(tmp_path), tree(tmp_path)

    def fail(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(outputs, writer, fail)
    with pytest.raises(OSError, match="no space left"):
        write_all(out, *example(), ARM)
    assert everything(tmp_path) == names
    assert tree(tmp_path) == files


@pytest.mark.usefixtures("small_figures")
def test_overwriting_keeps_what_is_not_ours(tmp_path):
    out = tmp_path / "out"
    (out / "deep").mkdir(parents=True)
    foreign = {"notes.txt": "mine", "arm.png": "x", "deep/parameters.json": "{}"}
    for name, content in foreign.items():
        (out / name).write_text(content)
    (out / "parameters.json").write_text("an earlier run")
    check_folder(out, overwrite=True)
    write_all(out, *example(), ARM)
    assert everything(out) == sorted(["deep", *foreign, *FILES])
    assert {name: (out / name).read_text() for name in foreign} == foreign
    assert json.loads((out / "parameters.json").read_text())["recommended"] == "consistent"


def test_a_folder_that_cannot_be_used_is_refused(tmp_path):
    full, file = tmp_path / "full", tmp_path / "file"
    full.mkdir()
    (full / "x").touch()
    file.touch()
    for out, overwrite, words in (
        (file, False, "a file"),
        (file, True, "a file"),
        (full, False, "a folder with files in it"),
        (file / "out", False, "no permission"),
        (file / "deep" / "out", True, "no permission"),
    ):
        with pytest.raises(InputError, match=words) as refused:
            check_folder(out, overwrite)
        assert "\n" not in str(refused.value)
        assert str(tmp_path) in str(refused.value)
    assert everything(tmp_path) == ["file", "full", "full/x"]


def test_a_folder_that_can_be_used_is_not_touched(tmp_path):
    (tmp_path / "empty").mkdir()
    check_folder(tmp_path / "empty", overwrite=False)
    check_folder(tmp_path / "not" / "yet" / "there", overwrite=False)
    (tmp_path / "empty" / "x").touch()
    check_folder(tmp_path / "empty", overwrite=True)
    assert everything(tmp_path) == ["empty", "empty/x"]


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_folder_without_permission_is_refused(tmp_path):
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    for out in (locked, locked / "new"):
        with pytest.raises(InputError, match="no permission to write"):
            check_folder(out, overwrite=True)


@pytest.mark.usefixtures("small_figures")
def test_links_are_exported_where_there_are_some(tmp_path):
    result, curves = example()
    write_all(tmp_path / "out", result, curves, ARM)
    assert (tmp_path / "out" / "arm.urdf").read_text(encoding="utf-8").startswith("<?xml")
    assert "<mujoco" in (tmp_path / "out" / "arm.xml").read_text(encoding="utf-8")
    assert not (tmp_path / "out" / "no-links.txt").exists()


@pytest.mark.usefixtures("small_figures")
@pytest.mark.parametrize(("change", "words"), [({"b2": -0.03}, "b2 = -0.03"), ({}, "I2^2 / 4")])
def test_without_links_a_file_says_why(tmp_path, change, words):
    changed = parameters(1.0, **change)
    if not change:  # an inertia matrix that is not positive definite
        changed = (changed[0], replace(changed[1], estimate=0.3), *changed[2:])
    result, curves = example()
    result = replace(result, methods=tuple(replace(m, parameters=changed, consistent=False) for m in result.methods))
    names = write_all(tmp_path / "out", result, curves, ARM)
    assert names == sorted({*FILES, "no-links.txt"} - {"arm.urdf", "arm.xml"})
    line = (tmp_path / "out" / "no-links.txt").read_text(encoding="utf-8")
    assert words in line
    assert line.count("\n") == 1
    with pytest.raises(ValueError, match="must"):
        links_of(np.array([p.estimate for p in changed]))


@pytest.mark.parametrize("filter_name", ["zero-phase DCT pair", "Savitzky-Golay, cubic"])
@pytest.mark.parametrize("name", [*METHODS, *NETWORK_METHODS])
def test_every_source_that_is_cited_exists(name, filter_name):
    result, _ = example()
    citation = METHODS[name].citation if name in METHODS else "leon2022cnn"
    claims = name not in NETWORK_METHODS
    one = replace(result.methods[0], method=name, citation=citation, claims_intervals=claims)
    result = replace(result, methods=(one,), preparation=replace(result.preparation, filter=filter_name))
    keys = citations(result)
    assert len(set(keys)) == len(keys)
    assert set(keys) <= set(entries())
    assert {"leon2022cnn", citation} <= set(keys)
    assert ("kunsch1989jackknife" in keys) == claims
    assert ("savitzky1964smoothing" in keys) == filter_name.startswith("Savitzky")
    assert bibtex(keys).count("@") == len(keys)


# The whole, on a known arm


def write_log(path, moved=motion, seconds=12.0, rate=200.0, beta=BETA, steepness=20.0, late=0.0):
    """A recording of the arm as a CSV file; the torque is recorded so much before it acts."""
    t = np.arange(round(seconds * rate)) / rate
    q, dq, _ = moved(t)
    tau = inverse_dynamics(*moved(t + late), beta, steepness)
    r = recording(t)
    path.write_text(text(columns(replace(r, q=q, dq=dq, tau=tau))), encoding="utf-8")
    return path


def identify(folder, methods=tuple(METHODS), arm=ARM, validate=True):
    """All of `repro identify` but its files: problem, result and curves."""
    options = Options(methods, folder / "cache")
    log = read(write_log(folder / "log.csv"), arm)
    others = (read(write_log(folder / "other.csv", other_motion, 8.0), arm),) if validate else ()
    problem = make_problem(log, others, arm, options)
    found = solve_all(problem, resolve(options, silent), options.seed, silent, silent)
    return (problem, *assemble(problem, found, arm))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return identify(tmp_path_factory.mktemp("whole"))


def test_every_method_finds_the_arm(whole):
    _, result, _ = whole
    assert [m.method for m in result.methods] == list(METHODS)
    for m in result.methods:
        found = np.array([p.estimate for p in m.parameters])
        assert found == pytest.approx(BETA, rel=0.02), m.method
        assert found[:5] == pytest.approx(BETA[:5], rel=0.002), m.method
        assert m.consistent
        assert all(p.verdict.startswith("known to") for p in m.parameters)
        assert all(p.low < p.estimate < p.high and p.standard_error > 0.0 for p in m.parameters)


def test_every_method_predicts_another_motion(whole):
    _, result, _ = whole
    for m in result.methods:
        (s,) = m.validation
        assert s.log == "other.csv"
        for each in (s, m.fit, *m.halves):
            assert max(each.relative_rms) < 0.01
            assert min(each.similarity) > 0.99
        assert max(s.position_rms) < 2e-3
        assert max(m.fit.position_rms) < 2e-3
        assert [h.log for h in m.halves] == ["second half", "first half"]
        assert all(h.position_rms is None for h in m.halves)


def test_the_result_says_what_was_done(whole):
    problem, result, _ = whole
    assert result.arm == "test arm"
    assert not result.simulated
    assert (result.log.name, [d.name for d in result.validation_logs]) == ("log.csv", ["other.csv"])
    assert result.recommended in METHODS
    assert result.reason.startswith("smallest mean torque error on the validation logs")
    assert result.warnings == ()
    p = result.preparation
    assert p.cutoff == problem.settings.cutoff
    assert 1.0 <= p.cutoff <= 10.0
    assert p.cutoff_reason == problem.cutoff.reason
    assert p.delay == pytest.approx(0.0, abs=2e-4)
    assert p.friction_steepness == 20.0
    assert p.samples == problem.regression.t.size
    assert p.rate == pytest.approx((p.samples - 1) / np.ptp(problem.regression.t))
    e = result.excitation
    assert (e.rank, e.unexcited, e.base_parameters) == (9, (), NAMES)
    assert all(0.0 < share < 2.0 for share in e.share)
    assert sum(e.share) > 1.0


def test_the_curves_are_those_of_both_logs(whole):
    problem, result, curves = whole
    assert [s.name for s in curves.signals] == ["log.csv", "other.csv"]
    assert curves.cutoff is problem.cutoff
    for s in curves.signals:
        n = s.t.size
        assert set(s.rebuilt) == set(s.rebuilt_spectrum) == set(METHODS)
        assert s.rebuilt[result.recommended] == pytest.approx(s.tau, abs=0.02)
        # The squares of the amplitudes hold the energy of the signal (Parseval).
        assert 0.5 * n * np.sum(s.tau_spectrum**2, axis=-1) == pytest.approx(np.sum(s.tau**2, axis=-1), rel=1e-9)
        assert s.frequency[0] == 0.0
        assert s.frequency[-1] == pytest.approx(0.5 * (n - 1) / np.ptp(s.t) * (n - 1) / n)
    # The fastest sinusoid of either position is at 1.3 Hz, so most of the torque's energy is below 3 Hz.
    s = curves.signals[0]
    assert np.sum(s.tau_spectrum[:, s.frequency < 3.0] ** 2) > 0.95 * np.sum(s.tau_spectrum**2)


def test_each_method_is_judged_by_its_own_parameters(whole):
    problem, _, _ = whole
    names, betas = ("ordinary", "bounded"), (1.1 * BETA, BETA)
    found = [Found(METHODS[n], Estimate(b), None, ()) for n, b in zip(names, betas, strict=True)]
    result, curves = assemble(problem, found, ARM)
    assert result.recommended == "bounded"
    assert result.excitation.share == pytest.approx(torque_share(problem.regression, BETA))
    for m, beta in zip(result.methods, betas, strict=True):
        assert [p.estimate for p in m.parameters] == list(beta)
        for s, each in zip(curves.signals, (m.fit, *m.validation), strict=True):
            error = np.linalg.norm(s.tau - s.rebuilt[m.method], axis=1) / np.linalg.norm(s.tau, axis=1)
            assert each.relative_rms == pytest.approx(tuple(error), rel=1e-9)
            assert max(each.relative_rms) == pytest.approx(beta[0] / BETA[0] - 1.0, abs=0.01)
            assert (max(each.position_rms) < 2e-3) == (beta is betas[1])


def test_the_whole_gives_the_same_bytes_twice(tmp_path):
    for name in ("one", "two"):
        folder = tmp_path / name
        folder.mkdir()
        _, result, curves = identify(folder, ("ordinary", "consistent"), validate=False)
        write_all(folder / "out", result, curves, ARM)
    assert tree(tmp_path / "one") == tree(tmp_path / "two")
    assert set(FILES) == {path.name for path in (tmp_path / "one" / "out").iterdir()}


def test_least_squares_loads_no_torch(tmp_path):
    code = f"""
import sys
from pathlib import Path
from test_ownarm import FILES, ARM, identify, write_all
folder = Path({str(tmp_path)!r})
_, result, curves = identify(folder, ("ordinary", "consistent"), validate=False)
print([m.method for m in result.methods], "torch" in sys.modules)
"""
    places = os.pathsep.join((str(ROOT / "src"), str(ROOT / "tests")))
    environment = {**os.environ, "PYTHONPATH": places}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert run.stdout == "['ordinary', 'consistent'] False\n", run.stderr


def test_methods_come_in_the_order_asked_for(tmp_path):
    names = ("robust", "ordinary", "consistent")
    assert [m.name for m in resolve(Options(names, tmp_path), silent)] == list(names)
    with pytest.raises(KeyError):
        resolve(Options(("guess",), tmp_path), silent)


def test_progress_is_reported_and_methods_are_told_when_done():
    problem, reported, done = problem_of(noisy(BETA, n=200)), [], []
    methods = [METHODS[name] for name in ("ordinary", "weighted")]
    found = solve_all(problem, methods, 1, lambda *what: reported.append(what), done.append)
    assert done == found
    for m in methods:
        steps = [(k, n) for what, k, n, _ in reported if m.title in what]
        assert steps == [(k, steps[0][1]) for k in range(1, steps[0][1] + 1)]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"methods": ()}, "at least one"),
        ({"filter": "median"}, "filter: must be one of"),
        ({"cutoff": 0.0}, "cutoff: must be positive"),
        ({"cutoff": -1.0}, "cutoff: must be positive"),
        ({"cutoff": float("nan")}, "cutoff: must be positive"),
        ({"cutoff": float("inf")}, "cutoff: must be positive"),
    ],
)
def test_options_that_cannot_be_are_refused(tmp_path, changes, words):
    with pytest.raises(ValueError, match=words):
        Options(**{"methods": ("ordinary",), "cache": tmp_path, **changes})


def made(folder, arm=ARM, options=None, **log):
    options = options or Options(("ordinary",), folder)
    return make_problem(read(write_log(folder / "log.csv", **log), arm), (), arm, options)


@pytest.mark.parametrize("late", [-0.006, 0.0, 0.005])
def test_the_delay_is_found(tmp_path, late):
    assert made(tmp_path, late=late).settings.delay == pytest.approx(late, abs=3e-4)


def test_a_delay_that_is_given_is_used(tmp_path):
    problem = made(tmp_path, replace(ARM, delay=0.004), late=0.01)
    assert problem.settings.delay == 0.004


def test_a_delay_beyond_what_is_looked_at_is_warned_of(tmp_path):
    problem = made(tmp_path, late=0.05)
    (line,) = warnings(problem, (GOOD,), "a", TELLING)
    assert "delay" in line


@pytest.mark.parametrize("steepness", [10.0, 50.0])
def test_the_steepness_of_friction_is_found_where_it_is_not_given(tmp_path, steepness):
    auto = made(tmp_path, replace(ARM, friction_steepness=None), steepness=steepness)
    assert auto.settings.friction_steepness == steepness
    given_one = made(tmp_path, replace(ARM, friction_steepness=33.0), steepness=steepness)
    assert given_one.settings.friction_steepness == 33.0


def test_a_cutoff_that_is_given_is_used(tmp_path):
    problem = made(tmp_path, options=Options(("ordinary",), tmp_path, cutoff=3.5))
    assert problem.settings.cutoff == problem.cutoff.hertz == 3.5
    assert problem.cutoff.reason == "given by the user"
    wide = [r.settings.cutoff for r in problem.as_good]
    assert min(wide) < 3.5 < max(wide)
    with pytest.raises(InputError, match=r"log\.csv: rate: found 200 Hz, expected at least four times .* 60 Hz"):
        made(tmp_path, options=Options(("ordinary",), tmp_path, cutoff=60.0))


def test_a_validation_log_too_slow_for_the_cutoff_is_named(tmp_path):
    log = read(write_log(tmp_path / "log.csv"), ARM)
    slow = read(write_log(tmp_path / "slow.csv", seconds=30.0, rate=10.0), ARM)
    with pytest.raises(InputError, match=r"slow\.csv: rate: found 10 Hz"):
        make_problem(log, (slow,), ARM, Options(("ordinary",), tmp_path, cutoff=5.0))


def test_a_log_is_told_of_as_it_was_recorded(tmp_path):
    t = np.arange(2400) / 200.0
    jitter = t + 1e-3 * np.random.default_rng(0).uniform(-1.0, 1.0, t.size)
    r = recording(jitter)
    (tmp_path / "log.csv").write_text(text(columns(r)), encoding="utf-8")
    found = read(tmp_path / "log.csv", ARM)
    assert np.diff(found.log.t) == pytest.approx(np.median(np.diff(found.log.t)), rel=1e-6)
    assert any("resampled" in note for note in found.description.notes)
    assert len(set(found.description.notes)) == len(found.description.notes)
    assert set(found.log.notes) <= set(found.description.notes)
    assert dict(found.description.facts)["samples"] == "2400"


@pytest.mark.parametrize("name", ["savitzky-golay", "butterworth"])
def test_other_filters_find_the_arm_too(tmp_path, name):
    problem = made(tmp_path, options=Options(("ordinary",), tmp_path, filter=name))
    found = METHODS["ordinary"].estimate(problem.regression).beta
    assert found[:5] == pytest.approx(BETA[:5], rel=0.01)
    assert found[5:] == pytest.approx(BETA[5:], rel=0.03)
