"""The audit of the paper: each number again with none of our code, and each finding alive to what it rests on."""

import math
import re

import numpy as np
import pytest
from claims_example import printed_as
from literal import ARMS

from repro.files import read_rows
from repro.paper import audit as audit_module
from repro.paper.audit import CHECKS, findings, findings_table
from repro.paper.finding import FINDINGS_FILE, VERDICTS, Check, read_checks
from repro.paper.published import load_published

PUBLISHED = load_published()
# Tables 4 and 5: I1 I2 I3 of the estimates, typed again as the true sets in ARMS are.
ESTIMATE = {
    "N1": (0.7389, 0.2872, 0.5274),
    "N2": (0.4084, 0.5188, 0.8712),
    "N3": (0.4618, 1.0288, 0.4186),
    "N4": (0.5657, 0.6752, 0.2604),
}
IMPOSSIBLE = {("N2", "true"), ("N3", "true"), ("N2", "algorithm1"), ("N3", "algorithm1"), ("N4", "algorithm1")}


@pytest.fixture(scope="module")
def before():
    return findings(PUBLISHED)


@pytest.fixture(scope="module")
def table():
    return findings_table().set_index("id")


def test_table_is_tidy_and_each_check_has_a_row(table):
    assert table.index.is_unique and len(table) > 60
    assert set(CHECKS) <= {check.id for check in read_checks(PUBLISHED)}
    assert set(table["verdict"]) == set(VERDICTS)
    assert (table[["place", "what", "arithmetic"]].map(len) > 0).all(axis=None)
    assert {i for row in table["numbers"] for i in row.split()} <= {v.id for v in PUBLISHED}
    text = " ".join(table[["what", "arithmetic", "note"]].to_numpy().ravel())
    assert text.isascii() and "nan" not in text.split()


# T4, Algorithm 1, joint 1, half a digit down in time and up in frequency; the torque is its square root.
COULOMB = math.sqrt((1 - 0.99905**2.5) / (1 - (1 - (1 - 0.93215**2.5) ** 2 / 2) ** 2))
# Arithmetic on the print, typed again: id, found, held against.
EXPECTED = [
    ("composition/table07", 7, 8),
    ("composition/table10", 18, 20),
    ("composition/table07/N1/total/joint2", 99.68 * 0.9859, 98.25),
    ("composition/table10/T2/algorithm1/total/joint2", 99.11 * 0.9101, 90.02),
    ("composition/table10/T2/least-squares/total/joint2", 98.65 * 0.8969, 85.82),
    ("abstract/experimental/total", 90.01, 93.55),
    ("section7/experimental/total", 93.91, 93.91),
    ("section6/experimental/total", 2, 8),
    ("section6/experimental/threshold", (93.55 + 94.51) / 2, 92.37),
    ("least-squares/identification", 1, 2),
    ("least-squares/validation", 8, 8),
    ("table10/coulomb-friction", COULOMB, math.sqrt(7.1236e-8) / 0.001),
    ("range/I1", 3 * 0.01 + 0.1 + 1, 0.6944),
    ("range/I2", 2 * 0.1 * 0.1, 0.9779),
    ("range/I3", 0.01 + 1, 0.8725),
    ("range/g1", 2 * 0.1 * 9.80665, 0.9296),
    ("range/g2", 0.1 * 9.80665, 0.8523),
    ("range/I1-I3", 2 * 0.01 + 0.1, 0.6259 - 0.8725),
    ("range/friction", 0.5721, 1),
    ("range/l1", 0.5271 * 9.80665 / (2 * 0.8523), 0.1),
    ("range/reach", 2.52 / 8, 0.3),
    ("section3/sampling-rate", 1 / 0.0025, 400),
    ("section4a/band-high", 99 / (2 * 0.0025 * 3770), 33),
    ("section4b/train-images", 8000, 8000),
    ("section4b/test-images", 2000, 2000),
    ("section4b/loss-divisor", 9, 18),
    ("section4b/learning-rate-slope", 0.03, 0.02),
    ("section4b/sizes", ((100 - 8) / 2 - 4) / 2 - 2, 19),
    ("section4b/labels", -1, 1),
    ("eq16/blue", 5 / 3, 1),
    ("section3/encoder-step", 2 * math.pi / (64 * 131.25), 0.748e-3),
    ("section3/position-turns", 32767 / 8400, 3.9),
    ("section3/position-low", 65536, 2**16),
    ("section3/torque-unit", 100 / 1023, 0.0978),
    ("section3/torque-bits", 2048, 2**11),
    ("section3/torque-low", -102400 / 1023, -100),
    ("section5c/full-torque/joint1", 2.7192, 3),
    ("section5c/full-torque/joint2", 2.7314, 3),
    ("table08/kv/joint1", 1270.7266 * 0.748e-3, 2.7192),
    ("section3/frame", 8 + 16 + 16 + 11 + 11, 64),
    ("section3/logic-share", 668300 / 22320, 29.94),
    ("section3/memory-share", 100 * 8192 * 2 * 32 / 608256, 87),
    ("section6/T2/circle", 3.15, 252 / 8),
    ("appendix/determinant", 3.4422e-6 * 1.8986e-6 / 1e-4, 1.3659e-7 - 7.1236e-8),
    ("appendix/condition", 1.8986e-6 / 1e-4 / 3.4422e-6, 1e4),
    ("appendix/rate", 1.3659e-7, 7.1236e-8),
    ("appendix/arm", 6, 6),
    ("appendix/corner", 1e3 * np.roots([1.0, -(1.8986e-2 + 3.4422e-6), 1.3659e-7]).min(), 0.0072),
    ("appendix/gain", 1e4, 1),
]


