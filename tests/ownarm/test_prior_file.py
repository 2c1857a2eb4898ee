"""A prior from a file, and an arm in a horizontal plane, from log to files."""

import json
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from log_example import BETA
from ownarm_problem import ARM, prepared_from_file, solved, write_log

from repro.cli import main
from repro.errors import InputError
from repro.identification.least_squares import METHODS
from repro.model.parameters import NAMES, UNITS, Links, inertial_from_links
from repro.ownarm.outputs import write_result
from repro.ownarm.prepare import Options
from repro.ownarm.prior import read_prior

LEVEL = replace(ARM, plane="horizontal", link_lengths=(0.3, 0.25))
GOOD = {"value": 1.0, "sd": 0.1}


def test_a_prior_is_read_from_values_and_from_a_result():
    prior = read_prior({"g1": GOOD, "k2": {"value": 0, "sd": 0}})
    assert np.flatnonzero(np.isfinite(prior.sd)).tolist() == [3, 8]
    assert (prior.mean[3], prior.sd[3], prior.sd[8]) == (1.0, 0.1, 0.0)
    rows = [
        {"name": n, "unit": u, "estimate": 2.0, "low": 1.804, "high": 2.196} for n, u in zip(NAMES, UNITS, strict=True)
    ]
    rows[1] |= {"low": None, "high": None}
    prior = read_prior({"recommended": "a", "methods": [{"method": "a", "parameters": rows}]})
    assert np.flatnonzero(~np.isfinite(prior.sd)).tolist() == [1]
    assert prior.sd[0] == pytest.approx(0.1)
    assert prior.mean[0] == 2.0


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({}, "no parameter with a standard deviation"),
        ([], "no parameter with a standard deviation"),
        ({"g3": GOOD}, "g3: found no parameter"),
        ({"g1": 1.0}, "g1: found 1.0, expected value and sd"),
        ({"g1": {"value": 1.0}}, "g1: found {'value': 1.0}"),
        ({"g1": {"value": "1", "sd": 0.1}}, "g1.value: found '1', expected a number"),
        ({"g1": {"value": 1.0, "sd": -0.1}}, "g1.sd: found -0.1, expected a number from 0"),
        ({"g1": {"value": 1.0, "sd": 1e-9}}, "g1.sd: found 1e-09, expected 0 for a known value"),
        ({"b1": {"value": -1.0, "sd": 0.1}}, "b1.value: found -1.0, expected a number from 0"),
        ({"methods": []}, "no recommended method"),
    ],
)
def test_a_bad_prior_is_refused_in_one_line(tmp_path, capsys, content, words):
    file = tmp_path / "prior.json"
    file.write_text(json.dumps(content))
    command = ["identify", str(write_log(tmp_path / "log.csv")), "--prior", str(file), "-o", str(tmp_path / "out")]
    assert main(command) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert words in line
    assert "prior.json" in line
    assert not (tmp_path / "out").exists()
    assert main([*command, "--method", "algorithm1"]) == 2


@pytest.mark.slow
def test_next_to_a_prior_least_squares_is_the_default(tmp_path):
    (tmp_path / "prior.json").write_text(json.dumps({"g1": GOOD}))
    command = ["identify", write_log(tmp_path / "log.csv"), "--prior", tmp_path / "prior.json", "-o", tmp_path / "out"]
    assert main([*map(str, command)]) == 0
    content = json.loads((tmp_path / "out/parameters.json").read_text())
    assert [method["method"] for method in content["methods"]] == list(METHODS)


@pytest.mark.slow
def test_the_verdict_reports_the_weight_of_the_prior(tmp_path):
    prior = read_prior(
        {"I1": {"value": BETA[0], "sd": 1e-6}, "g1": {"value": BETA[3], "sd": 10.0}, "k1": {"value": 0.2, "sd": 0}}
    )
    problem = prepared_from_file(tmp_path, options=Options(("ordinary",), tmp_path, prior=prior))
    result, _ = solved(problem)
    i1, g1, k1, b1 = (result.best.parameters[k] for k in (0, 3, 7, 5))
    assert i1.prior_weight == pytest.approx(1.0, abs=0.1)
    assert "mostly from the prior" in i1.verdict
    assert g1.prior_weight < 0.01
    assert "prior" not in g1.verdict
    assert (k1.estimate, k1.low, k1.prior_weight) == (0.2, None, 1.0)
    assert b1.prior_weight == 0.0
    assert set(result.prior) == {"I1", "g1", "k1"}


@pytest.mark.slow
def test_an_arm_in_a_horizontal_plane(tmp_path):
    level = BETA * np.array([1, 1, 1, 0, 0, 1, 1, 1, 1])
    problem = prepared_from_file(tmp_path, LEVEL, beta=level)
    result, curves = solved(problem, METHODS, LEVEL)
    assert result.excitation.rank == 9
    for method in result.methods:
        found = np.array([p.estimate for p in method.parameters])
        assert (found[3:5] == 0.0).all()
        assert found == pytest.approx(level, rel=0.02, abs=1e-9), method.method
        assert method.consistent
        assert max(method.fit.relative_rms) < 0.01
        assert max(method.fit.position_rms) < 2e-3
        assert all(p.verdict.startswith("not estimated") for p in method.parameters[3:5])
    write_result(tmp_path / "out", result, curves, LEVEL)
    model = ElementTree.parse(tmp_path / "out/arm.xml")
    assert [float(x) for x in model.find("option").get("gravity").split()] == [0.0, 0.0, 0.0]
    best = np.array([p.estimate for p in result.best.parameters])
    inertial = [one.find("inertial") for one in model.findall(".//body") if one.find("inertial") is not None]
    (m1, lc1, j1), (m2, lc2, j2) = (
        (float(one.get("mass")), -float(one.get("pos").split()[2]), float(one.get("diaginertia").split()[1]))
        for one in inertial
    )
    assert lc1 == pytest.approx(0.5 * 0.3)  # a uniform rod
    links = Links(m1=m1, m2=m2, l1=0.3, lc1=lc1, lc2=lc2, j1=j1, j2=j2)
    assert inertial_from_links(links)[:3] == pytest.approx(best[:3], rel=1e-9)
    without = replace(LEVEL, link_lengths=None)
    assert "no-links.txt" in write_result(tmp_path / "none", result, curves, without)
    with pytest.raises(InputError, match="plane of the arm is horizontal"):
        prepared_from_file(tmp_path, LEVEL, Options(("ordinary",), tmp_path, prior=read_prior({"g1": GOOD})))
