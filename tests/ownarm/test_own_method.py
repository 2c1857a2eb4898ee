"""The method that the guide adds runs as it is printed."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from log_example import BETA
from ownarm_problem import ARM, prepared_from_file, silent

from repro.identification import least_squares
from repro.ownarm import outputs
from repro.ownarm.evaluate import assemble, fit_all

DOCS = Path(__file__).resolve().parents[2] / "docs"
HEADING = "Adding a method\n"


def test_the_method_of_the_guide_runs_as_printed(tmp_path, monkeypatch):
    pages = [path.read_text(encoding="utf-8") for path in sorted(DOCS.rglob("*.md"))]
    (section,) = [page.split(f"# {HEADING}")[1] for page in pages if f"# {HEADING}" in page]
    code, entry = re.findall(r"^```python\n(.*?)^```", section, re.MULTILINE | re.DOTALL)
    scope = dict(vars(least_squares))
    exec(code, scope)
    (method,) = eval(entry, scope)
    source = f"@book{{{method.citation},\n  title = {{Ridge regression}}\n}}\n"
    file = tmp_path / "methods.bib"
    file.write_text(outputs.METHODS_FILE.read_text(encoding="utf-8") + "\n" + source, encoding="utf-8")
    monkeypatch.setattr(outputs, "METHODS_FILE", file)
    problem = prepared_from_file(tmp_path)
    result, curves = assemble(problem, fit_all(problem, [method], 1, silent), ARM)
    outputs.write_result(tmp_path / "out", result, curves, ARM)
    (written,) = json.loads((tmp_path / "out/parameters.json").read_text())["methods"]
    assert written["method"] == "ridge"
    assert np.array([p["estimate"] for p in written["parameters"]]) == pytest.approx(BETA, rel=0.05)
    assert all(p["low"] < p["estimate"] < p["high"] for p in written["parameters"])
    assert f"{{{method.citation}," in (tmp_path / "out/methods.bib").read_text()