@pytest.mark.parametrize(("id_", "found", "printed"), EXPECTED)
def test_numbers_recomputed(table, id_, found, printed):
    assert table.loc[id_, "found"] == pytest.approx(found, rel=1e-6 if id_ == "appendix/corner" else 1e-9)
    assert table.loc[id_, "printed"] == pytest.approx(printed, rel=1e-9)


@pytest.mark.parametrize("case", ARMS)
@pytest.mark.parametrize("method", ["true", "algorithm1"])
def test_inertia_matrices_by_their_eigenvalues(table, case, method):
    i1, i2, i3 = (ARMS if method == "true" else ESTIMATE)[case][:3]
    c = np.cos(np.linspace(-np.pi, np.pi, 721))
    m = np.moveaxis(np.array([[i1 + i2 * c, i3 + i2 * c / 2], [i3 + i2 * c / 2, i3 + 0 * c]]), -1, 0)
    row = table.loc[f"definite/{case}/{method}"]
    assert row["found"] == pytest.approx(np.linalg.det(m).min(), rel=1e-9)
    possible = (row["verdict"] != "not possible", np.linalg.eigvalsh(m).min() > 0)
    assert possible == ((case, method) not in IMPOSSIBLE,) * 2


def test_no_links_of_the_published_ranges_reach_the_arms(table):
    rng = np.random.default_rng(0)
    l1, lc1, lc2, j1 = rng.uniform(1e-3, 0.1, (4, 50_000))
    m1, m2, j2 = rng.uniform(1e-3, 1.0, (3, 50_000))
    i3 = m2 * lc2**2 + j2
    i1 = m1 * lc1**2 + j1 + m2 * l1**2 + i3
    drawn = {"I1": i1, "I2": 2 * m2 * l1 * lc2, "I3": i3, "I1-I3": i1 - i3, "g2": m2 * lc2 * 9.80665}
    for name, values in drawn.items():
        limit = table.loc[f"range/{name}", "found"]
        assert 0.8 * limit < values.max() < limit
    assert drawn["I2"].max() < min(beta[1] for beta in ARMS.values())
    outside = {id_.split("/")[1] for id_ in table.index[table["verdict"] == "outside its own range"]}
    assert outside == {"I2", "I1-I3", "l1", "reach"}


