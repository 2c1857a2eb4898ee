"""A prior from a file, and an arm in a horizontal plane, from log to files."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from experiment_example import refused
from fitting_problem import ARM, prepared_from_file, solved, write_log
from log_example import BETA

from repro.cli import main
from repro.fitting.export import horizontal_links_of
from repro.fitting.outputs import write_result
from repro.fitting.prior import read_prior, with_plane
from repro.fitting.text import FIXED
from repro.model.parameters import NAMES, UNITS, inertial_from_links

LEVEL = replace(ARM, plane="horizontal", link_lengths=(0.3, 0.25))
GOOD = {"value": 1.0, "sd": 0.1}


def test_a_prior_is_read_from_values_and_from_a_result():
    prior = read_prior({"g1": GOOD, "k2": {"value": np.int64(0), "sd": 0}})
    assert np.flatnonzero(np.isfinite(prior.sd)).tolist() == [3, 8]
    assert (prior.mean[3], prior.sd[3], prior.sd[8]) == (1.0, 0.1, 0.0)
    row = {"estimate": 2.0, "low": 1.804, "high": 2.196}
    rows = [{"name": name, "unit": unit, **row} for name, unit in zip(NAMES, UNITS, strict=True)]
    rows[1]["low"] = rows[1]["high"] = None
    result = {"recommended": "a", "methods": [{"method": "a", "parameters": rows}]}
    prior = read_prior(result)
    assert np.flatnonzero(~np.isfinite(prior.sd)).tolist() == [1]
    assert (prior.mean[0], prior.sd[0]) == pytest.approx((2.0, 0.1))
    rows[0]["low"] = 2.2
    error = refused(read_prior, result)
    assert error.place.endswith("I1.low") and error.found == "2.2"


@pytest.mark.parametrize(
    ("content", "place", "found"),
    [
        ([], "", ""),
        ({"g3": GOOD}, "g3", "no parameter"),
        ({"g1": 1.0}, "g1", "1.0"),
        ({"g1": {"value": 1.0}}, "g1", "{'value': 1.0}"),
        ({"g1": {"value": "1", "sd": 0.1}}, "g1.value", "'1'"),
        ({"g1": {"value": 1.0, "sd": -0.1}}, "g1.sd", "-0.1"),
        ({"g1": {"value": 1.0, "sd": 1e-9}}, "g1.sd", "1e-09"),
        ({"b1": {"value": -1.0, "sd": 0.1}}, "b1.value", "-1.0"),
        ({"methods": []}, "", ""),
    ],
)
def test_a_bad_prior_is_refused_in_one_line(tmp_path, content, place, found):
    file = tmp_path / "prior.json"
    file.write_text(json.dumps(content))
    error = refused(read_prior, file)
    assert error.place == f"{file}: {place}".removesuffix(": ") and error.found.startswith(found)


def test_a_prior_is_refused_next_to_algorithm_1(tmp_path):
    (tmp_path / "prior.json").write_text(json.dumps({"g1": GOOD}))
    command = ["identify", write_log(tmp_path / "log.csv"), "--prior", tmp_path / "prior.json", "-o", tmp_path / "out"]
    assert main([*map(str, command), "--method", "algorithm1"]) == 2
    assert not (tmp_path / "out").exists()


def test_least_squares_is_the_default_and_networks_are_asked_for(tmp_path, monkeypatch):
    asked, result = [], SimpleNamespace(save=lambda *_: [])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("repro.fitting.api.identify", lambda _, method, **__: asked.append(method) or result)
    Path("level.yaml").write_text("plane: horizontal\n", encoding="utf-8")
    for more in ([], ["other.csv"], ["--prior", "prior.json"], ["--arm", "level.yaml"], ["--method", "algorithm1"]):
        assert main(["identify", "log.csv", *more, "-o", "out"]) == 0
    assert asked == [*4 * ["least-squares"], ["algorithm1"]]


@pytest.mark.slow
def test_an_arm_in_a_horizontal_plane(tmp_path, no_figures):
    level = BETA * np.array([1, 1, 1, 0, 0, 1, 1, 1, 1])
    problem = prepared_from_file(tmp_path, LEVEL, beta=level)
    result, curves = solved(problem, ("weighted", "bounded"), LEVEL)
    upright, _ = solved(prepared_from_file(tmp_path, LEVEL), ("ordinary",), LEVEL)
    for of, lines in ((result, 0), (upright, 2)):
        assert sum("contradicts" in line for line in of.warnings) == lines
    for method in result.methods:
        found = np.array([p.estimate for p in method.parameters])
        assert (found[3:5] == 0.0).all()
        assert found == pytest.approx(level, rel=0.02, abs=1e-9), method.method
        assert max(method.fit.position_rms) < 2e-3
        assert all(p.verdict == FIXED for p in method.parameters[3:5])
    write_result(tmp_path / "out", result, curves, LEVEL)
    assert 'gravity="0.0 0.0 0.0"' in (tmp_path / "out/arm.xml").read_text(encoding="utf-8")
    links = horizontal_links_of(found, LEVEL.link_lengths)
    assert (links.l1, links.lc1) == pytest.approx((0.3, 0.15))  # a uniform rod
    assert inertial_from_links(links)[:3] == pytest.approx(found[:3], rel=1e-9)
    assert "no-links.txt" in write_result(tmp_path / "none", result, curves, replace(LEVEL, link_lengths=None))
    assert "g1" in refused(with_plane, read_prior({"g1": GOOD}), LEVEL).place
