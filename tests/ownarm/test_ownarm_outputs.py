"""The files of `repro identify`: all of them or none, and none that contradicts the others."""

import errno
import io
import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from ownarm_example import LOGS, example_curves, example_result, parameters, score
from ownarm_problem import ARM, FILES, tree
from PIL import Image

from repro.errors import InputError
from repro.export import links_of
from repro.files import check_folder, fill_folder
from repro.identification.least_squares import METHODS
from repro.identification.method import NETWORKS
from repro.ownarm import outputs
from repro.ownarm.outputs import bibtex, citations, entries, write_result

SOURCES = {"ols": "gautier1992exciting", "consistent": "sousa2014physical", "cnn": "cnn_identification"}


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


def everything(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


def refuse_constant(name):
    raise AssertionError(name)


@pytest.mark.usefixtures("small_figures")
def test_the_files_of_a_result(tmp_path):
    result, curves = example()
    assert write_result(tmp_path / "new" / "out", result, curves, ARM) == FILES
    assert everything(tmp_path) == ["new", "new/out", *(f"new/out/{name}" for name in FILES)]
    page = (tmp_path / "new" / "out" / "report.html").read_text(encoding="utf-8")
    assert all(f'href="{name}"' in page for name in FILES if name not in ("report.html", "provenance.json"))


@pytest.mark.usefixtures("small_figures")
def test_the_json_holds_the_result_and_no_nan(tmp_path):
    result, curves = example()
    endless = replace(result.methods[0], fit=score(LOGS[0], np.inf, 0.2), whiteness=(np.nan, 0.5))
    result = replace(
        result, methods=(endless, *result.methods[1:]), excitation=replace(result.excitation, condition=np.inf)
    )
    write_result(tmp_path / "out", result, curves, ARM)
    found = json.loads((tmp_path / "out" / "parameters.json").read_text(), parse_constant=refuse_constant)
    assert found["methods"][0]["fit"]["relative_rms"] == [None, 0.2]
    assert found["methods"][0]["whiteness"] == [None, 0.5]
    assert found["excitation"]["condition"] is None
    expected = json.loads(json.dumps(asdict(result)))  # tuples become lists
    for part in (found, expected):
        del part["methods"][0], part["excitation"]
    assert found == expected


@pytest.mark.slow
@pytest.mark.usefixtures("small_figures")
@pytest.mark.parametrize(
    "writer", ["figures_of", "render_page", "bibtex", "tables.scores_table", "mjcf", "tables.residuals_table"]
)
@pytest.mark.parametrize("there", ["nothing", "an empty folder", "a result"])
def test_a_writer_that_fails_leaves_everything_as_it_was(tmp_path, monkeypatch, writer, there):
    out = tmp_path / "new" / "deep" / "out"
    if there == "an empty folder":
        out.mkdir(parents=True)
    if there == "a result":
        write_result(out, *example(recommended="cnn"), ARM)
        (out / "notes.txt").write_text("my own")
    names, files = everything(tmp_path), tree(tmp_path)

    def fail(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(f"repro.ownarm.outputs.{writer}", fail)
    with pytest.raises(InputError, match="no space left"):
        write_result(out, *example(), ARM)
    assert everything(tmp_path) == names
    assert tree(tmp_path) == files


def without_links(result):
    """The result with friction that no set of two links has."""
    changed = tuple(replace(m, parameters=parameters(1.0, b2=-0.03), consistent=False) for m in result.methods)
    return replace(result, methods=changed)


@pytest.mark.slow
@pytest.mark.usefixtures("small_figures")
@pytest.mark.parametrize("links_first", [True, False])
def test_overwriting_leaves_no_export_that_contradicts_the_result(tmp_path, links_first):
    out, (result, curves) = tmp_path / "out", example()
    with_links, none = (result, curves), (without_links(result), curves)
    first, second = (with_links, none) if links_first else (none, with_links)
    before = write_result(out, *first, ARM)
    (out / "arm.sdf").write_text("mine")
    names = write_result(out, *second, ARM)
    assert ("arm.urdf" in before, "no-links.txt" in names) == (links_first, links_first)
    assert everything(out) == sorted([*names, "arm.sdf"])
    assert (out / "arm.sdf").read_text() == "mine"
    write_result(tmp_path / "fresh", *second, ARM)
    kept, fresh = tree(out), tree(tmp_path / "fresh")
    del kept["arm.sdf"]
    for files in (kept, fresh):
        del files["provenance.json"]  # which says when
    assert kept == fresh


def test_a_folder_that_cannot_be_used_is_refused(tmp_path):
    full, file = tmp_path / "full", tmp_path / "file"
    full.mkdir()
    (full / "x").touch()
    file.touch()
    for out, overwrite, words in (
        (file, False, "a file"),
        (file, True, "a file"),
        (full, False, "a folder with files in it"),
        (file / "out", False, "Not a directory"),
        (file / "deep" / "out", True, "Not a directory"),
    ):
        with pytest.raises(InputError, match=words) as refused:
            check_folder(out, overwrite)
        assert "\n" not in str(refused.value)
        assert str(tmp_path) in str(refused.value)
    assert everything(tmp_path) == ["file", "full", "full/x"]


def test_a_folder_in_the_place_of_a_result_leaves_all_as_it_was(tmp_path):
    (tmp_path / "out" / "b.csv").mkdir(parents=True)

    def fill(folder):
        (folder / "a.csv").touch()
        (folder / "b.csv").touch()

    with pytest.raises(InputError, match=r"b\.csv: found a folder"):
        fill_folder(tmp_path / "out", fill)
    assert everything(tmp_path) == ["out", "out/b.csv"]


@pytest.mark.parametrize("to", ["earlier", "out"])
def test_a_file_that_cannot_be_moved_leaves_all_as_it_was(tmp_path, monkeypatch, to):
    def fill(folder):
        for name in ("a.csv", "b.csv", "c.csv"):
            (folder / name).write_text("new")

    rename = Path.rename

    def immutable(path, target):
        if path.name == "b.csv" and target.parent.name == to and path.parent.name != "earlier":
            raise OSError(errno.EPERM, "Operation not permitted")
        return rename(path, target)

    for name in ("a.csv", "b.csv", "no-links.txt"):
        (tmp_path / "out").mkdir(exist_ok=True)
        (tmp_path / "out" / name).write_text("old")
    monkeypatch.setattr(Path, "rename", immutable)
    with pytest.raises(InputError, match="Operation not permitted"):
        fill_folder(tmp_path / "out", fill, ["no-links.txt"])
    assert everything(tmp_path) == ["out", "out/a.csv", "out/b.csv", "out/no-links.txt"]
    assert {path.read_text() for path in (tmp_path / "out").iterdir()} == {"old"}


@pytest.mark.usefixtures("small_figures")
@pytest.mark.parametrize(("change", "words"), [({"b2": -0.03}, "b2 = -0.03"), ({}, "I2^2 / 4")])
def test_without_links_a_file_says_why(tmp_path, change, words):
    changed = parameters(1.0, **change)
    if not change:  # an inertia matrix that is not positive definite
        changed = (changed[0], replace(changed[1], estimate=0.3), *changed[2:])
    result, curves = example()
    result = replace(result, methods=tuple(replace(m, parameters=changed, consistent=False) for m in result.methods))
    names = write_result(tmp_path / "out", result, curves, ARM)
    assert names == sorted({*FILES, "no-links.txt"} - {"arm.urdf", "arm.xml"})
    line = (tmp_path / "out" / "no-links.txt").read_text(encoding="utf-8")
    assert words in line
    assert line.count("\n") == 1
    with pytest.raises(ValueError, match="must"):
        links_of(np.array([p.estimate for p in changed]))


@pytest.mark.usefixtures("small_figures")
def test_models_of_a_useless_fit_say_so(tmp_path):
    result, curves = example()
    poor = tuple(replace(m, fit=score("log.csv", 0.1, 0.51)) for m in result.methods)
    write_result(tmp_path / "out", replace(result, methods=poor), curves, ARM)
    for name in ("arm.urdf", "arm.xml"):
        assert "DO NOT USE: Eq. 1 leaves up to 51 %" in (tmp_path / "out" / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("filter_name", ["zero-phase DCT pair", "Savitzky-Golay, cubic"])
@pytest.mark.parametrize("name", [*METHODS, *NETWORKS])
def test_every_source_that_is_cited_exists(name, filter_name):
    result, _ = example()
    citation = METHODS[name].citation if name in METHODS else "cnn_identification"
    claims = name not in NETWORKS
    one = replace(result.methods[0], method=name, citation=citation, claims_intervals=claims)
    result = replace(result, methods=(one,), preparation=replace(result.preparation, filter=filter_name))
    keys = citations(result)
    assert len(set(keys)) == len(keys)
    assert set(keys) <= set(entries())
    assert {"cnn_identification", citation} <= set(keys)
    for source in ("kunsch1989jackknife", "kott2001delete", "jcgm2008gum", "cook1994simex", "baranchik1970family"):
        assert (source in keys) == claims
    assert ("savitzky1964smoothing" in keys) == filter_name.startswith("Savitzky")
    assert bibtex(keys).count("@") == len(keys)


@pytest.mark.usefixtures("small_figures")
@pytest.mark.parametrize("name", ["=1+1.csv", "+1.csv", "-1.csv", "@a.csv"])
def test_the_name_of_a_log_is_no_formula_in_a_table(tmp_path, name):
    result, curves = example()
    methods = tuple(replace(m, fit=replace(m.fit, log=name)) for m in result.methods)
    signals = tuple(replace(s, name=name) for s in curves.signals)
    write_result(tmp_path / "out", replace(result, methods=methods), replace(curves, signals=signals), ARM)
    scores = pd.read_csv(tmp_path / "out" / "scores.csv")
    assert set(scores.log[scores.part == "fit"]) == {f"'{name}"}
    assert set(pd.read_csv(tmp_path / "out" / "residuals.csv").log) == {f"'{name}"}
