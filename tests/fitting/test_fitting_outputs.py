"""The files of `repro identify`: all of them or none, and none that contradicts the others."""

import errno
import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from experiment_example import refused
from fitting_example import example_curves, example_result, parameters, score
from fitting_problem import ARM, FILES, tree

from repro.files import check_folder, fill_folder
from repro.fitting import outputs, tables
from repro.fitting.outputs import bibtex, citations, entries, write_result
from repro.fitting.result import Curves
from repro.fitting.text import NOT_EXCITED
from repro.identification.least_squares import METHODS
from repro.identification.method import NETWORKS

pytestmark = pytest.mark.usefixtures("no_figures")
CURVES = example_curves(3.0)


def everything(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


def test_the_json_holds_the_result_and_no_nan_and_the_page_links_every_file(tmp_path):
    result, out = example_result(), tmp_path / "new" / "out"
    fit = replace(result.methods[0].fit, relative_rms=(np.inf, 0.2))
    endless = replace(result.methods[0], fit=fit, whiteness=(np.nan, 0.5))
    result = replace(result, methods=(endless, *result.methods[1:]))
    assert write_result(out, result, CURVES, ARM) == FILES
    assert everything(tmp_path) == ["new", "new/out", *(f"new/out/{name}" for name in FILES)]
    found = json.loads((out / "parameters.json").read_text(), parse_constant=pytest.fail)
    expected = json.loads(json.dumps(asdict(result)))  # tuples become lists
    expected |= {"setup": expected.pop("calibration_errors"), "hidden": expected.pop("calibration_limits")}
    expected["methods"][0]["fit"]["relative_rms"][0] = expected["methods"][0]["whiteness"][0] = None
    assert found == expected
    page = (out / "report.html").read_text(encoding="utf-8")
    assert all(f'href="{name}"' in page for name in FILES if name not in ("report.html", "provenance.json"))


@pytest.mark.slow
@pytest.mark.parametrize("there", ["nothing", "a result"])
def test_a_writer_that_fails_leaves_everything_as_it_was(tmp_path, monkeypatch, there):
    out = tmp_path / "new" / "deep" / "out"
    if there == "a result":
        write_result(out, example_result(recommended="cnn"), CURVES, ARM)
    before = everything(tmp_path), tree(tmp_path)

    def fail(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(outputs, "render_page", fail)
    assert refused(write_result, out, example_result(), CURVES, ARM).place == str(out)
    assert (everything(tmp_path), tree(tmp_path)) == before


@pytest.mark.slow
@pytest.mark.parametrize("links_first", [True, False])
def test_overwriting_leaves_no_export_that_contradicts_the_result(tmp_path, links_first):
    """One of the results has friction that no set of two links has."""
    result, out = example_result(), tmp_path / "out"
    bad = tuple(replace(m, parameters=parameters(1.0, b2=-0.03), consistent=False) for m in result.methods)
    results = [result, replace(result, methods=bad)]
    first, second = results if links_first else reversed(results)
    before = write_result(out, first, CURVES, ARM)
    (out / "arm.sdf").write_text("mine")
    (out / "runs.csv").write_text("of several logs")
    names = write_result(out, second, CURVES, ARM)
    assert ("arm.urdf" in before, "no-links.txt" in names) == (links_first, links_first)
    write_result(tmp_path / "fresh", second, CURVES, ARM)
    overwritten, fresh = tree(out), tree(tmp_path / "fresh")
    assert overwritten.pop("arm.sdf") == b"mine"
    for files in (overwritten, fresh):
        del files["provenance.json"]  # which says when
    assert overwritten == fresh


@pytest.mark.parametrize("name", ["I1", "g2"])
def test_links_need_what_masses_and_lengths_depend_on(tmp_path, name):
    result = example_result()
    p = tuple(replace(p, verdict=NOT_EXCITED) if p.name == name else p for p in result.best.parameters)
    methods = tuple(replace(m, parameters=p) for m in result.methods)
    assert "no-links.txt" in write_result(tmp_path, replace(result, methods=methods), CURVES, ARM)
    assert f" {name}, " in (tmp_path / "no-links.txt").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("out", "overwrite", "words"),
    [
        ("file", False, "a file"),
        ("file", True, "a file"),
        ("full", False, "a folder with files in it"),
        ("file/out", False, "not a directory"),
        ("file/deep/out", True, "not a directory"),
    ],
)
def test_a_folder_that_cannot_be_used_is_refused_in_one_line(tmp_path, out, overwrite, words):
    (tmp_path / "full").mkdir()
    for name in ("file", "full/x"):
        (tmp_path / name).touch()
    error = refused(check_folder, tmp_path / out, overwrite)
    assert words in str(error) and str(tmp_path) in error.place
    assert everything(tmp_path) == ["file", "full", "full/x"]


def fill(folder):
    for name in ("a.csv", "b.csv", "c.csv"):
        (folder / name).write_text("new")


def test_a_folder_in_the_place_of_a_result_leaves_all_as_it_was(tmp_path):
    (tmp_path / "out" / "b.csv").mkdir(parents=True)
    assert refused(fill_folder, tmp_path / "out", fill).place == str(tmp_path / "out/b.csv")
    assert everything(tmp_path) == ["out", "out/b.csv"]


@pytest.mark.parametrize("to", ["earlier", "out"])
def test_a_file_that_cannot_be_moved_leaves_all_as_it_was(tmp_path, monkeypatch, to):
    rename, old = Path.rename, {"a.csv": b"old", "b.csv": b"old", "no-links.txt": b"old"}

    def immutable(path, target):
        if path.name == "b.csv" and target.parent.name == to and path.parent.name != "earlier":
            raise OSError(errno.EPERM, "Operation not permitted")
        return rename(path, target)

    (tmp_path / "out").mkdir()
    for name, content in old.items():
        (tmp_path / "out" / name).write_bytes(content)
    monkeypatch.setattr(Path, "rename", immutable)
    refused(fill_folder, tmp_path / "out", fill, ["no-links.txt"])
    assert tree(tmp_path / "out") == old
    assert everything(tmp_path) == ["out", *(f"out/{name}" for name in old)]


def test_models_of_a_useless_fit_say_so(tmp_path):
    result = example_result()
    poor = tuple(replace(m, fit=score("log.csv", 0.1, 0.51)) for m in result.methods)
    write_result(tmp_path, replace(result, methods=poor), CURVES, ARM)
    for name in ("arm.urdf", "arm.xml"):
        assert "51 %" in (tmp_path / name).read_text(encoding="utf-8")


@pytest.mark.parametrize(("names", "filter_name"), [(METHODS, "Savitzky-Golay, cubic"), (NETWORKS, "DCT pair")])
def test_every_source_that_is_cited_exists(names, filter_name):
    result, claims = example_result(), names is METHODS
    cited = {name: METHODS[name].citation if claims else "cnn_identification" for name in names}
    one = replace(result.methods[0], claims_intervals=claims)
    methods = tuple(replace(one, method=name, citation=citation) for name, citation in cited.items())
    keys = citations(replace(result, methods=methods, preparation=replace(result.preparation, filter=filter_name)))
    assert len(set(keys)) == len(keys) == bibtex(keys).count("@")
    assert {"cnn_identification", *cited.values()} <= set(keys) <= set(entries())
    for source in ("kunsch1989jackknife", "kott2001delete", "jcgm2008gum", "cook1994simex", "baranchik1970family"):
        assert (source in keys) == claims
    assert ("savitzky1964smoothing" in keys) == claims


@pytest.mark.parametrize("name", ["=1+1.csv", "+1.csv", "-1.csv", "@a.csv"])
def test_the_name_of_a_log_is_no_formula_in_a_table(name):
    result = example_result()
    methods = tuple(replace(m, fit=replace(m.fit, log=name)) for m in result.methods)
    scores = tables.scores_table(replace(result, methods=methods))
    assert set(scores.log[scores.part == "fit"]) == {f"'{name}"}
    residuals = tables.residuals_table(result, Curves((replace(CURVES.signals[0], name=name),)))
    assert set(residuals.log) == {f"'{name}"}
