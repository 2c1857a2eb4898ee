"""Tutorials run as pages show them, and their scripts become pages."""

from pathlib import Path

import pytest
from printed import same_output
from realdata import folder, needs_real_data

from repro.report.tutorial import cells, run_tutorial

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "docs" / "reference" / "tutorials"
SCRIPT = """# %% [markdown]
# # Title
#
# Some *text*.

# %%
import matplotlib.figure

print("one", 2)

# %%
x = 3

# %%
figure = matplotlib.figure.Figure()
print(x)
figure

# %% [markdown]
# The end.
"""


def test_cells_are_run_in_order_and_shown_with_their_outputs(tmp_path):
    script, page = tmp_path / "some.py", tmp_path / "out" / "some.md"
    script.write_text(SCRIPT, encoding="utf-8")
    run_tutorial(script, page)
    blocks = page.read_text(encoding="utf-8").split("\n\n")
    assert [block for block in blocks if block.startswith("```text")] == ["```text\none 2\n```", "```text\n3\n```"]
    assert blocks[-1].strip() == "The end."
    assert blocks[-2] == "![Figure 1](some-1.png)"
    assert (page.parent / "some-1.png").read_bytes().startswith(b"\x89PNG")
    assert not page.with_name("some-2.png").exists()


def test_a_cell_that_fails_leaves_no_page(tmp_path):
    script = tmp_path / "bad.py"
    script.write_text("# %%\n1 / 0\n", encoding="utf-8")
    with pytest.raises(ZeroDivisionError):
        run_tutorial(script, tmp_path / "bad.md")
    assert not (tmp_path / "bad.md").exists()


def shown(page):
    """Outputs of a page."""
    return [block.partition("\n```")[0] for block in page.read_text(encoding="utf-8").split("```text\n")[1:]]


@pytest.mark.parametrize("script", sorted((ROOT / "docs" / "tutorials").glob("*.py")), ids=lambda path: path.stem)
def test_kept_pages_show_the_cells_of_their_scripts(script):
    page = (KEPT / f"{script.stem}.md").read_text(encoding="utf-8")
    for is_text, content in cells(script.read_text(encoding="utf-8")):
        assert (content if is_text else f"```python\n{content}\n```") in page


@pytest.mark.slow
@pytest.mark.parametrize("name", ["board", pytest.param("real-arm", marks=needs_real_data)])
def test_a_tutorial_prints_what_its_page_shows(name, tmp_path, monkeypatch):
    monkeypatch.setenv("REPRO_REALDATA", str(folder()))
    page = tmp_path / f"{name}.md"
    run_tutorial(ROOT / "docs" / "tutorials" / f"{name}.py", page)
    printed, kept = shown(page), shown(KEPT / f"{name}.md")
    assert len(printed) == len(kept)
    for ours, theirs in zip(printed, kept, strict=True):
        assert same_output(ours, theirs), f"printed\n{ours}\nkept\n{theirs}"
