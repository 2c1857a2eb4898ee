"""The Python blocks of the pages print what the pages show."""

import contextlib
import io
import re
import runpy

import pytest
from experiment_example import ROOT
from printed import same_output

#: A block, and the output that follows it if it prints something.
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n^```text\n(.*?)^```\n)?", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", ["README.md", "docs/use-from-python.md"])
def test_blocks_print_what_the_page_shows(page, tmp_path, monkeypatch):
    (tmp_path / "data").symlink_to(ROOT / "data")
    monkeypatch.chdir(tmp_path)
    blocks = BLOCK.findall((ROOT / page).read_text(encoding="utf-8"))
    assert blocks
    names: dict[str, object] = {}
    for code, shown in blocks:
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(code, page, "exec"), names)
        assert same_output(printed.getvalue(), shown), f"{code}\nprinted\n{printed.getvalue()}"


@pytest.mark.parametrize(
    ("printed", "shown", "same"),
    [
        # Numbers to the last digit.
        ("g1 0.98  True", "g1  0.97 True", True),
        ("[ 0.1 0.06]", "[0.1  0.05]", True),
        ("g1 0.98", "g1 0.96", False),
        ("g1 -0.01", "g1 0.", True),
        ("(2, 501)", "(2, 502)", False),
        ("g1 0.98", "g2 0.98", False),
        ("", "0.98", False),
        # Lines as a whole, or with dots in place of some.
        ("a 1\nb 2\n", "a 1\nb 2\n", True),
        ("a 1\nb 2\n", "a 1\n", False),
        ("a 1\nb 2\n", "a 1\n...\n", True),
        ("a 1\nb 2\nc 3\n", "a 1\n...\nc 3\n", True),
        ("a 1\nb 2\nc 3\n", "a 1\n...\nb 2\n", False),
        ("a 1\nb 2\n", "b 2\n", False),
    ],
)
def test_what_is_printed_is_compared_with_what_is_shown(printed, shown, same):
    assert runpy.run_path(str(ROOT / ".ci/code_blocks.py"))["matches"](printed, shown) is same