def test_ends_of_the_inequalities(table):
    cosine, sine, tanh = (table.loc[f"appendix/{name}", "found"] for name in ("cosine", "sine", "tanh"))
    for step, holds in ((-1e-3, True), (1e-3, False)):
        assert (1 - math.cos(cosine + step) > 0.1 * (cosine + step) ** 2) == holds
        assert (math.sin(sine + step) > 0.1 * (sine + step)) == holds
        assert (math.tanh(20 * (tanh + step)) > 0.0025 * 20 * (tanh + step)) == holds
    x = math.sqrt(2) * math.pi
    assert table.loc["appendix/cosine", "printed"] == pytest.approx(x)
    enough = float(re.search("rho = ([.0-9]+) would do", table.loc["appendix/cosine", "note"])[1])
    assert enough * x**2 <= 1 - math.cos(x) < (enough + 1e-3) * x**2
    # q = (3, 0) lies in the ball, and there q.g(q) < rho q.Qq for every arm.
    assert 3 * math.sin(3) < 0.1 * 9 and table.loc["appendix/sine", "printed"] > 3


def test_speed_of_the_identification_trajectory(table):
    t = np.linspace(0, 3 * np.pi, 200_001)
    q = np.array([np.sin(t) + 0.1 * np.cos(2.5 * t + 3), -np.cos(t) - 0.1 * np.sin(2.5 * t + 3)])
    assert table.loc["eq10/speed", "found"] == pytest.approx(np.abs(np.gradient(q, t, axis=1)).max(), rel=1e-4)


# One number printed otherwise: finding, what it says now.
TAMPERED = [
    ({"table10/T2/least-squares/total/joint2": "88.48"}, "composition/table10", "found", 19),
    ({"abstract/numeric/total": "95.90"}, "abstract/numeric/total/energy", "verdict", "consistent"),
    ({"abstract/experimental/total": "90.00"}, "abstract/experimental/total", "verdict", "consistent"),
    ({"section7/experimental/total": "94.51"}, "section7/experimental/total", "verdict", "contradicts itself"),
    ({"table10/T4/algorithm1/time/joint1": "99.94"}, "table10/coulomb-friction", "verdict", "contradicts itself"),
    ({"appendix/coupling": "1.9e-8"}, "table10/coulomb-friction", "verdict", "consistent"),
    ({"section4a/length-high": "1"}, "range/I2", "verdict", "consistent"),
    ({"section6/parameter-sets": "12e3"}, "repeated/section5a/parameter-sets", "verdict", "contradicts itself"),
    ({"section4a/band-high": "5"}, "section4a/band-high", "verdict", "consistent"),
    ({"section4b/learning-rate-slope": "-0.2e-7"}, "section4b/learning-rate-slope", "verdict", "consistent"),
    ({"section4b/kernel2/size": "6"}, "section4b/sizes", "verdict", "contradicts itself"),
    ({"section3/torque-low": "-1023"}, "section3/torque-low", "verdict", "consistent"),
    ({"section3/logic-share": "29.95"}, "section3/logic-share", "verdict", "contradicts itself"),
    ({"appendix/rho": "0.05"}, "appendix/cosine", "verdict", "consistent"),
    ({"appendix/energy": "6.9020e-5"}, "appendix/arm", "found", 6),
    ({"appendix/energy": "8.2020e-2"}, "appendix/arm", "verdict", "contradicts itself"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("numbers", "id_", "field", "expected"), TAMPERED)
def test_a_changed_number_changes_the_finding(before, numbers, id_, field, expected):
    (after,) = [each for each in findings(printed_as(numbers)) if each.id == id_]
    assert after not in before
    assert getattr(after, field) == (expected if isinstance(expected, str) else pytest.approx(expected))


@pytest.mark.slow
def test_no_number_that_a_finding_names_is_idle(monkeypatch):
    named, borne = set(), set()
    for row in read_rows(FINDINGS_FILE):
        monkeypatch.setattr(audit_module, "read_checks", lambda numbers, row=row: [Check(row, numbers)])
        own = findings(PUBLISHED)
        named |= {i for f in own for i in f.numbers}
        for id_ in {i for f in own for i in f.numbers} - borne:
            value = PUBLISHED[id_].value
            # Down or up: a count of cases may bear one of them.
            ways = (f"{0.5 * value:.6g}", f"{2.0 * value:.6g}") if value else ("1",)
            if any(findings(printed_as({id_: way})) != own for way in ways):
                borne.add(id_)
    assert named - borne == set()
