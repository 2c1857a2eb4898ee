"""Tutorials run as pages show them, and their scripts become pages."""

import pytest
from experiment_example import ROOT
from printed import same_output
from realdata import folder, needs_real_data

from repro.report.tutorial import cells, run_tutorial

KEPT = ROOT / "docs" / "reference" / "tutorials"


def test_a_cell_that_fails_leaves_no_page(tmp_path):
    script = tmp_path / "bad.py"
    script.write_text("# %%\n1 / 0\n", encoding="utf-8")
    with pytest.raises(ZeroDivisionError):
        run_tutorial(script, tmp_path / "bad.md", str(folder()))
    assert not (tmp_path / "bad.md").exists()


@pytest.mark.parametrize("script", sorted((ROOT / "docs" / "tutorials").glob("*.py")), ids=lambda path: path.stem)
def test_kept_pages_show_the_cells_of_their_scripts(script):
    page = (KEPT / f"{script.stem}.md").read_text(encoding="utf-8")
    for is_text, content in cells(script.read_text(encoding="utf-8")):
        assert (content if is_text else f"```python\n{content}\n```") in page


@pytest.mark.slow
@pytest.mark.parametrize("name", ["board", pytest.param("real-arm", marks=needs_real_data)])
def test_a_tutorial_makes_the_page_that_is_kept(name, tmp_path):
    page = tmp_path / "out" / f"{name}.md"
    run_tutorial(ROOT / "docs" / "tutorials" / f"{name}.py", page, str(folder()))
    made, kept = (each.read_text(encoding="utf-8") for each in (page, KEPT / f"{name}.md"))
    assert same_output(made, kept), made
    assert {each.name for each in page.parent.iterdir()} == {each.name for each in KEPT.glob(f"{name}*")}
    assert page.with_name(f"{name}-1.png").read_bytes().startswith(b"\x89PNG")
