"""The Python blocks of the pages print what the pages show."""

import contextlib
import io
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
#: A block, and the output that follows it if it prints something.
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n^```text\n(.*?)^```\n)?", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"(?<![A-Za-z\d_])-?\d+(?:\.\d*)?")


def same_output(printed: str, shown: str) -> bool:
    """Compare texts without blanks, and decimals to one unit of the last digit: processors round differently."""
    if "".join(NUMBER.sub("#", printed).split()) != "".join(NUMBER.sub("#", shown).split()):
        return False
    pairs = list(zip(NUMBER.findall(printed), NUMBER.findall(shown), strict=True))
    digits = [max(len(number.partition(".")[2]) for number in pair) for pair in pairs]
    return all(
        a == b or (n and abs(float(a) - float(b)) < 1.01 * 10.0**-n) for (a, b), n in zip(pairs, digits, strict=True)
    )


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
        ("g1 0.98  True", "g1  0.97 True", True),
        ("[ 0.1 0.06]", "[0.1  0.05]", True),
        ("g1 0.98", "g1 0.96", False),
        ("g1 -0.01", "g1 0.", True),
        ("(2, 501)", "(2, 502)", False),
        ("g1 0.98", "g2 0.98", False),
        ("0.98", "", False),
    ],
)
def test_outputs_are_compared_to_the_last_digit(printed, shown, same):
    assert same_output(printed, shown) is same
