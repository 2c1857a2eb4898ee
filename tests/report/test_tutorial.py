"""Scripts of tutorials become pages; `.ci/code_blocks.py` runs them and compares what they print."""

import pytest
from experiment_example import ROOT

from repro.report.tutorial import cells, run_tutorial

KEPT = ROOT / "docs" / "reference" / "tutorials"


def test_a_cell_that_fails_leaves_no_page(tmp_path, monkeypatch):
    monkeypatch.setenv("REPRO_REALDATA", "")  # which the run sets for its process
    script = tmp_path / "bad.py"
    script.write_text("# %%\n1 / 0\n", encoding="utf-8")
    with pytest.raises(ZeroDivisionError):
        run_tutorial(script, tmp_path / "bad.md", "no logs")
    assert not (tmp_path / "bad.md").exists()


@pytest.mark.parametrize("script", sorted((ROOT / "docs" / "tutorials").glob("*.py")), ids=lambda path: path.stem)
def test_kept_pages_show_the_cells_of_their_scripts(script):
    page = (KEPT / f"{script.stem}.md").read_text(encoding="utf-8")
    for is_text, content in cells(script.read_text(encoding="utf-8")):
        assert (content if is_text else f"```python\n{content}\n```") in page
